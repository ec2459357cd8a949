"""From a declared recording to samples of the wrist: SI, in the sensor's frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError, did_you_mean
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.senses.wrist_declaration import VectorColumns, WristDeclaration
from bodyschema.senses.wrist_poses import pose_columns, tool
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.sources.physical_units import (
    ACCELERATIONS,
    FORCES,
    SPEEDS,
    TORQUES,
    TURNINGS,
    TURNS,
    factor,
)
from bodyschema.sources.recording import TIME_COLUMNS, UNITS, Recording

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

TIME_UNITS = ("s", "ms", "us", "ns")


@dataclass(frozen=True)
class WristRecording:
    """What was read."""

    samples: WristSamples
    """With the sensor's frame turned as it is believed to be (the mount)."""
    moving: bool
    """Whether there is a clock, so that rows are moments of a motion."""
    notes: tuple[str, ...]
    """Sentences on what was assumed."""
    rows: NDArray[np.int64]
    """(n,) of the recording, of each sample."""


@dataclass(frozen=True)
class WristTable:
    """A recording of a wrist sensor, before anything is said of its columns."""

    recording: Recording
    body: Body | None = None
    """The robot, where its joints tell the motion, or a frame of it is named."""
    q: Array | None = None
    """(n_rows, n_joints) its joint readings, rad and m."""

    def read(self, declared: WristDeclaration) -> WristRecording:
        """The samples, if the columns hold what is declared.

        Raises:
            InputError: anything in them that cannot be used, in one sentence.
        """
        return read_wrist(self, declared)


def read_wrist(table: WristTable, declared: WristDeclaration) -> WristRecording:
    """See `WristTable.read`."""
    recording = table.recording
    clocked, time = _times(declared, recording)
    wrench, seen = recording.matrix(declared.wrench.columns, "1")
    (poses, there), body = _poses(declared, table), table.body
    vectors, notes = {}, list[str]()
    for name, units in (
        ("velocity", SPEEDS), ("acceleration", ACCELERATIONS),
        ("angular_velocity", TURNS), ("angular_acceleration", TURNINGS),
    ):  # fmt: skip
        entry: VectorColumns | None = getattr(declared, name)
        if entry is not None:
            vectors[name], filled = _vector(entry, units, recording, name)
            seen &= filled
    down = np.asarray(declared.down, dtype=np.float64)
    gravity = None
    if declared.gravity is not None:
        read, filled = recording.matrix(declared.gravity.columns, "1")
        gravity = factor(declared.gravity.unit, ACCELERATIONS) * read
        seen &= filled
        _check_strength(gravity[filled], down, declared.gravity.unit)
        if declared.gravity.kind == "accelerometer":
            gravity = -gravity
        elif declared.gravity.kind != "gravity":
            raise InputError(
                f"kind = '{declared.gravity.kind}' under [gravity]"
                f"{did_you_mean(declared.gravity.kind, ('gravity', 'accelerometer'))}"
            )
    rows = np.flatnonzero(seen & there)
    if len(rows) < 2:
        raise InputError(
            f"{recording.source} has {len(rows)} rows with both wrench and orientation; at least "
            "two are needed."
        )
    T = None if poses is None else poses[rows] @ _mount(declared)
    wrench = _to_sensor(declared, wrench[rows], None if poses is None else poses[rows], body)
    placed = T is not None and bool(np.any(T[:, :3, 3]))
    carried = declared.gravity is not None and declared.gravity.kind == "accelerometer"
    if clocked and not (placed or carried or {"velocity", "acceleration"} & set(vectors)):
        notes.append("nothing tells the sensor's acceleration; it counts as zero.")
    kept = {name: values[rows] for name, values in vectors.items()}
    kept = _along(declared, kept, T)
    samples = WristSamples(
        time=time[rows],
        wrench=wrench,
        rotation=None if T is None else T[:, :3, :3],
        position=None if T is None else T[:, :3, 3],
        gravity=None if gravity is None else gravity[rows],
        carried=carried,
        down=(float(down[0]), float(down[1]), float(down[2])),
        **kept,
    )
    return WristRecording(samples, clocked, tuple(notes), rows)


def _times(declared: WristDeclaration, recording: Recording) -> tuple[bool, Array]:
    known = {*recording.columns, *recording.texts}
    clocked = declared.time != "" and (
        declared.time is not None or any(c in known for c in TIME_COLUMNS)
    )
    if declared.time_unit not in TIME_UNITS:
        hint = did_you_mean(declared.time_unit, TIME_UNITS)
        raise InputError(f"time_unit = '{declared.time_unit}'{hint}")
    time = recording.time(declared.time)
    return clocked, time * (UNITS[declared.time_unit] if clocked else 1.0)


def _check_strength(gravity: Array, down: Array, unit: str) -> None:
    """Gravity in a wrong unit would be mass in a wrong unit."""
    felt, there = float(np.median(np.linalg.norm(gravity, axis=1))), float(np.linalg.norm(down))
    if not 0.5 * there < felt < 2 * there:
        raise InputError(
            f"[gravity] is {felt:.4g} m/s^2 long where {there:.4g} is expected: its unit was "
            f'"{unit}"; write unit = "g" for columns of length 1, or check the columns.'
        )


