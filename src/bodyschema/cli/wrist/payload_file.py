"""The payload file: one TOML that says which columns hold the wrench and the sensor's motion.

    recording = "log.csv"                   # CSV or Parquet; a list of files is joined row by row
    time = "t"                              # optional: the column of times; "" for postures at rest
    time_unit = "s"                         # or "ms", "us", "ns"

    [wrench]
    columns = ["fx", "fy", "fz", "tx", "ty", "tz"]
    frame = "sensor"                        # axes: "sensor", "flange", "tcp", "base", or a link
    sign = "on_sensor"                      # the load's pull; "on_object": the push on the load
    force_unit = "N"                        # or kN, mN, kgf, gf, lbf
    torque_unit = "Nm"                      # or mNm, Ncm, Nmm, kgfm, kgfcm, lbfin, lbfft
    about = "sensor"                        # origin of the torque; absent: of "frame" or sensor
    bias = "unknown"                        # or "none": tared with nothing on the sensor

    [pose]                                  # the flange in the base; or [joints], [gravity]
    columns = ["x", "y", "z", "qx", "qy", "qz", "qw"]
    layout = "xyz_xyzw"                     # xyz_wxyz, xyz_rpy, xyz_rotvec, matrix3x4, matrix4x4
                                            # (_columns); alone: xyzw, wxyz, rpy, rotvec, matrix3x3
    unit = "m"
    angle_unit = "rad"                      # of rpy and rotvec
    inverse = false                         # columns hold the base seen from the flange
    xyz = [0.0, 0.0, 0.0]                   # m, and rpy in rad: where the frame of the columns sits
                                            # in the flange, if they are those of a tool ("tcp")

    robot = "arm.urdf"                      # instead of [pose], with
    joints = { columns = { elbow = "q3" } } # and unit = "rad" or "deg"

    [gravity]                               # besides or instead, along the sensor's axes
    columns = ["gx", "gy", "gz"]
    unit = "m/s^2"                          # or "g"
    kind = "gravity"                        # points down; "accelerometer" reads up at rest

    [velocity]                              # optional, of the flange; else from the poses;
    columns = ["vx", "vy", "vz"]            # also [acceleration], [angular_velocity],
    unit = "m/s"                            # [angular_acceleration]
    frame = "base"                          # or "sensor"

    [sensor]                                # where it sits
    link = "tool0"                          # with a robot: the link that carries it
    xyz = [0.0, 0.0, 0.0]                   # m, in that link or in the flange
    rpy = [0.0, 0.0, 0.0]                   # rad, fixed axes
    known = "roughly"                       # the turn: "exactly", "roughly" (5 degrees) or "no"
    noise_N = 0.02                          # and noise_Nm: optional, for postures

    [motion]
    kind = "auto"                           # "moving", or "postures": every row at rest
    window = 0.5                            # s that are averaged
    down = [0.0, 0.0, -9.81]                # m/s^2, gravity in the base

    [segments]                              # optional, in the recording's time
    empty = [0.0, 12.0]                     # only the gripper
    loaded = [15.0, 40.0]                   # the gripper and what it holds; also a list of pairs

Paths are relative to the file. Only [wrench] with columns, frame and sign and one source of the
orientation are needed. Instead of [segments], `empty_recording = "empty.csv"` names a recording
with the same columns without the object.
"""

from __future__ import annotations

import tomllib
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from bodyschema.cli.run_file import JointColumns, entry_of
from bodyschema.errors import InputError, did_you_mean

SIGNS = ("on_object", "on_sensor")
KNOWN = ("exactly", "roughly", "no")
MOTIONS = ("auto", "moving", "postures")
BIASES = ("unknown", "none")
OTHERS = ("surface", "touch")


@dataclass(frozen=True)
class WrenchColumns:
    """Force and torque."""

    columns: tuple[str, ...]
    frame: str
    sign: str
    force_unit: str = "N"
    torque_unit: str = "Nm"
    about: str = ""
    bias: str = "unknown"


@dataclass(frozen=True)
class PoseColumns:
    """The flange in the base."""

    columns: tuple[str, ...]
    layout: str = "xyz_xyzw"
    unit: str = "m"
    angle_unit: str = "rad"
    inverse: bool = False
    xyz: tuple[float, ...] = (0.0, 0.0, 0.0)
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class GravityColumns:
    """The way down, along the sensor's axes."""

    columns: tuple[str, ...]
    unit: str = "m/s^2"
    kind: str = "gravity"


@dataclass(frozen=True)
class VectorColumns:
    """A velocity or an acceleration."""

    columns: tuple[str, ...]
    unit: str = ""
    frame: str = "base"


