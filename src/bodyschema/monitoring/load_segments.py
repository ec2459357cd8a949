"""Which stretches of a wrist's recording carry which load, and whether its two clocks agree.

    declared   somebody says when the gripper was empty and when it held something
    found      the watch cuts where it notices that the load changed

Sensor and robot often have clocks of their own: the lag is told from one load alone, up to the
first change, and taken out of the whole recording.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from bodyschema.errors import InputError
from bodyschema.learners.payload.clock_lag import clock_lag, shifted
from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.payload.recorded import Part
from bodyschema.monitoring.monitor import Monitor
from bodyschema.senses.wrench_means import Averaging, WrenchMeans
from bodyschema.senses.wrist_declaration import LoadSegments
from bodyschema.senses.wrist_samples import WristSamples

CHANGES = ("grasp", "release", "swap", "shift")

FEWEST_ALONE = 200
"""Samples from which a lag is told."""

MARGIN = 0.6
"""s round a change that belong to neither load."""


@dataclass(frozen=True)
class Happening:
    """Something that happened to the load."""

    time: float
    """s, when it was noticed."""
    event: str
    mass: float | None
    """kg, as soon as it was known again."""


def watched_events(means: WrenchMeans, learner: LoadLearner) -> tuple[Happening, ...]:
    """What the watch noticed: the first identification, and each change at its alarm."""
    monitor = Monitor(learner)
    state, events, alarm = monitor.start(), list[Happening](), None
    for k in range(len(means)):
        state, info = monitor.step(state, (means.take(slice(k, k + 1)),))
        now, load = float(means.time[k]), state.belief.load
        if info.event == "alarm":
            alarm = now if alarm is None else alarm
        elif info.event and load is not None:
            when = now if alarm is None else alarm
            events.append(Happening(when, info.change or info.event, load.mass))
            alarm = None
    return tuple(events)


def found_segments(
    means: WrenchMeans, learner: LoadLearner
) -> tuple[tuple[Happening, ...], list[Part]]:
    """What happened in a motion, and its stretches, cut where the load was noticed to change."""
    if not np.isfinite(learner.turn_std):
        return (), [Part(means, ("load",))]
    events = watched_events(means, learner)
    cuts = [event.time for event in events if event.event in CHANGES]
    if not cuts:
        return events, [Part(means, ("load",))]
    edges, parts = [-np.inf, *cuts, np.inf], []
    for k, (low, high) in enumerate(pairwise(edges)):
        rows = np.flatnonzero((means.time > low + MARGIN) & (means.time < high - MARGIN))
        if len(rows) > 2:
            parts.append(Part(means.take(rows), (f"load {k + 1}",)))
    return events, parts


def declared_segments(
    samples: WristSamples,
    segments: LoadSegments,
    means: Callable[[WristSamples], WrenchMeans],
    empty: WristSamples | None = None,
) -> list[Part]:
    """The gripper alone, and the gripper with its object; one load where only one was declared.

    Args:
        samples: the recording.
        segments: times of it.
        means: of samples.
        empty: another recording, of the gripper alone.

    Raises:
        InputError: a segment is no pair of times, or holds too few rows.
    """
    parts = []
    if empty is not None:
        parts.append(Part(means(empty), ("gripper",)))
    for name, spans in (("empty", segments.empty), ("loaded", segments.loaded)):
        loads = ("gripper",) if name == "empty" else ("gripper", "object")
        for low, high in _pairs(spans, name):
            parts.append(Part(means(between(samples, low, high, name)), loads))
    if empty is not None and not segments.loaded:
        parts.append(Part(means(samples), ("gripper", "object")))
    kinds = {part.loads for part in parts}
    if len(kinds) < 2:
        return [replace(part, loads=("load",)) for part in parts]
    return parts


def between(samples: WristSamples, low: float, high: float, name: str) -> WristSamples:
    """The samples of a stretch of time, s.

    Raises:
        InputError: there are fewer than two.
    """
    time = samples.time
    rows = np.flatnonzero((time >= low) & (time <= high))
    if len(rows) < 2:
        raise InputError(
            f"segment {name} = [{low:g}, {high:g}] holds {len(rows)} rows; the recording "
            f"runs from {time[0]:.13g} to {time[-1]:.13g} s."
        )
    return samples.take(rows)


def _pairs(spans: Sequence[Any], name: str) -> list[tuple[float, float]]:
    """[(low, high), ...] of one pair or a list of pairs."""
    listed = [spans] if spans and not isinstance(spans[0], list | tuple) else list(spans)
    for pair in listed:
        if len(pair) != 2 or not pair[0] < pair[1]:
            raise InputError(f"segment {name} must be [from, to] in s, or a list of such pairs.")
    return [(float(low), float(high)) for low, high in listed]


def on_one_clock(
    samples: WristSamples, learner: LoadLearner, averaging: Averaging
) -> tuple[WristSamples, float]:
    """The samples with the wrench on the clock of the motion, and by how much it was late, s."""
    events = watched_events(averaging.means(samples), learner)
    first = next((event.time for event in events if event.event in CHANGES), np.inf)
    rows = np.flatnonzero(samples.time < first - MARGIN)
    if len(rows) < FEWEST_ALONE:
        return samples, 0.0
    lag = clock_lag(samples.take(rows), learner, averaging).lag
    return (shifted(samples, lag) if lag else samples), lag
