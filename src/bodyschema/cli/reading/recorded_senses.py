"""The senses of a run, read from its recordings: rows of one table, or streams joined by time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from bodyschema.cli.reading.joint_columns import PERCENT
from bodyschema.cli.reading.joints import refuse_missing
from bodyschema.cli.reading.moments import Moments
from bodyschema.cli.reading.sense_entry import SenseEntry
from bodyschema.cli.reading.sense_kinds import make_sense
from bodyschema.cli.reading.streams import Streams, stamps
from bodyschema.errors import InputError
from bodyschema.estimation.problem import moved_joints
from bodyschema.model.tree import Body
from bodyschema.senses.outlines import Outlines
from bodyschema.senses.sense import Sense, concatenate
from bodyschema.sources.lerobot import is_lerobot
from bodyschema.sources.tables import open_recording
from bodyschema.units import listed

if TYPE_CHECKING:
    from bodyschema.cli.run_file import RunFile

NAMED = 3
"""Joints that a sentence names."""

Source = tuple[tuple[str, ...], str | None]
"""Files of a recording, and its column of times."""


def source_of(run: RunFile, entry: SenseEntry) -> Source:
    """What a sense is read from: its own files or those of the run."""
    return entry.recording or run.recording, run.time if entry.time is None else entry.time


def read_recordings(run: RunFile, body: Body) -> dict[Source, Moments]:
    """Every recording of a run, rows numbered through."""
    opened: dict[Source, Moments] = {}
    first: dict[tuple[str, ...], int] = {}
    for source in [(run.recording, run.time), *(source_of(run, entry) for entry in run.senses)]:
        files, time = source
        if source in opened or not files:
            continue
        table = open_recording(files).paced(run.rate_hz, time)
        at = Moments.of(body, run.joints, run.parts, table, time)
        first.setdefault(files, sum(map(len, opened.values())))
        opened[source] = at.from_row(first[files])
    return opened


def read_streams(streams: Streams, body: Body, trial: bool = False) -> dict[Source, Moments]:
    """Every recording of a run whose files are streams; joints at the lags of the body's clocks.

    Args:
        streams: the files.
        body: with the clocks.
        trial: the lags are tried, so that streams may share no time.

    Raises:
        InputError: a stream shares no time with its joints.
    """
    run, opened, first = streams.run, dict[Source, Moments](), 0
    for entry in run.senses:
        source = source_of(run, entry)
        if source in opened:
            continue
        table, time = streams.tables[source[0]], source[1]
        if streams.late(entry.recording):
            lag = body.part(entry.clock)["joined"]
            at = Moments.joined(
                body, run.parts, table, stamps(table, time), run.joints,
                streams.joints(source[0]), lag,
            )  # fmt: skip
            if not trial and not at.shares_time:
                raise InputError(streams.apart(source[0]))
        else:
            at = Moments.of(body, run.joints, run.parts, table, time)
        opened[source] = at.from_row(first)
        first += len(at)
    return opened


def make_senses(run: RunFile, opened: Mapping[Source, Moments]) -> tuple[Sense, ...]:
    """The senses of a run; those that differ in their recording alone as one."""
    batches: list[tuple[SenseEntry, list[Sense]]] = []
    for entry in run.senses:
        at = opened[source_of(run, entry)].only(entry.where)
        for frame in filter(None, (entry.seen_from, entry.seen)):
            at.body.frame_index(frame)
        sense = _sense(run, entry, at)
        alike = replace(entry, recording=(), time=None)
        same = [parts for other, parts in batches if other == alike]
        if same and not isinstance(sense, Outlines):
            same[0].append(sense)
        else:
            batches.append((alike, [sense]))
    return tuple(concatenate(parts) for _, parts in batches)


def reading_remarks(run: RunFile, opened: Mapping[Source, Moments]) -> tuple[str, ...]:
    """What to know of how the joints were read, a sentence each."""
    said = list[str]()
    for at in opened.values():
        for table in filter(None, (at.recording, at.joint_table)):
            said += [remark for remark in table.remarks if remark not in said]
        rows = 0 if at.cut is None else at.cut.any(axis=0)
        named = [j for j, cut in zip(at.body.joints, np.atleast_1d(rows), strict=False) if cut]
        if named and at.cut is not None:
            said.append(
                f"{listed(named, NAMED)} of {at.source}: {int(at.cut.any(axis=1).sum())} of "
                f"{len(at)} rows stand at an end of the motor's range, where readings are cut off; "
                "they are left out wherever that joint counts."
            )
    folders = [name for name in (*run.recording,) if is_lerobot(Path(name))]
    if folders and not run.joints.motors and run.joints.unit in PERCENT:
        said.append(
            f"The joints of '{Path(folders[0]).name}' are read in percent of the limits in the "
            "robot's description; LeRobot means those of the range that each motor was calibrated "
            'to. Name its file, [joints] calibration = "ID.json"; if it is lost, free what one '
            'percent is of each joint, [free] groups = ["offsets", "gears"].'
        )
    return tuple(said)


def _sense(run: RunFile, entry: SenseEntry, at: Moments) -> Sense:
    """One sense of one recording."""
    try:
        sense = make_sense(entry, at)
        whole = at.readable(moved_joints(at.body, [sense]))
        if whole is not at:
            sense = make_sense(entry, whole)
    except InputError as error:
        if not at.first:
            raise
        raise InputError(f"{error} (Rows of {at.source} count from {at.first}.)") from None
    table = at.joint_table or at.recording
    if table is not None:
        refuse_missing(at.body, table, run.joints, moved_joints(at.body, [sense]))
    return sense
