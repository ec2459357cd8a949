"""From a payload file and its recording to samples of the wrist: SI, in the sensor's frame."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.cli.loading import read_joints, read_robot
from bodyschema.cli.wrist.payload_file import PayloadFile, VectorColumns
from bodyschema.cli.wrist.physical_units import (
    ACCELERATIONS,
    FORCES,
    SPEEDS,
    TORQUES,
    TURNINGS,
    TURNS,
    factor,
)
from bodyschema.cli.wrist.pose_columns import pose_columns, tool
from bodyschema.errors import InputError, did_you_mean
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.sources.recording import TIME_COLUMNS, UNITS, Recording
from bodyschema.sources.tables import open_recording

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class WristRecording:
    """What was read."""

    samples: WristSamples
    """With the sensor's frame turned as it is believed to be (the mount)."""
    moving: bool
    """Whether there is a clock, so that rows are moments of a motion."""
    notes: tuple[str, ...]
    """Sentences on what was assumed."""


def read_wrist(run: PayloadFile, files: Sequence[str]) -> WristRecording:
    """Read one recording of a run.

    Raises:
        InputError: anything in it that cannot be used, in one sentence.
    """
    recording = open_recording(list(files))
    clocked, time = _times(run, recording)
    wrench, seen = recording.matrix(run.wrench.columns, "1")
    poses, body, there = _poses(run, recording)
    vectors, notes = {}, list[str]()
    for name, units in (
        ("velocity", SPEEDS), ("acceleration", ACCELERATIONS),
        ("angular_velocity", TURNS), ("angular_acceleration", TURNINGS),
    ):  # fmt: skip
        entry: VectorColumns | None = getattr(run, name)
        if entry is not None:
            vectors[name], filled = _vector(entry, units, recording, name)
            seen &= filled
    down = np.asarray(run.motion.down, dtype=np.float64)
    gravity = None
    if run.gravity is not None:
        read, filled = recording.matrix(run.gravity.columns, "1")
        gravity = factor(run.gravity.unit, ACCELERATIONS) * read
        seen &= filled
        _check_strength(gravity[filled], down, run.gravity.unit)
        if run.gravity.kind == "accelerometer":
            gravity = -gravity
        elif run.gravity.kind != "gravity":
            raise InputError(
                f"kind = '{run.gravity.kind}' under [gravity]"
                f"{did_you_mean(run.gravity.kind, ('gravity', 'accelerometer'))}"
            )
    rows = np.flatnonzero(seen & there)
    if len(rows) < 2:
        raise InputError(
            f"{recording.source} has {len(rows)} rows with both wrench and orientation; at least "
            "two are needed."
        )
    T = None if poses is None else poses[rows] @ _mount(run)
    wrench = _to_sensor(run, wrench[rows], None if poses is None else poses[rows], body)
    placed = T is not None and bool(np.any(T[:, :3, 3]))
    carried = run.gravity is not None and run.gravity.kind == "accelerometer"
    if clocked and not (placed or carried or {"velocity", "acceleration"} & set(vectors)):
        notes.append("nothing tells the sensor's acceleration; it counts as zero.")
    kept = {name: values[rows] for name, values in vectors.items()}
    kept = _along(run, kept, T)
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
    return WristRecording(samples, clocked, tuple(notes))


def _times(run: PayloadFile, recording: Recording) -> tuple[bool, Array]:
    known = {*recording.columns, *recording.texts}
    clocked = run.time != "" and (run.time is not None or any(c in known for c in TIME_COLUMNS))
    if run.time_unit not in ("s", "ms", "us", "ns"):
        raise InputError(
            f"time_unit = '{run.time_unit}'{did_you_mean(run.time_unit, ('s', 'ms', 'us', 'ns'))}"
        )
    time = recording.time(run.time)
    return clocked, time * (UNITS[run.time_unit] if clocked else 1.0)


def _check_strength(gravity: Array, down: Array, unit: str) -> None:
    """Gravity in a wrong unit would be mass in a wrong unit."""
    felt, there = float(np.median(np.linalg.norm(gravity, axis=1))), float(np.linalg.norm(down))
    if not 0.5 * there < felt < 2 * there:
        raise InputError(
            f"[gravity] is {felt:.4g} m/s^2 long where {there:.4g} is expected: its unit was "
            f'"{unit}"; write unit = "g" for columns of length 1, or check the columns.'
        )


def _mount(run: PayloadFile) -> Array:
    """T_flange_sensor as believed."""
    return lie.transform(lie.rotation_from_rpy(run.sensor.rpy), run.sensor.xyz)


