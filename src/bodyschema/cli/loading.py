"""From a run file to a body, its senses, and what is known of its frames and parts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import cast

from bodyschema import lie
from bodyschema.cli.reading.joints import read_joints as read_joints
from bodyschema.cli.reading.joints import refuse_missing
from bodyschema.cli.reading.moments import Moments
from bodyschema.cli.reading.part_kinds import freed, made
from bodyschema.cli.reading.pose_lists import pose_sense
from bodyschema.cli.reading.robot import robot_of
from bodyschema.cli.reading.sense_entry import SenseEntry
from bodyschema.cli.reading.sense_kinds import make_sense, parts_of
from bodyschema.cli.run_file import RunFile
from bodyschema.errors import InputError
from bodyschema.estimation.problem import Knowledge, moved_joints
from bodyschema.model.tree import Body
from bodyschema.senses.outlines import Outlines
from bodyschema.senses.sense import Sense, concatenate
from bodyschema.sources.tables import open_recording

Source = tuple[tuple[str, ...], str | None]
"""Files of a recording, and its column of times."""


@dataclass(frozen=True)
class Loaded:
    """Everything that `calibrate` needs."""

    nominal: Body
    """As described, without the frames and parts of the run file."""
    body: Body
    """With them."""
    senses: tuple[Sense, ...]
    frames: Mapping[str, Knowledge]
    """Frames that are not known exactly."""
    parts: Mapping[str, tuple[str, ...] | None] = field(default_factory=dict)
    """Parts that are not known exactly, and which of their numbers; None for all."""
    first_rows: Mapping[str, int] = field(default_factory=dict)
    """Number of the first row of each recording: rows are numbered through."""


def load(run: RunFile) -> Loaded:
    """Read the robot and the recordings of a run.

    Raises:
        InputError: anything in them that cannot be used, in one sentence.
    """
    nominal = described(run)
    body, parts = with_parts(run, with_frames(run, nominal))
    frames = {
        name: cast(Knowledge, entry.known)
        for name, entry in run.frames.items()
        if entry.known != "exactly"
    }
    opened = _recordings(run, body)
    senses = _senses(run, opened)
    _refuse_unused(run, parts)
    rows = {at.source: at.first for at in opened.values()}
    return Loaded(nominal, body, senses, frames, parts, rows)


def described(run: RunFile) -> Body:
    """The robot of a run as its description has it.

    Raises:
        InputError: it cannot be read.
    """
    if run.skeleton:
        return Body.from_arrangement(run.skeleton)
    return robot_of(run)


def with_frames(run: RunFile, body: Body) -> Body:
    """The body with the frames of a run file."""
    for name, entry in run.frames.items():
        T = lie.transform(lie.rotation_from_rpy(entry.rpy), entry.xyz)
        body = body.attach(name, entry.parent, T)
    return body


def with_parts(run: RunFile, body: Body) -> tuple[Body, dict[str, tuple[str, ...] | None]]:
    """The body with the parts of a run file, and what of them is free; see `Loaded.parts`."""
    free: dict[str, tuple[str, ...] | None] = {}
    for name, entry in run.parts.items():
        if name in body.frames:
            raise InputError(f"'{name}' is a frame and a part; give the part another name.")
        part = made(entry, name, body)
        body = body.with_part(name, part)
        if entry.known != "exactly":
            free[name] = freed(entry, name, part)
    return body, free


def read_senses(run: RunFile, body: Body) -> tuple[Sense, ...]:
    """Read the recordings of a run for a body that has all its frames and parts.

    Entries that differ in nothing but their recording are one sense.

    Raises:
        InputError: anything in them that cannot be used, in one sentence.
    """
    if run.hand_eye is not None:
        return (pose_sense(run, body),)
    shown = body
    if not body.visuals and run.robot and any(entry.kind == "outlines" for entry in run.senses):
        shown = replace(body, visuals=robot_of(run).visuals)
    return _senses(run, _recordings(run, shown))


def blank_senses(run: RunFile, body: Body) -> tuple[Sense, ...]:
    """The senses of a run without a sample, for a recording that is gone."""
    gone = Moments.none(body, run.joints, run.parts)
    return _senses(run, {source_of(run, entry): gone for entry in run.senses})


def source_of(run: RunFile, entry: SenseEntry) -> Source:
    """What a sense is read from: its own files or those of the run."""
    return entry.recording or run.recording, run.time if entry.time is None else entry.time


def _recordings(run: RunFile, body: Body) -> dict[Source, Moments]:
    """Every recording of a run, rows numbered through."""
    opened: dict[Source, Moments] = {}
    first: dict[tuple[str, ...], int] = {}
    for source in [(run.recording, run.time), *(source_of(run, entry) for entry in run.senses)]:
        files, time = source
        if source in opened or not files:
            continue
        at = Moments.of(body, run.joints, run.parts, open_recording(files), time)
        first.setdefault(files, sum(map(len, opened.values())))
        opened[source] = at.from_row(first[files])
    return opened


def _senses(run: RunFile, opened: Mapping[Source, Moments]) -> tuple[Sense, ...]:
    """The senses of a run; those that differ in their recording alone as one."""
    batches: list[tuple[SenseEntry, list[Sense]]] = []
    for entry in run.senses:
        at = opened[source_of(run, entry)]
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


def _sense(run: RunFile, entry: SenseEntry, at: Moments) -> Sense:
    """One sense of one recording."""
    try:
        sense = make_sense(entry, at)
    except InputError as error:
        if not at.first:
            raise
        raise InputError(f"{error} (Rows of {at.source} count from {at.first}.)") from None
    if at.recording is not None:
        refuse_missing(at.body, at.recording, run.joints, moved_joints(at.body, [sense]))
    return sense


def _refuse_unused(run: RunFile, free: Mapping[str, object]) -> None:
    """Numbers that no sense depends on cannot be learnt."""
    used = {name for entry in run.senses for name, _ in parts_of(entry)}
    for name in free:
        if name not in used:
            raise InputError(
                f"no [[senses]] entry names the part '{name}', so nothing is seen of it; name it "
                f'where it belongs, or set known = "exactly" in [parts.{name}].'
            )
