"""Joints and senses in files of their own rates and clocks, `join = "time"` in a run file.

The joints are read from the one file of `recording` that has their columns, every sense from the
file that has its own. A stream's stamps may be late by a lag that nobody knows: it has a part
"clock", clock_of_poses for poses.csv, unless the run file names one. Recordings that are appended
have joints and clocks of their own: so has a sense whose own recording has the joints, too.
"""

from __future__ import annotations

import itertools
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
class Session:
    """The joints of one recording, with the tables of its files or topics."""

    joints: JointStream
    table: Recording
    """That holds the joints."""
    files: Files
    """Its name."""
    singles: Mapping[Files, Recording]

    @classmethod
    def open(cls, run: RunFile, body: Body, singles: Mapping[Files, Recording]) -> Session:
        """Find the joints among the tables of a recording.

        Raises:
            InputError: none or several have them.
        """
        named = [column_of(joint, run.joints) for joint in body.joints]
        holding = _holding(named, singles)
        if len(holding) != 1:
            raise InputError(_no_joints(named, len(holding), _columns(singles)))
        (files,) = holding
        table = singles[files]
        q, cut = read_joints(body, table, run.joints), cut_off(body, table, run.joints)
        stream = JointStream(table.source, stamps(table, run.time), q, cut)
        return cls(stream, table, files, singles)


@dataclass(frozen=True)
class Streams:
    """The files of a run that are joined by time, each read once."""

    run: RunFile
    """With of every sense its file and clock."""
    sessions: Mapping[Files, Session]
    """That the joints of each sense's file are read from, by that file."""
    tables: Mapping[Files, Recording]

    @classmethod
    def open(cls, run: RunFile, body: Body) -> Streams:
        """Read the files of a run and say which holds what.

        Raises:
            InputError: no file or several have the joints, or the columns of a sense.
        """
        opened, clocks = _Opened(run, body), dict[Files, str]()
        sessions, tables = dict[Files, Session](), dict[Files, Recording]()
        senses = []
        for entry in run.senses:
            session, own = opened.of(entry)
            singles = session.singles if own is None else {entry.recording: own}
            placed = _placed(entry, singles)
            files = placed.recording
            sessions[files], tables[files] = session, singles[files]
            if not placed.clock and files != session.files:
                clocks.setdefault(files, _clock_name(files, [*clocks.values()]))
                placed = replace(placed, clock=clocks[files])
            senses.append(placed)
        _refuse_two_clocks(senses)
        if not senses:
            opened.common()
        first = next(iter(sessions.values())).files if sessions else run.recording
        return cls(replace(run, recording=first, senses=tuple(senses)), sessions, tables)

    def joints(self, files: Files) -> Session:
        """The joints that go with a file of senses."""
        return self.sessions[files]

    def late(self, files: Files) -> bool:
        """Whether a file's rows are joined to the joints by time."""
        return files != self.sessions[files].files

    @property
    def clocks(self) -> tuple[str, ...]:
        """Names of the clocks of all streams."""
        names = (entry.clock for entry in self.run.senses if self.late(entry.recording))
        return tuple(dict.fromkeys(names))

    def of_clock(self, clock: str) -> Streams:
        """With the senses of one clock alone."""
        own = tuple(entry for entry in self.run.senses if entry.clock == clock)
        return replace(self, run=replace(self.run, senses=own))

    @property
    def first(self) -> SenseEntry:
        """The first sense."""
        return self.run.senses[0]

    def stamps_of(self, clock: str) -> Array:
        """Times of the stream with a clock, (n,) s."""
        entry = self.of_clock(clock).first
        return stamps(self.tables[entry.recording], _column(self.run, entry))

    def apart(self, files: Files) -> str:
        """That a file's rows share no time with the joints, with the times of both."""
        entry = next(entry for entry in self.run.senses if entry.recording == files)
        ends = []
        for table, time in (
            (self.tables[files], _column(self.run, entry)),
            (self.sessions[files].table, self.run.time),
        ):
            at = stamps(table, time)
            ends.append(f"{table.source} ({at[0]:.3f} to {at[-1]:.3f} s)")
        return (
            f"no row of {ends[0]} lies within the times of {ends[1]}; give recordings of one "
            "motion, stamps of both in s, and the lag of a clock that is known exactly as it is."
        )

    def source_of(self, clock: str) -> str:
        """Its name for messages."""
        return self.tables[self.of_clock(clock).first.recording].source


