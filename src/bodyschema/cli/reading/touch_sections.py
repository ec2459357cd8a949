"""Sections of a run file that say what shape a wrist's load has, and when nothing touches it.

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

from dataclasses import dataclass
from typing import TYPE_CHECKING

from bodyschema.errors import InputError

if TYPE_CHECKING:
    from bodyschema.cli.run_file import RunFile
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

    quiet: tuple[float, ...] = ()
    gains: float = 0.01
    false_per_hour: float = 0.1
    window: float = 0.25


def check_touch(run: RunFile, where: str) -> None:
    """Refuse runs that do not say when nothing touches, and settings that mean nothing.

    Raises:
        InputError: in one sentence.
    """
    touch = None if run.wrist is None else run.wrist.touch
    if touch is None or not touch.quiet:
        raise InputError(
            f"{where} does not say when nothing touches: add [touch] with quiet = [from, to] in s, "
            "ten seconds or more of motion with the object."
        )
    if len(touch.quiet) != 2 or not touch.quiet[0] < touch.quiet[1]:
        raise InputError(f"quiet in {where} must be [from, to] in s; got {list(touch.quiet)}.")
    if not (0 <= touch.gains < 1 and touch.false_per_hour > 0 and touch.window > 0):
        raise InputError(
            f"[touch] of {where}: gains is a share from 0 to 1, false_per_hour and window are "
            "above 0."
        )
    surface = None if run.wrist is None else run.wrist.surface
    if surface is not None:
        named = [shape for shape in SHAPES if getattr(surface, shape)]
        if len(named) != 1:
            raise InputError(
                f"[surface] of {where} names {' and '.join(named) or 'no shape'}; give one of "
                f"{', '.join(SHAPES)}."
            )


def solid_of(run: RunFile, body: Body | None) -> Solid | None:
    """The object's shape in the sensor's frame; None if the file names none.

    Args:
        run: with a wrist.
        body: the robot; None if there is no description.

    Raises:
        InputError: the shape makes no sense, or its mesh or link cannot be read.
        MissingExtraError: trimesh is not installed.
    """
    from bodyschema import lie
    from bodyschema.model.solid import Solid

    if run.wrist is None or run.wrist.surface is None:
        return None
    entry, place = run.wrist.surface, run.wrist.sensor
    if len(entry.xyz) != 3 or len(entry.rpy) != 3:
        raise InputError("xyz and rpy under [surface] have three entries each.")
    T = lie.transform(lie.rotation_from_rpy(entry.rpy), entry.xyz)
    if entry.link:
        if body is None or not place.link:
            raise InputError("a [surface] link needs robot, and the link under [sensor].")
        T_link_sensor = lie.transform(lie.rotation_from_rpy(place.rpy), place.xyz)
        sensor = "the sensor of the run file"
        return Solid.from_link(body.attach(sensor, place.link, T_link_sensor), entry.link, sensor)
    if entry.mesh:
        return Solid.from_mesh(entry.mesh, entry.scale, T)
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
