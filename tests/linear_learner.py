"""The simplest learner that can be watched: y = A x + noise, with all that it believes exact.

What goes wrong in a watch over it is the watch's own fault. The names of the watching code come
through here, so that tests of its promises need not follow each of its moves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.certificate import Certificate
from bodyschema.estimation.stream_noise import wild_beyond
from bodyschema.learners.watchable import Doubt, WhiteInnovation
from bodyschema.monitoring.machine import Machine, Report
from bodyschema.monitoring.whitening import prepare

__all__ = ["Doubt", "Linear", "Monitor", "Sample", "Stream", "WhiteInnovation", "prepare"]

Array = NDArray[np.float64]

Monitor = Machine


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
    wild: float = 0.0
    """Running share of wild samples."""
    relearning: bool = False


@dataclass(frozen=True)
class Linear:
    """Settings."""

    parts: Mapping[str, Sequence[int]]
    """Block -> its variables."""
    prior: float = 10.0
    """Standard deviation of each variable."""
    bound: float = 0.5
    """Standard deviation of the worst variable that is good enough."""
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

    def step(self, state: Known, sample: Sample) -> Known:
        noise = self.tau * self.level
        e = sample.y - sample.A @ state.x
        S = noise * np.eye(len(e)) + sample.A @ np.linalg.solve(state.information, sample.A.T)
        q = float(e @ np.linalg.solve(S, e))
        limit = wild_beyond(len(e))
        wild = state.wild + (float(q > limit) - state.wild) / 30
        state = replace(
            state, samples=state.samples + 1, cost=state.cost + min(q, limit),
            rows=state.rows + len(e), wild=wild,
        )  # fmt: skip
        if q > limit:
            return state
        L = state.information + sample.A.T @ sample.A / noise
        x = state.x + np.linalg.solve(L, sample.A.T @ e) / noise
        return replace(state, x=x, information=L)

    def innovation(self, state: Known, sample: Sample) -> WhiteInnovation:
        e = sample.y - sample.A @ state.x
        return WhiteInnovation(e, sample.A, np.zeros(len(e), dtype=np.int64))

    def doubt(self, state: Known) -> Doubt:
        P = np.linalg.inv(state.information)
        return Doubt((P + P.T) / 2, self.correlation, self.level, self.outliers)

    def difference(self, state: Known, earlier: Known) -> Array:
        return state.x - earlier.x

    def certificate(self, state: Known) -> Certificate:
        std = float(np.sqrt(np.linalg.eigvalsh(self.doubt(state).covariance)[-1]))
        cost, n = self.evidence(state)
        fits = not state.relearning or cost < self.level * (n + 6 * np.sqrt(2 * n))
        holds = std < self.bound and state.wild < 0.3 and fits and state.samples >= 6
        return Certificate(holds, {"x": std}, 1.0, () if holds else ("not yet.",))

    def forget(self, state: Known, block: str) -> Known:
        L = state.information.copy()
        if block:
            t = self.blocks[block]
            L = L - L[:, t] @ np.linalg.solve(L[np.ix_(t, t)], L[t])
            L[t], L[:, t] = 0.0, 0.0
            L[t, t] = self.prior**-2.0
        return Known(state.x, (L + L.T) / 2, relearning=True)

    def evidence(self, state: Known) -> tuple[float, float]:
        return state.cost * self.level, state.rows

    def astray(self, state: Known) -> bool:
        return state.wild > 0.5


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
    monitor: Machine[Known, Sample], state: object, samples: Sequence[Sample]
) -> tuple[object, Events]:
    """Feed samples; the state, and number, event and block of all that was reported."""
    events: Events = []
    for i, sample in enumerate(samples):
        report: Report
        state, report = monitor.step(state, sample)  # type: ignore[arg-type]
        if report.event:
            events.append((i, report.event, report.block))
    return state, events


def certified(monitor: Machine[Known, Sample], stream: Stream) -> object:
    """The state once it observes.

    Raises:
        AssertionError: it never does.
    """
    state = monitor.start()
    for _ in range(400):
        state, report = monitor.step(state, stream.draw())
        if report.event == "identified":
            return state
    raise AssertionError("never certified.")
