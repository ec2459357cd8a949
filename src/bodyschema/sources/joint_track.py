"""Joint track: joint positions over time, asked for at the moments of a camera's frames."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError, did_you_mean
from bodyschema.sources.recording import TIME_COLUMNS, UNITS, Recording

Array = NDArray[np.float64]

LONGEST_GAP = 0.5
"""s without a reading over which positions are not interpolated."""
ROUNDING = 1e-3
"""s by which a time may lie beyond the first or the last reading: tables are written rounded."""


@dataclass(frozen=True)
class JointTrack:
    """Positions of named joints on one clock."""

    source: str
    """Where it came from, for messages."""
    joints: tuple[str, ...]
    """Their names."""
    time: Array
    """(n,) s, increasing."""
    positions: Array
    """(n, n_joints) rad, m, or what the recorder uses where the unit is "1"."""

    def at(self, time: float) -> Array:
        """Positions (n_joints,) at a time in s, on straight lines between the readings.

        nan beyond the readings and in gaps longer than `LONGEST_GAP`.
        """
        first, last = self.time[0], self.time[-1]
        if not first - ROUNDING <= time <= last + ROUNDING:
            return np.full(len(self.joints), np.nan)
        time = min(max(time, first), last)
        after = max(int(np.searchsorted(self.time, time)), 1)
        gap = self.time[after] - self.time[after - 1]
        if gap > LONGEST_GAP:
            return np.full(len(self.joints), np.nan)
        share = (time - self.time[after - 1]) / gap
        return np.asarray((1 - share) * self.positions[after - 1] + share * self.positions[after])


def joint_track(
    recording: Recording,
    joints: Sequence[str] = (),
    units: Sequence[str] = ("rad",),
    time_column: str | None = None,
) -> JointTrack:
    """Read the joints of a recording.

    Args:
        recording: with a column per joint.
        joints: names or patterns ("q_*"); empty for every column of numbers but the time.
        units: the unit of all joints, then "PATTERN=UNIT" for those that differ; "1" keeps values.
        time_column: see `Recording.time`; numbered rows are refused.

    Raises:
        InputError: no such column or unit, a value that is no number, times that go back.
    """
    if time_column is None and not set(TIME_COLUMNS) & {*recording.columns, *recording.texts}:
        raise InputError(
            f"{recording.source} has no column 'time', 't' or 'timestamp'; "
            "name the time column (--time-column)" + did_you_mean("time", recording.columns)
        )
    time = recording.time(time_column)
    clock = time_column or next(c for c in TIME_COLUMNS if c in recording.columns)
    names = _matching(recording, joints, clock)
    unit_of = _units(names, units)
    columns, filled = [], np.ones(len(recording), dtype=bool)
    for name in names:
        values, present = recording.matrix([name], unit_of[name])
        columns.append(values)
        filled &= present
    if filled.sum() < 2:
        raise InputError(f"{recording.source} has {filled.sum()} full rows; joints need two.")
    return JointTrack(recording.source, names, time[filled], np.hstack(columns)[filled])


def _matching(recording: Recording, patterns: Sequence[str], clock: str) -> tuple[str, ...]:
    """Columns that the patterns name, in the recording's order."""
    known = [name for name in recording.columns if name != clock]
    if not patterns:
        if not known:
            raise InputError(f"{recording.source} has no column of numbers beside the time.")
        return tuple(known)
    for pattern in patterns:
        if not any(fnmatchcase(name, pattern) for name in known):
            raise InputError(f"no joint '{pattern}' in {recording.source}" + _near(pattern, known))
    return tuple(name for name in known if any(fnmatchcase(name, p) for p in patterns))


def _near(pattern: str, known: Iterable[str]) -> str:
    return did_you_mean(pattern.replace("*", ""), known)


def _units(names: Sequence[str], units: Sequence[str]) -> dict[str, str]:
    """Unit of each joint: the last entry that fits it."""
    unit_of: dict[str, str] = {}
    for entry in units:
        pattern, equals, unit = entry.rpartition("=")
        if unit != "1" and unit not in UNITS:
            raise InputError(f"unknown unit '{unit}'{did_you_mean(unit, UNITS)}")
        fitting = [name for name in names if fnmatchcase(name, pattern if equals else "*")]
        if not fitting:
            raise InputError(
                f"no joint '{pattern}' to have the unit '{unit}'; joints: {', '.join(names)}."
            )
        unit_of |= dict.fromkeys(fitting, unit)
    absent = next((name for name in names if name not in unit_of), None)
    if absent is not None:
        raise InputError(f"joint '{absent}' has no unit; name one for all, such as 'rad'.")
    return unit_of
