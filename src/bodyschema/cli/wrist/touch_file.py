"""The touch file: a payload file (`payload_file`) that also says what shape the object has.

    [surface]                               # along the sensor's axes, from its origin
    box = [0.10, 0.12, 0.18]                # m; or cylinder = [radius, length], its axis along z;
                                            # or ball = [radius]; or mesh = "cup.stl";
                                            # or link = "cup" of the robot
    scale = 0.001                           # of a mesh: m of one of its units; 1 when absent
    xyz = [0.0, 0.0, 0.09]                  # m, where the shape's own frame is; with a link it is
    rpy = [0.0, 0.0, 0.0]                   # rad                     where the robot has it

    [touch]
    quiet = [0.0, 20.0]                     # s of the recording: motion without any touch
    gains = 0.01                            # share by which each reading may be off; 0 for none
    false_per_hour = 0.1                    # touches that may be felt where there are none
    window = 0.25                           # s that are averaged

Without [surface] the places of touches are told only as far as their forces tell them.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bodyschema import lie
from bodyschema.cli.run_file import entry_of
from bodyschema.cli.wrist.payload_file import PayloadFile, read_payload_file
from bodyschema.errors import InputError
from bodyschema.model.solid import Solid
from bodyschema.model.tree import Body

SHAPES = ("box", "cylinder", "ball", "mesh", "link")


@dataclass(frozen=True)
class SurfaceEntry:
    """The object."""

    box: tuple[float, ...] = ()
    cylinder: tuple[float, ...] = ()
    ball: tuple[float, ...] = ()
    mesh: str = ""
    link: str = ""
    scale: float = 1.0
    xyz: tuple[float, ...] = (0.0, 0.0, 0.0)
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class TouchEntry:
    """How touches are looked for."""

    quiet: tuple[float, ...]
    gains: float = 0.01
    false_per_hour: float = 0.1
    window: float = 0.25


@dataclass(frozen=True)
class TouchFile:
    """A whole run, resolved."""

    run: PayloadFile
    touch: TouchEntry
    surface: SurfaceEntry | None = None
    folder: Path = field(default_factory=Path)
    """That the mesh is relative to."""


def read_touch_file(path: Path) -> TouchFile:
    """Read a touch file.

    Raises:
        InputError: missing, malformed, a key unknown or missing.
    """
    run = read_payload_file(path)
    table: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
    where = f"'{path.name}'"
    if not isinstance(table.get("touch"), dict) or "quiet" not in table["touch"]:
        raise InputError(
            f"{where} does not say when nothing touches: add [touch] with quiet = [from, to] in s, "
            "ten seconds or more of motion with the object."
        )
    touch = entry_of(TouchEntry, table["touch"], f"[touch] of {where}")
    if len(touch.quiet) != 2 or not touch.quiet[0] < touch.quiet[1]:
        raise InputError(f"quiet in {where} must be [from, to] in s; got {list(touch.quiet)}.")
    if not (0 <= touch.gains < 1 and touch.false_per_hour > 0 and touch.window > 0):
        raise InputError(
            f"[touch] of {where}: gains is a share from 0 to 1, false_per_hour and window are "
            "above 0."
        )
    surface = None
    if "surface" in table:
        if not isinstance(table["surface"], dict):
            raise InputError(f"surface in {where} must be a table, [surface].")
        surface = entry_of(SurfaceEntry, table["surface"], f"[surface] of {where}")
        named = [shape for shape in SHAPES if getattr(surface, shape)]
        if len(named) != 1:
            raise InputError(
                f"[surface] of {where} names {' and '.join(named) or 'no shape'}; give one of "
                f"{', '.join(SHAPES)}."
            )
    return TouchFile(run, touch, surface, path.resolve().parent)


def solid_of(file: TouchFile) -> Solid | None:
    """The object's shape in the sensor's frame; None if the file names none.

    Raises:
        InputError: the shape makes no sense, or its mesh or link cannot be read.
        MissingExtraError: trimesh is not installed.
    """
    entry, run = file.surface, file.run
    if entry is None:
        return None
    if len(entry.xyz) != 3 or len(entry.rpy) != 3:
        raise InputError("xyz and rpy under [surface] have three entries each.")
    T = lie.transform(lie.rotation_from_rpy(entry.rpy), entry.xyz)
    if entry.link:
        if not (run.robot and run.sensor.link):
            raise InputError("a [surface] link needs robot, and the link under [sensor].")
        body = Body.from_urdf(run.robot)
        T_link_sensor = lie.transform(lie.rotation_from_rpy(run.sensor.rpy), run.sensor.xyz)
        sensor = "the sensor of the touch file"
        return Solid.from_link(
            body.attach(sensor, run.sensor.link, T_link_sensor), entry.link, sensor
        )
    if entry.mesh:
        return Solid.from_mesh(file.folder / entry.mesh, entry.scale, T)
    if entry.box:
        return Solid.box(entry.box, T)
    if entry.ball:
        (radius,) = _numbers(entry.ball, 1, "ball = [radius]")
        return Solid.ball(radius, T)
    radius, length = _numbers(entry.cylinder, 2, "cylinder = [radius, length]")
    return Solid.cylinder(radius, length, T)


def _numbers(values: tuple[float, ...], count: int, form: str) -> tuple[float, ...]:
    if len(values) != count:
        raise InputError(f"[surface] needs {form} in m; got {list(values)}.")
    return values