def _mount(declared: WristDeclaration) -> Array:
    """T_flange_sensor as believed."""
    return lie.transform(lie.rotation_from_rpy(declared.sensor.rpy), declared.sensor.xyz)


def _poses(declared: WristDeclaration, table: WristTable) -> tuple[Array | None, Flags]:
    """T_base_flange (n, 4, 4), and the rows where it is known."""
    everywhere = np.ones(len(table.recording), dtype=bool)
    if declared.pose is not None:
        values, present = table.recording.matrix(declared.pose.columns, "1")
        poses = np.tile(np.eye(4), (len(table.recording), 1, 1))
        poses[present] = pose_columns(values[present], declared.pose)
        return poses, present
    body, q = table.body, table.q
    if body is not None and q is not None:
        return relative_pose(body, q, body.frames[0], declared.sensor.link), everywhere
    return None, everywhere


def _vector(
    entry: VectorColumns, units: Mapping[str, float], recording: Recording, name: str
) -> tuple[Array, Flags]:
    if entry.frame not in ("base", "sensor"):
        raise InputError(
            f"frame = '{entry.frame}' under [{name}]{did_you_mean(entry.frame, ('base', 'sensor'))}"
        )
    values, present = recording.matrix(entry.columns, "1")
    return factor(entry.unit or next(iter(units)), units) * values, present


def _along(
    declared: WristDeclaration, vectors: dict[str, Array], T_base_sensor: Array | None
) -> dict[str, Array]:
    """Translations along the base's axes and turns along the sensor's, as `WristSamples` has it."""
    out = {}
    for name, values in vectors.items():
        wanted = "sensor" if name.startswith("angular") else "base"
        frame = getattr(declared, name).frame
        if frame == wanted:
            out[name] = values
            continue
        if T_base_sensor is None:
            raise InputError(
                f"[{name}] along the {frame}'s axes needs the sensor's orientation; "
                f"give [pose], or the columns along the {wanted}'s axes."
            )
        R = T_base_sensor[:, :3, :3]
        R = R if wanted == "base" else np.swapaxes(R, 1, 2)
        out[name] = (R @ values[..., None])[..., 0]
    if any(declared.sensor.xyz) and ({"velocity", "acceleration"} & set(out)):
        raise InputError(
            "[velocity] and [acceleration] are the flange's, but [sensor] xyz puts the sensor "
            "elsewhere; leave them out, they are then read from the poses."
        )
    return out


def _to_sensor(
    declared: WristDeclaration, wrench: Array, flange: Array | None, body: Body | None
) -> Array:
    """(n, 6) N and Nm by the sensor on the object, along the sensor's axes, about its origin."""
    entry = declared.wrench
    sign = 1.0 if entry.sign == "on_object" else -1.0
    f = sign * factor(entry.force_unit, FORCES) * wrench[:, :3]
    tau = sign * factor(entry.torque_unit, TORQUES) * wrench[:, 3:]
    about = entry.about or ("sensor" if entry.frame == "base" else entry.frame)
    R = _in_sensor(declared, entry.frame, flange, body)[..., :3, :3]
    p = _in_sensor(declared, about, flange, body)[..., :3, 3]
    f_s = (R @ f[..., None])[..., 0]
    return np.hstack([f_s, (R @ tau[..., None])[..., 0] + np.cross(p, f_s)])


def _in_sensor(
    declared: WristDeclaration, frame: str, flange: Array | None, body: Body | None
) -> Array:
    """T_sensor_frame, (4, 4) or one a row, of a frame that a wrench is written in."""
    if frame == "sensor":
        return np.eye(4)
    if frame == "base":
        if flange is None:
            raise InputError(
                "a wrench along the axes or about the origin of 'base' needs the sensor's "
                "orientation: add [pose], or robot and [joints]."
            )
        return np.asarray(lie.inverse(flange @ _mount(declared)))
    here = np.asarray(lie.inverse(_mount(declared)))
    if frame == "flange":
        return here
    if frame == "tcp" and declared.pose is not None:
        return here @ tool(declared.pose)
    if body is None or declared.pose is not None:
        known = ("sensor", "flange", *(["tcp"] if declared.pose else []), "base")
        raise InputError(f"frame or about = '{frame}'{did_you_mean(frame, known)}")
    return _link_in_sensor(declared, body, body.frame_index(frame))


def _link_in_sensor(declared: WristDeclaration, body: Body, link: int) -> Array:
    """T_sensor_link of a link that does not move against the sensor."""
    low, high = np.zeros(len(body.joints)), np.full(len(body.joints), 0.3)
    name = body.frames[link]
    ends = [relative_pose(body, q, declared.sensor.link, name) for q in (low, high)]
    if np.abs(ends[0] - ends[1]).max() > 1e-9:
        raise InputError(
            f"link '{name}' moves against the sensor's link '{declared.sensor.link}'; a wrench is "
            'written in a frame that the sensor carries, or in "base".'
        )
    return np.asarray(lie.inverse(_mount(declared)) @ ends[0])
