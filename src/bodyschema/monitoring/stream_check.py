"""Does a calibration hold all through a recording, and if not: since when, and what changed?

The calibrated body goes into the monitor as a certified belief, which then only watches. A joint's
zero or a frame that the calibration did not free counts as known, but may change. The size and the
memory of the noise are measured on the recording itself, whatever changes in it. A robot that rests
tells one thing again and again, with the slow error that its sensor has there: a moment is watched
only where it has moved since the one before, and what changed while it rested shows when it moves.

When the monitor has named a part and learned it again, the moment s of the change is the one that
divides the recording best between the old belief and the new,

    s = argmax sum_{i >= s} (q_i(old) - q_i(new))

with q the squared white residual of a moment, each sense's at most as large as the rarest good
one. The size of the change is the difference of both beliefs, its covariance the sum of theirs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.stream_noise import StreamNoise, measured, outlier_limit
from bodyschema.learners.learner import Moment, moments
from bodyschema.learners.watched_body import WatchedBelief, WatchedBody
from bodyschema.monitoring.blame import EVERYTHING
from bodyschema.monitoring.monitor import Monitor, MonitorState
from bodyschema.monitoring.parts import parts_of
from bodyschema.senses.sense import Sense
from bodyschema.threads import one_thread

Array = NDArray[np.float64]

EXACT = 1e-3
"""Of its prior: standard deviation of what the calibration held as modelled."""

FEWEST, SLOWEST = 200, 0.2
"""Moments that make a stream, and s between two of them at most."""

RESTING = 1e-3
"""rad or m: a posture nearer than that, in every joint, to that of the last moment watched is the
same one; ten times what encoders flicker by."""

BACK = 600
"""Moments before the alarm that may be the moment of the change."""

UNNAMED = ""
"""The part, when the recording ends before one is named."""


@dataclass(frozen=True)
class Change:
    """One change within a recording."""

    part: str
    """A joint or a frame, EVERYTHING or UNNAMED."""
    time: float
    """s: when it happened."""
    row: int
    """Of the recording, at that time."""
    noticed: float
    """s: when the alarm came."""
    names: tuple[str, ...] = ()
    """(k,) of the part's parameters."""
    change: tuple[float, ...] = ()
    """(k,) rad and m."""
    std: tuple[float, ...] = ()
    """(k,) rad and m."""
    p_value: float = 0.0
    """Chance of so large a difference between old and new belief without a change."""


@dataclass(frozen=True)
class StreamCheck:
    """What watching a recording showed."""

    changes: tuple[Change, ...]
    """In order of time."""
    seconds: float
    """Length of the recording."""
    noise: StreamNoise
    """Measured on the recording, in units of the calibration's noise."""


def is_stream(senses: Sequence[Sense]) -> bool:
    """Whether a recording has enough moments, close enough in time, to be watched."""
    times = np.unique(np.concatenate([sense.time for sense in senses]))
    return len(times) >= FEWEST and float(np.median(np.diff(times))) <= SLOWEST


@one_thread
def check_stream(
    estimate: Estimate, senses: Sequence[Sense], false_alarm: float = 0.01
) -> StreamCheck:
    """Watch a recording with a calibration.

    Args:
        estimate: of the calibration, with its noise levels.
        senses: what was seen, with times; frames must be in the estimate's reference body.
        false_alarm: chance of an alarm in the whole recording without a change.
    """
    times = np.unique(np.concatenate([sense.time for sense in senses]))
    seconds = float(times[-1] - times[0])
    senses = in_motion(senses)
    if not is_stream(senses):
        return StreamCheck((), seconds, StreamNoise())
    known = _with_all_parts(estimate, senses)
    learner = WatchedBody(known.reference, known.variables)
    noise = _noise(learner, known, senses)
    belief = learner.known(known, noise, tuple(senses))
    stream = moments(senses)
    monitor = Monitor(learner, len(stream) / false_alarm)
    found = _changes(learner, monitor, monitor.observing(belief), stream)
    return StreamCheck(found, seconds, noise)


def in_motion(senses: Sequence[Sense]) -> list[Sense]:
    """The samples of those moments before which the robot has moved."""
    time = np.concatenate([sense.time for sense in senses])
    q = np.concatenate([sense.q for sense in senses])
    times, first = np.unique(time, return_index=True)
    kept, last = [], np.full(q.shape[1], np.inf)
    for t, here in zip(times, q[first], strict=True):
        if np.abs(here - last).max() > RESTING:
            kept.append(t)
            last = here
    return [sense.take(np.flatnonzero(np.isin(sense.time, kept))) for sense in senses]


