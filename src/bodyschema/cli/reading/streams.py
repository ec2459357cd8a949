"""Joints and senses in files of their own rates and clocks, `join = "time"` in a run file.

The joints are read from the one file of `recording` that has their columns, every sense from the
file that has its own. A stream's stamps may be late by a lag that nobody knows: it has a part
"clock", clock_of_poses for poses.csv, unless the run file names one.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from bodyschema.cli.reading.columns import expanded
from bodyschema.cli.reading.joints import column_of, cut_off, read_joints
from bodyschema.errors import InputError, did_you_mean
from bodyschema.model.tree import Body
from bodyschema.sources.bags import is_bag, topics_of
from bodyschema.sources.joint_stream import JointStream
from bodyschema.sources.recording import TIME_COLUMNS, Recording
from bodyschema.sources.tables import open_recording

if TYPE_CHECKING:
    from bodyschema.cli.reading.sense_entry import SenseEntry
    from bodyschema.cli.run_file import RunFile

Array = NDArray[np.float64]

Files = tuple[str, ...]

NAMED = 3
"""Columns of joints that a message names."""


@dataclass(frozen=True)
class Streams:
    """The files of a run that are joined by time, each read once."""

    run: RunFile
    """With the joints' file as its recording, and of every sense its file and clock."""
    joints: JointStream
    tables: Mapping[Files, Recording]

    @classmethod
    def open(cls, run: RunFile, body: Body) -> Streams:
        """Read the files of a run and say which holds what.

        Raises:
            InputError: no file or several have the joints, or the columns of a sense.
        """
        singles: dict[Files, Recording]
        names = [
            one for name in run.recording for one in (topics_of(name) if is_bag(name) else [name])
        ]
        singles = {(name,): open_recording([name]).paced(run.rate_hz, run.time) for name in names}
        named = [column_of(joint, run.joints) for joint in body.joints]
        holding = [files for files, table in singles.items() if {*named} & {*table.columns}]
        if len(holding) != 1:
            raise InputError(_no_joints(named, len(holding), _columns(singles)))
        own: dict[Files, Recording]
        own = {
            e.recording: open_recording(e.recording).paced(run.rate_hz, _column(run, e))
            for e in run.senses
            if e.recording
        }
        tables = {**singles, **own}
        senses = tuple(_placed(entry, singles, holding[0]) for entry in run.senses)
        table = tables[holding[0]]
        q = read_joints(body, table, run.joints)
        cut = cut_off(body, table, run.joints)
        stream = JointStream(table.source, stamps(table, run.time), q, cut)
        return cls(replace(run, recording=holding[0], senses=senses), stream, tables)

    @property
    def joint_table(self) -> Recording:
        """The file that holds the joints."""
        return self.tables[self.run.recording]

    def late(self, files: Files) -> bool:
        """Whether a file's rows are joined to the joints by time."""
        return files != self.run.recording

    @property
    def clocks(self) -> tuple[str, ...]:
        """Names of the clocks of all streams."""
        names = (entry.clock for entry in self.run.senses if self.late(entry.recording))
        return tuple(dict.fromkeys(names))

    def of_clock(self, clock: str) -> Streams:
        """With the senses of one clock alone."""
        own = tuple(entry for entry in self.run.senses if entry.clock == clock)
        return replace(self, run=replace(self.run, senses=own))

    def stamps_of(self, clock: str) -> Array:
        """Times of the stream with a clock, (n,) s."""
        entry = self.of_clock(clock).run.senses[0]
        return stamps(self.tables[entry.recording], _column(self.run, entry))

    def source_of(self, clock: str) -> str:
        """Its name for messages."""
        return self.tables[self.of_clock(clock).run.senses[0].recording].source


def _column(run: RunFile, entry: SenseEntry) -> str | None:
    return run.time if entry.time is None else entry.time


def _placed(entry: SenseEntry, singles: Mapping[Files, Recording], joints: Files) -> SenseEntry:
    """A sense with the file that has its columns, and a clock if that is not the joints' own."""
    fitting = [entry.recording] if entry.recording else [
        files for files, table in singles.items() if _holds(table, entry.columns)
    ]  # fmt: skip
    if len(fitting) != 1:
        lost = next(iter(entry.columns), "")
        n = len(fitting)
        which = (
            f"{n} files or topics of recording have" if n else "no file or topic of recording has"
        )
        raise InputError(
            f"{which} all columns of the {entry.kind} of "
            f"'{entry.seen}' seen from '{entry.seen_from}' ('{lost}' ...); name the one that has "
            f'what was seen, recording = "..."{did_you_mean(lost, _columns(singles))}'
        )
    files = fitting[0]
    stem = re.sub(r"\W+", "_", Path(files[0]).stem).strip("_")
    clock = entry.clock or ("" if files == joints else f"clock_of_{stem}")
    return replace(entry, recording=files, clock=clock)


def _holds(table: Recording, columns: tuple[str, ...]) -> bool:
    """Whether a table has all the columns, and of each pattern one that matches."""
    known = tuple(table.columns)
    found = [expanded((name,), known) for name in columns]
    return all(names and {*names} <= {*known} for names in found)


def _no_joints(named: Sequence[str], holding: int, known: Iterable[str]) -> str:
    """That no table has the joints, or several."""
    some = ", ".join(f"'{name}'" for name in named[:NAMED]) + (" ..." if len(named) > NAMED else "")
    if holding:
        return (
            f'join = "time" needs the joints in one file or topic of recording, and {holding} have '
            f"columns of them ({some}); leave the others out of recording."
        )
    return (
        f"no file or topic of recording has columns of the robot's joints, {some}; say under "
        f"[joints] which column is which{did_you_mean(named[0], known)}"
    )


def _columns(tables: Mapping[Files, Recording]) -> Iterable[str]:
    return [name for table in tables.values() for name in table.columns]


def stamps(table: Recording, column: str | None) -> Array:
    """Times of a stream, (n,) s. Raises InputError where it has none."""
    named = {*table.columns} & {*TIME_COLUMNS} if column is None else column
    if not named:
        raise InputError(
            f'join = "time" needs times, and {table.source} has no column time, t or timestamp; '
            'name it: time = "...".'
        )
    return table.time(column)