def _refuse_two_clocks(senses: Sequence[SenseEntry]) -> None:
    """Samples of two clocks are no one sense. Raises InputError where they see the same."""
    for i, entry in enumerate(senses):
        for other in senses[:i]:
            alike = replace(other, recording=entry.recording, time=entry.time, clock=entry.clock)
            if alike == entry and other.clock != entry.clock:
                ends = " and ".join(f"'{end}'" for end in (entry.seen_from, entry.seen) if end)
                raise InputError(
                    f"the {entry.kind} between {ends} are in several recordings, each late by a "
                    "lag of its own; say which frame may have moved between, per_recording = true "
                    'in its [frames] section, or name one clock for all, clock = "NAME" of a part.'
                )


class _Opened:
    """The recordings of a run, each read once, and which joints go with a sense."""

    def __init__(self, run: RunFile, body: Body) -> None:
        self._run, self._body = run, body
        self._named = [column_of(joint, run.joints) for joint in body.joints]
        self._sessions: dict[Files, Session] = {}
        self._own: dict[tuple[Files, str | None], Recording] = {}

    def common(self) -> Session:
        """That of the run's own recording."""
        files = self._run.recording
        if files not in self._sessions:
            singles = _singles(files, self._run.rate_hz, self._run.time)
            self._sessions[files] = Session.open(self._run, self._body, singles)
        return self._sessions[files]

    def of(self, entry: SenseEntry) -> tuple[Session, Recording | None]:
        """The joints of a sense, and its own table where its recording has no joints."""
        files, time = entry.recording, _column(self._run, entry)
        if not files:
            return self.common(), None
        if files in self._sessions:
            return self._sessions[files], None
        if (files, time) not in self._own:
            singles = _singles(files, self._run.rate_hz, time)
            if _holding(self._named, singles):
                self._sessions[files] = Session.open(self._run, self._body, singles)
                return self._sessions[files], None
            if not self._run.recording:
                raise InputError(_no_joints(self._named, 0, _columns(singles)))
            one = next(iter(singles.values())) if len(singles) == 1 else open_recording(files)
            self._own[files, time] = one.paced(self._run.rate_hz, time)
        return self.common(), self._own[files, time]


def _singles(files: Files, rate_hz: float | None, time: str | None) -> dict[Files, Recording]:
    """A table of every file, and of every topic of a bag."""
    names = [one for name in files for one in (topics_of(name) if is_bag(name) else [name])]
    return {(name,): open_recording([name]).paced(rate_hz, time) for name in names}


def _holding(named: Sequence[str], singles: Mapping[Files, Recording]) -> list[Files]:
    """The tables that have columns of joints."""
    return [files for files, table in singles.items() if {*named} & {*table.columns}]


def _column(run: RunFile, entry: SenseEntry) -> str | None:
    return run.time if entry.time is None else entry.time


def _placed(entry: SenseEntry, singles: Mapping[Files, Recording]) -> SenseEntry:
    """A sense with the file that has its columns."""
    fitting = [files for files, table in singles.items() if _holds(table, entry.columns)]
    if len(singles) == 1:  # what its columns lack is said where they are read
        fitting = list(singles)
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
    return replace(entry, recording=fitting[0])


def _clock_name(files: Files, taken: Sequence[str]) -> str:
    """A name for the clock of a file, that no other file's has."""
    name = "clock_of_" + re.sub(r"\W+", "_", Path(files[0]).stem).strip("_")
    numbered = (f"{name}_{number}" for number in itertools.count(2))
    return next(one for one in itertools.chain([name], numbered) if one not in taken)


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