def _poses(run: PayloadFile, recording: Recording) -> tuple[Array | None, Body | None, Flags]:
    """T_base_flange (n, 4, 4), the robot, and the rows where it is known."""
    everywhere = np.ones(len(recording), dtype=bool)
    body = read_robot(Path(run.robot)) if run.robot else None
    if run.pose is not None:
        values, present = recording.matrix(run.pose.columns, "1")
        poses = np.tile(np.eye(4), (len(recording), 1, 1))
        poses[present] = pose_columns(values[present], run.pose)
        return poses, body, present
    if body is not None:
        _refuse_unread(run, body, recording)
        q = read_joints(body, recording, run.joints)
        return relative_pose(body, q, body.frames[0], run.sensor.link), body, everywhere
    return None, None, everywhere


def _refuse_unread(run: PayloadFile, body: Body, recording: Recording) -> None:
    """Joints between base and sensor must have columns."""
    k = body.frame_index(run.sensor.link)
    while k > 0:
        j = int(body.driver[k])
        if j >= 0:
            joint = body.joints[j]
            column = run.joints.columns.get(joint, joint)
            if column not in recording.columns:
                raise InputError(
                    f"no column for joint {joint} in {recording.source}"
                    f"{did_you_mean(column, recording.columns)} Name it under [joints] columns = "
                    f'{{ {joint} = "..." }}.'
                )
        k = int(body.parent[k])


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
    run: PayloadFile, vectors: dict[str, Array], T_base_sensor: Array | None
) -> dict[str, Array]:
    """Translations along the base's axes and turns along the sensor's, as `WristSamples` has it."""
    out = {}
    for name, values in vectors.items():
        wanted = "sensor" if name.startswith("angular") else "base"
        frame = getattr(run, name).frame
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
    if any(run.sensor.xyz) and ({"velocity", "acceleration"} & set(out)):
        raise InputError(
            "[velocity] and [acceleration] are the flange's, but [sensor] xyz puts the sensor "
            "elsewhere; leave them out, they are then read from the poses."
        )
    return out


def _to_sensor(run: PayloadFile, wrench: Array, flange: Array | None, body: Body | None) -> Array:
    """(n, 6) N and Nm by the sensor on the object, along the sensor's axes, about its origin."""
    entry = run.wrench
    sign = 1.0 if entry.sign == "on_object" else -1.0
    f = sign * factor(entry.force_unit, FORCES) * wrench[:, :3]
    tau = sign * factor(entry.torque_unit, TORQUES) * wrench[:, 3:]
    about = entry.about or ("sensor" if entry.frame == "base" else entry.frame)
    R = _in_sensor(run, entry.frame, flange, body)[..., :3, :3]
    p = _in_sensor(run, about, flange, body)[..., :3, 3]
    f_s = (R @ f[..., None])[..., 0]
    return np.hstack([f_s, (R @ tau[..., None])[..., 0] + np.cross(p, f_s)])


def _in_sensor(run: PayloadFile, frame: str, flange: Array | None, body: Body | None) -> Array:
    """T_sensor_frame, (4, 4) or one a row, of a frame that a wrench is written in."""
    if frame == "sensor":
        return np.eye(4)
    if frame == "base":
        if flange is None:
            raise InputError(
                "a wrench along the axes or about the origin of 'base' needs the sensor's "
                "orientation: add [pose], or robot and [joints]."
            )
        return np.asarray(lie.inverse(flange @ _mount(run)))
    here = np.asarray(lie.inverse(_mount(run)))
    if frame == "flange":
        return here
    if frame == "tcp" and run.pose is not None:
        return here @ tool(run.pose)
    if body is None or run.pose is not None:
        known = ("sensor", "flange", *(["tcp"] if run.pose else []), "base")
        raise InputError(f"frame or about = '{frame}'{did_you_mean(frame, known)}")
    return _link_in_sensor(run, body, body.frame_index(frame))


def _link_in_sensor(run: PayloadFile, body: Body, link: int) -> Array:
    """T_sensor_link of a link that does not move against the sensor."""
    low, high = np.zeros(len(body.joints)), np.full(len(body.joints), 0.3)
    name = body.frames[link]
    ends = [relative_pose(body, q, run.sensor.link, name) for q in (low, high)]
    if np.abs(ends[0] - ends[1]).max() > 1e-9:
        raise InputError(
            f"link '{name}' moves against the sensor's link '{run.sensor.link}'; a wrench is "
            'written in a frame that the sensor carries, or in "base".'
        )
    return np.asarray(lie.inverse(_mount(run)) @ ends[0])
