"""From a run file to a body, its senses and what is known of the frames."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import cast

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.cli.run_file import JointColumns, RunFile, SenseEntry
from bodyschema.errors import InputError, did_you_mean
from bodyschema.estimation.problem import Knowledge, moved_joints
from bodyschema.model.tree import Body
from bodyschema.senses.layouts import poses_from_columns
from bodyschema.senses.points import Points
from bodyschema.senses.poses import Poses
from bodyschema.senses.sense import Sense
from bodyschema.sources.recording import UNITS, Recording
from bodyschema.sources.tables import open_recording

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Loaded:
    """Everything that `calibrate` needs."""

    nominal: Body
    """As described, without the frames of the run file."""
    body: Body
    """With them."""
    senses: tuple[Sense, ...]
    frames: Mapping[str, Knowledge]
    """Frames that are not known exactly."""
    parts: Mapping[str, tuple[str, ...] | None] = field(default_factory=dict)
    """Parts that are not known exactly, and which of their numbers; None for all."""


def load(run: RunFile) -> Loaded:
    """Read the robot and the recording of a run.

    Raises:
        InputError: anything in them that cannot be used, in one sentence.
    """
    if run.skeleton:
        nominal = Body.from_arrangement(run.skeleton)
    else:
        nominal = read_robot(Path(run.robot), run.packages)
    body = nominal
    for name, entry in run.frames.items():
        T = lie.transform(lie.rotation_from_rpy(entry.rpy), entry.xyz)
        body = body.attach(name, entry.parent, T)
    frames = {
        name: cast(Knowledge, entry.known)
        for name, entry in run.frames.items()
        if entry.known != "exactly"
    }
    return Loaded(nominal, body, read_senses(run, body), frames)


def read_senses(run: RunFile, body: Body) -> tuple[Sense, ...]:
    """Read the recording of a run for a body that has all its frames.

    Raises:
        InputError: anything in it that cannot be used, in one sentence.
    """
    recording = open_recording(run.recording)
    time = recording.time(run.time)
    q = read_joints(body, recording, run.joints)
    senses = tuple(_sense(entry, recording, time, q) for entry in run.senses)
    for sense in senses:
        body.frame_index(sense.seen_from)
        body.frame_index(sense.seen)
    _refuse_missing(body, recording, run.joints, senses)
    return senses


def read_robot(path: Path, packages: Mapping[str, str] | None = None) -> Body:
    """A URDF or xacro file, or a DH table in TOML or JSON."""
    if path.suffix in (".toml", ".json"):
        return Body.from_dh(path)
    return Body.from_urdf(path, packages)


def _column_of(joint: str, joints: JointColumns) -> str:
    return joints.columns.get(joint, joint)


def read_joints(body: Body, recording: Recording, joints: JointColumns) -> Array:
    """(n_rows, n_joints) in rad and m; zero for joints that were not recorded."""
    for joint in joints.columns:
        body.joint_index(joint)
    q = np.zeros((len(recording), len(body.joints)))
    for j, joint in enumerate(body.joints):
        column = _column_of(joint, joints)
        if column in recording.columns or joint in joints.columns:
            revolute = np.any(body.kind[body.driver == j] == 1)
            unit = joints.unit if revolute else "m"
            values, present = recording.matrix([column], unit)
            if not present.all():
                row = int(np.flatnonzero(~present)[0])
                raise InputError(f"column '{column}' of {recording.source} is empty in row {row}.")
            q[:, j] = values[:, 0]
    return q


def _refuse_missing(
    body: Body, recording: Recording, joints: JointColumns, senses: Sequence[Sense]
) -> None:
    """Joints between the frames must have been recorded."""
    needed = moved_joints(body, senses)
    missing = [j for j in needed if _column_of(j, joints) not in recording.columns]
    if missing:
        unused = [c for c in recording.columns if c not in body.joints]
        raise InputError(
            f"no column for joint {', '.join(missing[:6])} in {recording.source}"
            f"{did_you_mean(missing[0], unused)} Name it under [joints] columns = "
            f'{{ {missing[0]} = "..." }}.'
        )


def _sense(entry: SenseEntry, recording: Recording, time: Array, q: Array) -> Sense:
    if entry.unit not in UNITS:
        raise InputError(f"unknown unit '{entry.unit}'{did_you_mean(entry.unit, UNITS)}")
    values, present = recording.matrix(entry.columns, "1")
    rows = np.flatnonzero(present)
    scale = UNITS[entry.unit]
    if entry.kind == "points":
        if len(entry.columns) != 3:
            raise InputError(f"a sense of points has 3 columns, {len(entry.columns)} were named.")
        return Points.make(
            q[rows], scale * values[rows], entry.seen_from, entry.seen, time=time[rows], rows=rows
        )
    pose = poses_from_columns(values[rows], entry.layout, scale)
    if entry.inverse:
        pose = lie.inverse(pose)
    return Poses.make(q[rows], pose, entry.seen_from, entry.seen, time=time[rows], rows=rows)
