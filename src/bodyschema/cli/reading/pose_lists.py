"""Poses of a hand and of what an eye saw, for `bodyschema hand-eye`: no robot, no joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.cli.reading.columns import LENGTHS, expanded
from bodyschema.cli.reading.sense_entry import SenseEntry
from bodyschema.errors import InputError
from bodyschema.judging.pose_declarations import Whose
from bodyschema.learners.hand_eye.free_estimate import LAG, SCALE, Names
from bodyschema.learners.hand_eye.pose_streams import interpolate, usable
from bodyschema.model.free_hand import hand_readings
from bodyschema.model.tree import Body
from bodyschema.senses.layouts import LAYOUTS, poses_from_columns
from bodyschema.senses.poses import Poses
from bodyschema.sources.physical_units import factor
from bodyschema.sources.recording import Recording
from bodyschema.sources.tables import open_recording

if TYPE_CHECKING:
    from bodyschema.cli.run_file import RunFile

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class PoseLists:
    """Both lists of a run."""

    T_base_hand: Array
    """(n, 4, 4) from the robot."""
    T_eye_target: Array
    """(m, 4, 4) from the eye; m is n for pairs."""
    rows: Ints
    """(m,) of the eye's recording."""
    times: tuple[Array, Array] | None
    """(n,) and (m,) s of streams; None for pairs."""
    names: Names
    layouts: dict[Whose, str]


def read_pose_lists(run: RunFile) -> PoseLists:
    """Read both lists of a run.

    Raises:
        InputError: anything in them that cannot be used, in one sentence.
    """
    entries = run.senses
    if run.hand_eye is None or len(entries) != 2 or {e.kind for e in entries} != {"poses"}:
        raise InputError(
            'hand-eye takes [hand_eye] and two [[senses]] of kind = "poses": first the hand in its '
            "base, as the robot says, then the target in the eye."
        )
    robot, eye = entries
    both = [entry.recording or run.recording for entry in entries]
    tables = [open_recording(files) for files in dict.fromkeys(both)]
    first, second = tables[0], tables[-1]
    hands, hand_rows = _poses(robot, first)
    seen, rows = _poses(eye, second)
    names = Names(robot.seen_from, robot.seen, eye.seen_from, eye.seen)
    layouts: dict[Whose, str] = {"robot": robot.layout, "eye": eye.layout}
    if run.hand_eye.join == "time":
        clocks = (_times(run, robot, first)[hand_rows], _times(run, eye, second)[rows])
        return PoseLists(hands, seen, rows, clocks, names, layouts)
    if len(first) != len(second):
        raise InputError(
            f"{first.source} has {len(first)} rows and {second.source} has {len(second)}: rows are "
            'no pairs; set join = "time" in [hand_eye] for streams, which are joined by a lag.'
        )
    # A pair needs both; cells are empty where one of them was not seen.
    _, mine, its = np.intersect1d(hand_rows, rows, return_indices=True)
    return PoseLists(hands[mine], seen[its], rows[its], None, names, layouts)


def pose_sense(run: RunFile, body: Body) -> Poses:
    """What the eye of a run saw of a free hand that was placed before, for `check` and `plan`.

    Args:
        run: with [hand_eye].
        body: of a hand-eye answer, with the scale of the eye's lengths and the lag as parts.
    """
    lists = read_pose_lists(run)
    A, T, rows = lists.T_base_hand, lists.T_eye_target, lists.rows
    if lists.times is not None:
        hand, eye = lists.times
        at = eye + body.part(LAG)["lag"]
        kept = usable(hand, at)
        A, T, rows = interpolate(hand, A, at[kept]), T[kept], rows[kept]
    scale = body.part(SCALE)["scale"] if SCALE in body.parts else 1.0
    pose = lie.transform(T[:, :3, :3], T[:, :3, 3] / scale)
    names = lists.names
    return Poses.make(hand_readings(A), pose, names.eye, names.target, rows=rows)


def _poses(entry: SenseEntry, table: Recording) -> tuple[Array, Ints]:
    columns = expanded(entry.columns, tuple(table.columns))
    count = LAYOUTS[entry.layout][0] if entry.layout in LAYOUTS else len(columns)
    if len(columns) != count:
        raise InputError(
            f"layout '{entry.layout}' has {count} columns, {len(columns)} were named in "
            f"{table.source}."
        )
    values, present = table.matrix(columns, "1")
    T = poses_from_columns(values[present], entry.layout, factor(entry.unit or "m", LENGTHS))
    return np.asarray(lie.inverse(T) if entry.inverse else T), np.flatnonzero(present)


def _times(run: RunFile, entry: SenseEntry, table: Recording) -> Array:
    name = run.time if entry.time is None else entry.time
    if name == "":
        raise InputError('join = "time" needs a column of times, and time = "" names none.')
    return table.time(name)
