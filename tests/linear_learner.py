"""The simplest learner that can be watched: y = A x + noise, with all that it believes exact.

What goes wrong in a watch over it is the watch's own fault. The names of the watching code come
through here, so that tests of its promises need not follow each of its moves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.belief import GaussianBelief, Slopes, WhiteInnovation, forget, inverse
from bodyschema.estimation.certificate import Certificate, Tolerance
from bodyschema.estimation.stream_noise import StreamNoise, outlier_limit
from bodyschema.learners.learner import MonitoredLearner, in_turn
from bodyschema.monitoring.blame import begin, dated, weigh
from bodyschema.monitoring.monitor import Monitor, MonitorState
from bodyschema.monitoring.whitening import prepare

__all__ = [
    "GaussianBelief",
    "Linear",
    "Monitor",
    "Stream",
    "StreamNoise",
    "WhiteInnovation",
    "begin",
    "dated",
    "prepare",
    "weigh",
]

Array = NDArray[np.float64]


class Sample(NamedTuple):
    """One moment."""

    A: Array
    """(m, k)."""
    y: Array
    """(m,)."""


@dataclass(frozen=True)
class Known:
    """State: what is believed."""

    x: Array
    information: Array
    samples: int = 0
    cost: float = 0.0
    rows: float = 0.0
    recent: float = 0.0
    """Running share of outliers."""
    relearning: bool = False


@dataclass(frozen=True)
class Linear(MonitoredLearner[Known, Sample, tuple[float, ...]]):
    """Settings."""

    parts: Mapping[str, Sequence[int]]
    """Block -> its variables."""
    prior: float = 10.0
    """Standard deviation of each variable."""
    bound: float = 0.5
    """Standard deviation of the worst direction that is good enough."""
    correlation: float = 0.0
    level: float = 1.0
    """Variance of the noise."""
    outliers: float = 0.01
    """Share of them, as believed."""

    @cached_property
    def blocks(self) -> Mapping[str, NDArray[np.int64]]:
        return {name: np.array(rows, dtype=np.int64) for name, rows in self.parts.items()}

    @property
    def size(self) -> int:
        """Number of variables."""
        return 1 + max(max(rows) for rows in self.parts.values())

    @property
    def tau(self) -> float:
        """Long-run variance over the level."""
        return (1 + self.correlation) / (1 - self.correlation)

    def start(self) -> Known:
        return Known(np.zeros(self.size), np.eye(self.size) / self.prior**2)

    def step(self, state: Known, moment: tuple[Sample, ...]) -> tuple[Known, tuple[float, ...]]:
        return in_turn(self._learn, state, moment)

    def _learn(self, state: Known, sample: Sample) -> tuple[Known, float]:
        noise = self.tau * self.level
        e = sample.y - sample.A @ state.x
        S = noise * np.eye(len(e)) + sample.A @ np.linalg.solve(state.information, sample.A.T)
        q = float(e @ np.linalg.solve(S, e))
        limit = outlier_limit(len(e))
        recent = state.recent + (float(q > limit) - state.recent) / 30
        state = replace(
            state, samples=state.samples + 1, cost=state.cost + min(q, limit),
            rows=state.rows + len(e), recent=recent,
        )  # fmt: skip
        if q > limit:
            return state, q
        L = state.information + sample.A.T @ sample.A / noise
        x = state.x + np.linalg.solve(L, sample.A.T @ e) / noise
        return replace(state, x=x, information=L), q

    def innovation(self, state: Known, moment: tuple[Sample, ...]) -> WhiteInnovation:
        A = np.concatenate([sample.A for sample in moment])
        y = np.concatenate([sample.y for sample in moment])
        source = np.repeat(np.arange(len(moment)), [len(sample.y) for sample in moment])
        return WhiteInnovation(y - A @ state.x, A, source)

    def belief(self, state: Known) -> GaussianBelief:
        share = 100.0 * self.outliers
        noise = StreamNoise(self.level, self.correlation, 0.0, share, state.recent)
        relearned = state.relearning and state.rows > 0
        return GaussianBelief(
            inverse(state.information),
            Tolerance({"x": 2.58 * self.bound}),
            noise,
            self.tau * self.level,
            state.cost,
            state.rows,
            fit=state.cost / state.rows if relearned else 1.0,
            freedom=state.rows,
            begun=state.samples >= 6,
        )

    def certificate(self, state: Known) -> Certificate:
        directions = np.linalg.eigh(state.information)[1].T
        return self.belief(state).certificate({"x": Slopes(directions[:, None], "m")})

    def forget(self, state: Known, block: str) -> Known:
        L = state.information
        if block:
            L = forget(L, self.blocks[block], self.prior**-2.0)
        return Known(state.x, L, relearning=True)

    def difference(self, state: Known, earlier: Known) -> Array:
        return state.x - earlier.x


class Stream:
    """Samples of a truth that may change, with noise as a `Linear` believes it."""

    def __init__(self, learner: Linear, x: Array, seed: int, rows: int = 3) -> None:
        self.learner, self.x, self.rows = learner, np.array(x, dtype=np.float64), rows
        self.rng = np.random.default_rng(seed)
        self.noise = self.rng.normal(size=rows)

    def draw(self, wild: float = 0.0, A: Array | None = None) -> Sample:
        """The next one; with so much more noise if `wild`."""
        r = self.learner.correlation
        self.noise = r * self.noise + np.sqrt(1 - r * r) * self.rng.normal(size=self.rows)
        A = self.rng.normal(size=(self.rows, len(self.x))) if A is None else A
        e = np.sqrt(self.learner.level) * self.noise + wild * self.rng.normal(size=self.rows)
        return Sample(A, A @ self.x + e)


Events = list[tuple[int, str, str]]


def follow(
    monitor: Monitor[Known, Sample], state: MonitorState[Known, Sample], samples: Sequence[Sample]
) -> tuple[MonitorState[Known, Sample], Events]:
    """Feed samples, each a moment; see `watch`."""
    return watch(monitor, state, [(sample,) for sample in samples])


def watch(
    monitor: Monitor[Any, Any], state: MonitorState[Any, Any], moments: Sequence[tuple[Any, ...]]
) -> tuple[MonitorState[Any, Any], Events]:
    """Feed moments; the state, and number, event and block of all that was reported."""
    events: Events = []
    for i, moment in enumerate(moments):
        state, report = monitor.step(state, moment)
        if report.event:
            events.append((i, report.event, report.block))
    return state, events


def certified(monitor: Monitor[Known, Sample], stream: Stream) -> MonitorState[Known, Sample]:
    """The state once it observes.

    Raises:
        AssertionError: it never does.
    """
    state = monitor.start()
    for _ in range(400):
        state, report = monitor.step(state, (stream.draw(),))
        if report.event == "identified":
            return state
    raise AssertionError("never certified.")
