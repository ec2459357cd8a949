"""Clocks of streams that a run joins by time: how late each is, where nobody said."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from bodyschema.cli.reading.recorded_senses import make_senses, read_streams
from bodyschema.cli.reading.streams import Streams
from bodyschema.errors import InputError
from bodyschema.estimation.problem import Knowledge, Problem, moved_joints
from bodyschema.estimation.stream_lag import stream_lag
from bodyschema.model.parts import clock as clock_at
from bodyschema.model.parts import joined_clock
from bodyschema.model.tree import Body
from bodyschema.senses.sense import Sense

LARGEST_LAG = 5.0
"""s either way that stamps may be off; of clocks with other zeros, after both began together."""

SEARCHED_ON = 40
"""Samples of a stream for the search; the fit takes all."""

Parts = Mapping[str, tuple[str, ...] | None]


@dataclass(frozen=True)
class Clocked:
    """A body with a clock for every stream."""

    body: Body
    parts: dict[str, tuple[str, ...] | None]
    """What of it is free; see `Loaded.parts`."""
    sentences: tuple[str, ...]
    """How late each stream was found to be."""


def with_clocks(
    streams: Streams, body: Body, frames: Mapping[str, Knowledge], parts: Parts
) -> Clocked:
    """The body with clocks for the streams that have none, each at the lag that explains it best.

    Args:
        streams: the files.
        body: with frames and parts of the run.
        frames: that are not known exactly.
        parts: likewise.

    Raises:
        InputError: a stream shares no time with the joints.
    """
    free, said = dict(parts), list[str]()
    for clock in streams.clocks:
        if clock in body.parts:
            body = body.with_part(clock, joined_clock(body.part(clock)))
            continue
        lag, std = _found(streams, body, clock, frames, parts)
        body, free[clock] = body.with_part(clock, joined_clock(clock_at(lag))), ("lag",)
        said.append(_sentence(streams, clock, lag, std))
    return Clocked(body, free, tuple(said))


def _found(
    streams: Streams, body: Body, clock: str, frames: Mapping[str, Knowledge], parts: Parts
) -> tuple[float, float]:
    """Lag of one stream and its standard deviation, s."""
    alone = streams.of_clock(clock)
    frames = {name: known for name, known in frames.items() if name in _looked_at(body, alone)}

    def senses_at(lag: float) -> tuple[Body, tuple[Sense, ...]]:
        there = body.with_part(clock, joined_clock(clock_at(lag)))
        return there, make_senses(alone.run, read_streams(alone, there, trial=True))

    def problem_at(lag: float) -> Problem:
        there, senses = senses_at(lag)
        return Problem(there, tuple(_some(sense) for sense in senses), frames, (), parts=parts)

    stamps, joints = alone.stamps_of(clock), alone.joints(alone.first.recording).joints
    shared = min(stamps[-1], joints.time[-1]) - max(stamps[0], joints.time[0])
    shortest = min(np.ptp(stamps), np.ptp(joints.time))
    middle = 0.0 if shared > shortest / 2 else float(stamps[0] - joints.time[0])
    largest = min(LARGEST_LAG, float(shortest) / 2)
    lag = stream_lag(problem_at, middle, largest, joints.speed)
    there, senses = senses_at(lag)
    if not sum(map(len, senses)):
        raise InputError(alone.apart(alone.first.recording))
    wrong = moved_joints(there, senses)
    whole = Problem(there, senses, frames, wrong, parts={**parts, clock: ("lag",)})
    estimate = whole.fit(whole.variables(("offsets",)), whole.senses)
    std = estimate.std[estimate.variables.names.index(f"{clock}.lag")]
    return lag + estimate.body.part(clock)["lag"], float(std)


def _looked_at(body: Body, streams: Streams) -> set[str]:
    """Frames that the senses begin or end in, and all that carry these."""
    found = set[str]()
    for entry in streams.run.senses:
        for name in filter(None, (entry.seen_from, entry.seen)):
            k = body.frame_index(name)
            while k >= 0:
                found.add(body.frames[k])
                k = int(body.parent[k])
    return found


def _some(sense: Sense) -> Sense:
    """A sense with some of its samples."""
    rows = np.unique(np.linspace(0, len(sense) - 1, min(len(sense), SEARCHED_ON)).astype(int))
    return sense.take(rows) if len(sense) else sense


def _sentence(streams: Streams, clock: str, lag: float, std: float) -> str:
    joints = streams.joints(streams.of_clock(clock).first.recording).joints
    how = "late" if lag >= 0 else "early"
    size = f"{abs(lag):.3f} s" if abs(lag) >= 1.0 else f"{1e3 * abs(lag):.1f} ms"
    return (
        f"The stamps of {streams.source_of(clock)} are {size} {how} (give or take "
        f"{1e3 * std:.2g} ms) by the clock of {joints.source}, as the motion tells: "
        f"{-lag:+.3f} s was added to them."
    )