@dataclass(frozen=True)
class SensorEntry:
    """Where the sensor sits, and its noise if it is known."""

    link: str = ""
    xyz: tuple[float, ...] = (0.0, 0.0, 0.0)
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)
    known: str = "roughly"
    noise_N: float | None = None
    noise_Nm: float | None = None


@dataclass(frozen=True)
class MotionEntry:
    """How the motion is read."""

    kind: str = "auto"
    window: float = 0.5
    down: tuple[float, ...] = (0.0, 0.0, -9.81)


@dataclass(frozen=True)
class Segments:
    """Which times belong to the gripper alone, and which to gripper and object."""

    empty: tuple[Any, ...] = ()
    loaded: tuple[Any, ...] = ()


@dataclass(frozen=True)
class PayloadFile:
    """A whole run, resolved."""

    recording: tuple[str, ...]
    wrench: WrenchColumns
    time: str | None = None
    time_unit: str = "s"
    robot: str = ""
    empty_recording: str = ""
    joints: JointColumns = field(default_factory=JointColumns)
    pose: PoseColumns | None = None
    gravity: GravityColumns | None = None
    velocity: VectorColumns | None = None
    acceleration: VectorColumns | None = None
    angular_velocity: VectorColumns | None = None
    angular_acceleration: VectorColumns | None = None
    sensor: SensorEntry = field(default_factory=SensorEntry)
    motion: MotionEntry = field(default_factory=MotionEntry)
    segments: Segments = field(default_factory=Segments)


TABLES: dict[str, type[Any]] = {
    "wrench": WrenchColumns,
    "joints": JointColumns,
    "pose": PoseColumns,
    "gravity": GravityColumns,
    "velocity": VectorColumns,
    "acceleration": VectorColumns,
    "angular_velocity": VectorColumns,
    "angular_acceleration": VectorColumns,
    "sensor": SensorEntry,
    "motion": MotionEntry,
    "segments": Segments,
}


def read_payload_file(path: Path) -> PayloadFile:
    """Read a payload file but for what `bodyschema touch` adds; its paths come back absolute.

    Raises:
        InputError: missing, malformed, a key unknown or missing.
    """
    try:
        table: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError:
        raise InputError(f"no payload file at '{path}'; give the path of a TOML file.") from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"'{path}' is not valid TOML: {error}.") from None
    here, where = path.resolve().parent, f"'{path.name}'"
    entries = {name: value for name, value in table.items() if name not in OTHERS}
    for name, kind in TABLES.items():
        if name in table:
            if not isinstance(table[name], dict):
                raise InputError(f"{name} in {where} must be a table, [{name}].")
            entries[name] = entry_of(kind, table[name], f"[{name}] of {where}")
    files = table.get("recording", [])
    named = [files] if isinstance(files, str) else list(files)
    if named:
        entries["recording"] = [str(here / one) for one in named]
    for key in ("robot", "empty_recording"):
        if table.get(key):
            entries[key] = str(here / table[key])
    run = entry_of(PayloadFile, entries, where)
    _check(run, where)
    return run


def _check(run: PayloadFile, where: str) -> None:
    """Refuse words that mean nothing, and runs that do not say where down is."""
    chosen = (
        ("sign", run.wrench.sign, SIGNS),
        ("bias", run.wrench.bias, BIASES),
        ("about", run.wrench.about or "sensor", ("sensor", "flange", "tcp", "base")),
        ("known", run.sensor.known, KNOWN),
        ("kind", run.motion.kind, MOTIONS),
    )
    for key, word, known in chosen:
        if word not in known:
            raise InputError(f"{key} = '{word}' in {where}{did_you_mean(word, known)}")
    counted: list[tuple[str, tuple[Any, ...], int]] = [("wrench", run.wrench.columns, 6)]
    vectors = ("gravity", "velocity", "acceleration", "angular_velocity", "angular_acceleration")
    for name in vectors:
        entry = getattr(run, name)
        counted += [(name, entry.columns, 3)] if entry else []
    for place in (run.sensor, run.pose or run.sensor):
        counted += [("xyz", place.xyz, 3), ("rpy", place.rpy, 3)]
    for name, values, count in (*counted, ("down", run.motion.down, 3)):
        if len(values) != count:
            raise InputError(f"[{name}] of {where} needs {count} entries, it has {len(values)}.")
    if not (run.pose or run.gravity or run.robot):
        raise InputError(
            f"{where} does not say how the sensor is turned: add [pose] with its columns, or robot "
            "and [joints], or [gravity]."
        )
    if run.robot and not run.pose and not run.sensor.link:
        raise InputError(
            f"{where} names a robot: say which link carries the sensor, [sensor] link."
        )
    if not run.motion.window > 0:
        raise InputError(f"window = {run.motion.window:g} in {where} must be above zero.")
