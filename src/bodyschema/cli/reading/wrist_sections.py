"""Sections of a run file for a wrist's sensor: which columns hold the wrench and its motion.

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
with the same columns without the object. Where touches are looked for, see `touch_sections`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bodyschema.cli.reading.touch_sections import SurfaceEntry, TouchEntry
from bodyschema.errors import InputError, did_you_mean
from bodyschema.senses.wrist_declaration import (
    GravityColumns,
    LoadSegments,
    MotionReading,
    PoseColumns,
    SensorPlace,
    VectorColumns,
    WrenchColumns,
    WristDeclaration,
)

if TYPE_CHECKING:
    from bodyschema.cli.run_file import RunFile
    from bodyschema.model.tree import Body
    from bodyschema.senses.wrist_columns import WristTable

MOTIONS = ("auto", "moving", "postures")


@dataclass(frozen=True)
class WristSections:
    """What a run file says of a wrist's sensor."""

    wrench: WrenchColumns
    time_unit: str = "s"
    empty_recording: str = ""
    pose: PoseColumns | None = None
    gravity: GravityColumns | None = None
    velocity: VectorColumns | None = None
    acceleration: VectorColumns | None = None
    angular_velocity: VectorColumns | None = None
    angular_acceleration: VectorColumns | None = None
    sensor: SensorPlace = field(default_factory=SensorPlace)
    motion: MotionReading = field(default_factory=MotionReading)
    segments: LoadSegments = field(default_factory=LoadSegments)
    surface: SurfaceEntry | None = None
    touch: TouchEntry | None = None

    @property
    def files(self) -> list[str]:
        """That were read besides the recording."""
        mesh = "" if self.surface is None else self.surface.mesh
        return [name for name in (self.empty_recording, mesh) if name]

    def declared(self, time: str | None) -> WristDeclaration:
        """What the columns hold; `time` names that of the times."""
        return WristDeclaration(
            self.wrench,
            self.pose,
            self.gravity,
            self.velocity,
            self.acceleration,
            self.angular_velocity,
            self.angular_acceleration,
            self.sensor,
            self.motion.down,
            time,
            self.time_unit,
        )


SECTIONS: dict[str, type[Any]] = {
    "wrench": WrenchColumns,
    "pose": PoseColumns,
    "gravity": GravityColumns,
    "velocity": VectorColumns,
    "acceleration": VectorColumns,
    "angular_velocity": VectorColumns,
    "angular_acceleration": VectorColumns,
    "sensor": SensorPlace,
    "motion": MotionReading,
    "segments": LoadSegments,
    "surface": SurfaceEntry,
    "touch": TouchEntry,
}
KEYS = ("time_unit", "empty_recording")
"""Outside of any section."""


def read_sections(table: Mapping[str, Any], here: Path, where: str) -> WristSections:
    """The sections of a run file.

    Args:
        table: those of `SECTIONS` and `KEYS` that it has.
        here: anchors its paths.
        where: names it in messages.

    Raises:
        InputError: a key is unknown or missing, or there is no wrench.
    """
    from bodyschema.cli.entry_types import entry_of

    entries = dict(table)
    for name, kind in SECTIONS.items():
        if table.get(name) is not None:
            if not isinstance(table[name], Mapping):
                raise InputError(f"{name} in {where} must be a table, [{name}].")
            entries[name] = entry_of(kind, table[name], f"[{name}] of {where}")
    if "wrench" not in entries:
        first = next(iter(table))
        raise InputError(
            f"{where} has '{first}' without [wrench]: add it with columns, frame and sign."
        )
    empty = table.get("empty_recording")
    if isinstance(empty, str) and empty:
        entries["empty_recording"] = str(here / empty)
    surface: SurfaceEntry | None = entries.get("surface")
    if surface is not None and surface.mesh:
        entries["surface"] = replace(surface, mesh=str(here / surface.mesh))
    return entry_of(WristSections, entries, where)


def check_wrist(run: RunFile, where: str) -> None:
    """Refuse runs that do not say where down is, and settings that mean nothing.

    Raises:
        InputError: in one sentence.
    """
    wrist = run.wrist
    if wrist is None:
        raise InputError(
            f"{where} does not say which columns hold the wrench: add [wrench] with columns, frame "
            "and sign."
        )
    if wrist.motion.kind not in MOTIONS:
        raise InputError(
            f"kind = '{wrist.motion.kind}' in [motion] of {where}"
            f"{did_you_mean(wrist.motion.kind, MOTIONS)}"
        )
    if not wrist.motion.window > 0:
        raise InputError(f"window = {wrist.motion.window:g} in {where} must be above zero.")
    if not (wrist.pose or wrist.gravity or run.robot):
        raise InputError(
            f"{where} does not say how the sensor is turned: add [pose] with its columns, or robot "
            "and [joints], or [gravity]."
        )
    if run.robot and not wrist.pose and not wrist.sensor.link:
        raise InputError(
            f"{where} names a robot: say which link carries the sensor, [sensor] link."
        )
    wrist.declared(run.time)


def wrist_table(run: RunFile, files: tuple[str, ...], body: Body | None) -> WristTable:
    """A recording of the run, with the robot's readings where they tell the motion.

    Args:
        run: with a wrist.
        files: that are joined row by row.
        body: the robot; None if there is no description.

    Raises:
        InputError: a file or a joint's column cannot be read.
    """
    from bodyschema.cli.reading.joints import read_joints, refuse_missing
    from bodyschema.senses.wrist_columns import WristTable
    from bodyschema.sources.tables import open_recording

    recording, wrist = open_recording(list(files)), run.wrist
    if body is None or wrist is None or wrist.pose is not None:
        return WristTable(recording, body)
    refuse_missing(body, recording, run.joints, joints_to(body, wrist.sensor.link))
    return WristTable(recording, body, read_joints(body, recording, run.joints))


def joints_to(body: Body, link: str) -> tuple[str, ...]:
    """Joints between the root and a link."""
    k, found = body.frame_index(link), list[str]()
    while k > 0:
        if body.driver[k] >= 0:
            found.append(body.joints[int(body.driver[k])])
        k = int(body.parent[k])
    return tuple(dict.fromkeys(reversed(found)))


def held_tables(
    run: RunFile,
) -> tuple[WristTable, WristTable | None, WristDeclaration, WristSections]:
    """The recording of a run, the one without the object if there is one, and what is declared.

    Raises:
        InputError: the robot, a file or a column cannot be read.
    """
    from bodyschema.cli.reading.robot import robot_of

    wrist = run.wrist
    if wrist is None:
        raise InputError("the run does not say which columns hold the wrench; add [wrench].")
    body = robot_of(run) if run.robot else None
    table = wrist_table(run, run.recording, body)
    empty = wrist_table(run, (wrist.empty_recording,), body) if wrist.empty_recording else None
    return table, empty, wrist.declared(run.time), wrist
