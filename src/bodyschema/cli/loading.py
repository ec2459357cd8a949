"""From a run file to a body, its senses, and what is known of its frames and parts."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import cast

from bodyschema.cli.reading.board_pictures import Photograph
from bodyschema.cli.reading.board_senses import (
    board_remarks,
    photographs_of,
    with_begun_lenses,
)
from bodyschema.cli.reading.joints import read_joints as read_joints
from bodyschema.cli.reading.moments import Moments
from bodyschema.cli.reading.part_kinds import freed, made
from bodyschema.cli.reading.pose_lists import pose_sense
from bodyschema.cli.reading.recorded_senses import (
    make_senses,
    read_recordings,
    read_streams,
    reading_remarks,
    source_of,
)
from bodyschema.cli.reading.robot import robot_of, with_frame
from bodyschema.cli.reading.sense_kinds import parts_of
from bodyschema.cli.reading.streams import Streams
from bodyschema.cli.run_file import RunFile
from bodyschema.cli.stream_lags import with_clocks
from bodyschema.errors import InputError
from bodyschema.estimation.problem import Knowledge
from bodyschema.model.tree import Body
from bodyschema.senses.sense import Sense


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
    photographs: Mapping[str, tuple[Photograph, ...]] = field(default_factory=dict)
    """Of boards, by the label of their sense."""


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
    if run.join == "time":
        streams = Streams.open(run, body)
        clocked = with_clocks(streams, body, frames, parts)
        body, parts = clocked.body, clocked.parts
        body = replace(body, remarks=(*body.remarks, *clocked.sentences))
        run, opened = streams.run, read_streams(streams, body)
    else:
        opened = read_recordings(run, body)
    senses = make_senses(run, opened)
    body, taken = with_begun_lenses(run, body, senses), photographs_of(run, opened)
    said = (*reading_remarks(run, opened), *board_remarks(run, taken, senses))
    body = replace(body, remarks=(*body.remarks, *said))
    _refuse_unused(run, parts)
    rows = {at.source: at.first for at in opened.values()}
    return Loaded(nominal, body, senses, frames, parts, rows, taken)


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
        body = with_frame(body, name, entry)
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
    if run.join == "time":
        streams = Streams.open(run, shown)
        return make_senses(streams.run, read_streams(streams, shown))
    return make_senses(run, read_recordings(run, shown))


def blank_senses(run: RunFile, body: Body) -> tuple[Sense, ...]:
    """The senses of a run without a sample, for a recording that is gone."""
    gone = Moments.none(body, run.joints, run.parts)
    return make_senses(run, {source_of(run, entry): gone for entry in run.senses})


def _refuse_unused(run: RunFile, free: Mapping[str, object]) -> None:
    """Numbers that no sense depends on cannot be learnt."""
    used = {name for entry in run.senses for name, _ in parts_of(entry)}
    for name in free:
        if name not in used:
            raise InputError(
                f"no [[senses]] entry names the part '{name}', so nothing is seen of it; name it "
                f'where it belongs, or set known = "exactly" in [parts.{name}].'
            )
