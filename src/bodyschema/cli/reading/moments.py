"""Moments: the rows of one recording, with what the joints did there, as senses are read from it.

Rows of several recordings are numbered through, so that rows of two files are never one moment: row
i of a recording has the number `first` + i.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.cli.reading.joints import column_of, cut_off, read_joints
from bodyschema.errors import InputError
from bodyschema.model.tree import Body
from bodyschema.sources.condition import rows_where
from bodyschema.sources.recording import TIME_COLUMNS, Recording

if TYPE_CHECKING:
    from bodyschema.cli.reading.joint_columns import JointColumns
    from bodyschema.cli.reading.part_entry import PartEntry
    from bodyschema.cli.reading.sense_entry import SenseEntry
    from bodyschema.cli.reading.streams import Session

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Moments:
    """One recording, read for one body."""

    body: Body
    joints: JointColumns
    parts: Mapping[str, PartEntry]
    """Of the run, for the sizes of pictures."""
    recording: Recording | None
    """None for a recording that is gone: then nothing is seen in it."""
    q: Array
    """(n_rows, n_joints) rad and m."""
    time: Array
    """(n_rows,) s."""
    clocked: bool
    """Whether the times were recorded."""
    first: int = 0
    """Number of its first row."""
    rate: Array | None = None
    """(n_rows, n_joints) dq/dt, where the joints are a stream of their own."""
    known: NDArray[np.bool_] | None = None
    """(n_rows,) whether the joints were read about then; all rows when None."""
    joint_table: Recording | None = None
    """That the joints were read from; `recording` when None."""
    cut: NDArray[np.bool_] | None = None
    """(n_rows, n_joints) where a joint was recorded at an end at which it is cut off."""

    @classmethod
    def of(
        cls,
        body: Body,
        joints: JointColumns,
        parts: Mapping[str, PartEntry],
        recording: Recording,
        time: str | None,
    ) -> Moments:
        """Read the joints and times of a recording.

        Raises:
            InputError: a cell is empty or no number, or time does not go on.
        """
        known = {*recording.columns, *recording.texts}
        clocked = time != "" and (time is not None or any(c in known for c in TIME_COLUMNS))
        q, cut = read_joints(body, recording, joints), cut_off(body, recording, joints)
        return cls(body, joints, parts, recording, q, recording.time(time), clocked, cut=cut)

    @classmethod
    def joined(
        cls,
        body: Body,
        parts: Mapping[str, PartEntry],
        recording: Recording,
        time: Array,
        joints: JointColumns,
        session: Session,
        lag: float,
    ) -> Moments:
        """A recording without joints, with those of another at its times.

        Args:
            body: whose joints.
            parts: of the run.
            recording: the table.
            time: (n_rows,) s, its stamps.
            joints: how they were recorded.
            session: with their readings.
            lag: s, by which the stamps are late; what is left of it is for the clock.
        """
        q, rate, known = session.joints.at(time - lag)
        return cls(
            body, joints, parts, recording, q, time, True,
            rate=rate, known=known, joint_table=session.table,
            cut=session.joints.near_a_cut(time - lag),
        )  # fmt: skip

    @classmethod
    def none(cls, body: Body, joints: JointColumns, parts: Mapping[str, PartEntry]) -> Moments:
        """A recording that is gone."""
        return cls(body, joints, parts, None, np.zeros((0, len(body.joints))), np.zeros(0), True)

    def __len__(self) -> int:
        return len(self.q)

    @property
    def source(self) -> str:
        """Where it came from, for messages."""
        return self.recording.source if self.recording else "the recording"

    @property
    def shares_time(self) -> bool:
        """Whether the joints were read about the time of any row."""
        return bool(self._known.any())

    def only(self, condition: str) -> Moments:
        """The same with the rows alone that fulfil a condition; see `sources.condition`."""
        if not condition or self.recording is None:
            return self
        return replace(self, known=self._known & rows_where(self.recording, condition))

    def readable(self, joints: Sequence[str]) -> Moments:
        """The same without the rows in which one of these joints was cut off."""
        columns = [self.body.joint_index(joint) for joint in joints]
        if self.cut is None or not self.cut[:, columns].any():
            return self
        return replace(self, known=self._known & ~self.cut[:, columns].any(axis=1))

    def from_row(self, first: int) -> Moments:
        """The same, numbered from there."""
        return replace(self, first=first)

    def read(self, columns: Sequence[str]) -> tuple[Array, Ints]:
        """Columns as recorded (m, n_columns) and the rows in which they are filled (m,).

        All rows where no column is named.
        """
        if self.recording is None or not columns:
            rows = np.flatnonzero(self._known)
            return np.zeros((len(rows), len(columns))), rows
        values, present = self.recording.matrix(columns, "1")
        rows = np.flatnonzero(present & self._known)
        return values[rows], rows

    @property
    def _known(self) -> NDArray[np.bool_]:
        return np.ones(len(self), dtype=bool) if self.known is None else self.known

    def has(self, columns: Sequence[str]) -> bool:
        """Whether all these columns are in the recording."""
        return self.recording is None or set(columns) <= {*self.recording.columns}

    def more(self, entry: SenseEntry, rows: Ints, scales: ArrayLike) -> dict[str, Any]:
        """What the makers of all senses take.

        Args:
            entry: the sense.
            rows: of its samples, (m,).
            scales: what one of the columns' unit is in SI, for each measure.
        """
        told: dict[str, Any] = {
            "time": self.time[rows],
            "rows": rows + self.first,
            "stated": entry.stated,
            "clock": entry.clock,
        }
        if entry.clock:
            told["rate"] = self.speeds(entry)[rows]
        if entry.std is not None:
            sizes = np.asarray(scales, dtype=np.float64)
            std = (entry.std,) if isinstance(entry.std, float | int) else entry.std
            if len(std) not in (1, len(sizes)) or min(std) <= 0:
                raise InputError(
                    f"std of a sense of {entry.kind} is one number above 0 or "
                    f"{len(sizes)}, it is {list(std)}."
                )
            told["std"] = np.asarray(std) * sizes
        return told

    def speeds(self, entry: SenseEntry) -> Array:
        """(n_rows, n_joints) dq/dt: recorded, or the slope between the rows before and after."""
        if entry.speeds:
            return self._pattern(entry.speeds, "speeds")
        return self._slope(self.q) if self.rate is None else self.rate

    def motion(self, entry: SenseEntry, rows: Ints) -> dict[str, Any]:
        """Speeds and accelerations of the samples of a sense of forces; none at rest."""
        if not entry.moving:
            return {}
        speeds = self.speeds(entry)
        if entry.accelerations:
            accelerations = self._pattern(entry.accelerations, "accelerations")
        else:
            accelerations = self._slope(speeds)
        return {"dq": speeds[rows], "ddq": accelerations[rows]}

    def _slope(self, values: Array) -> Array:
        if len(values) < 2:
            return np.zeros_like(values)
        if not self.clocked:
            raise InputError(
                f"{self.source} has no column of times, so nothing tells how fast the joints "
                'moved; name one, time = "t", or give the columns of speeds = "d_{joint}".'
            )
        return np.asarray(np.gradient(values, self.time, axis=0))

    def _pattern(self, pattern: str, key: str) -> Array:
        if self.recording is None:
            return np.zeros_like(self.q)
        names = [pattern.replace("{joint}", column_of(j, self.joints)) for j in self.body.joints]
        if "{joint}" not in pattern or not set(names) & {*self.recording.columns}:
            raise InputError(
                f"{key} = '{pattern}' names no column of {self.source}; write {{joint}} where the "
                f"name of a joint's column goes, such as 'd_{{joint}}' for '{names[0]}'."
            )
        return read_joints(self.body, self.recording, self.joints, pattern)