def _changes(
    learner: WatchedBody,
    monitor: Monitor[WatchedBelief, Sense],
    watch: MonitorState[WatchedBelief, Sense],
    stream: Sequence[Moment],
) -> tuple[Change, ...]:
    """Run the monitor; every change that it reports, sized when it was learned."""
    found: list[Change] = []
    old, block, alarm, first = watch.belief, UNNAMED, -1, 0
    for i, moment in enumerate(stream):
        before = watch.belief
        watch, report = monitor.step(watch, moment)
        if report.event == "alarm":
            old, block, alarm = before, UNNAMED, i
        elif report.event == "dismissed":
            alarm = -1
        elif report.event == "changed":
            block = report.block
            if block == EVERYTHING:
                break
        elif report.event == "identified":
            found.append(
                _sized(learner, block, old, watch.belief, stream[first : i + 1], alarm - first)
            )
            first, alarm = i + 1, -1
    if alarm >= 0:
        new = watch.belief if block not in (UNNAMED, EVERYTHING) else None
        found.append(_sized(learner, block, old, new, stream[first:], alarm - first))
    return tuple(found)


def _sized(
    learner: WatchedBody,
    block: str,
    old: WatchedBelief,
    new: WatchedBelief | None,
    stream: Sequence[Moment],
    alarm: int,
) -> Change:
    """The change between two beliefs; `stream` was seen since the change before."""
    noticed = stream[alarm][0]
    at = noticed
    if new is None:
        return Change(block, float(at.time[0]), int(at.rows[0]), float(noticed.time[0]))
    from_ = max(0, alarm - BACK)
    at = stream[from_ + _onset(learner, old, new, stream[from_:])][0]
    rows = learner.blocks[block]
    d = learner.difference(new, old)[rows]
    P = (learner.belief(new).doubt + learner.belief(old).doubt)[np.ix_(rows, rows)]
    return Change(
        block,
        float(at.time[0]),
        int(at.rows[0]),
        float(noticed.time[0]),
        tuple(learner.variables.names[k] for k in rows),
        tuple(map(float, d)),
        tuple(map(float, np.sqrt(np.diag(P)))),
        float(chdtrc(len(d), d @ np.linalg.solve(P, d))),
    )


def _onset(
    learner: WatchedBody, old: WatchedBelief, new: WatchedBelief, stream: Sequence[Moment]
) -> int:
    """The moment from which on the new belief explains better."""
    gain = [_squared(learner, old, moment) - _squared(learner, new, moment) for moment in stream]
    return int(np.argmax(np.cumsum(gain[::-1])[::-1]))


def _squared(learner: WatchedBody, belief: WatchedBelief, moment: Moment) -> float:
    white = learner.innovation(belief, moment)
    squares = [white.e[white.source == k] for k in np.unique(white.source)]
    return sum(min(float(e @ e), outlier_limit(len(e))) for e in squares)


def _with_all_parts(estimate: Estimate, senses: Sequence[Sense]) -> Estimate:
    """The estimate with parameters for every part that may change and that the senses can see."""
    variables, _ = parts_of(estimate, senses)
    known = len(estimate.x)
    x = np.concatenate([estimate.x, np.zeros(len(variables) - known)])
    some = [s.take(np.unique(np.linspace(0, len(s) - 1, 50).astype(int))) for s in senses]
    slopes = [s.linearize(estimate.reference, variables, x).by_parameter for s in some]
    seen = np.max([np.abs(J).max(axis=(0, 1)) for J in slopes], axis=0) > 0
    keep = [i for i in range(len(variables)) if i < known or seen[i]]
    taken = variables.take(keep)
    data = np.diag((EXACT * taken.prior_std) ** -2.0)
    data[:known, :known] = estimate.data_information
    return replace(estimate, variables=taken, x=x[keep], data_information=data)


def _noise(learner: WatchedBody, known: Estimate, senses: Sequence[Sense]) -> StreamNoise:
    """Noise of the recording, in units of the calibration's."""
    belief = learner.known(known, StreamNoise(), tuple(senses))
    parts = [learner.innovations(belief, sense) for sense in senses]
    return measured([e for e, _ in parts], [J for _, J in parts])
