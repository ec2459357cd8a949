"""Is the camera late? Several learners side by side, one for each possible lag.

The images of time stamp t show the hand as it was at t - lag. Each candidate lag gets the hand's
pose from the joint path at its own moment and its own sums; at the end of a stretch the costs
F(lag) lie on a parabola near the true lag, whose lowest point is the estimate and whose
curvature its information (F / tau is chi-square):

    lag = argmin F,   sd = (F'' / (2 tau))^-1/2

Memory is that of so many sums; no sample is kept.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.estimation.relation_fit import descend
from bodyschema.learners.hand_eye.belief import PointCost, correlation_time
from bodyschema.learners.hand_eye.chart import CameraAndPoints
from bodyschema.learners.hand_eye.point_memory import PointMemory
from bodyschema.learners.hand_eye.points import HandEyePoints
from bodyschema.learners.hand_eye.rotation_search import search
from bodyschema.learners.learner import in_turn

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Lag:
    """An estimated lag of the images."""

    seconds: float
    std: float
    """s; inf where the lowest cost is at the edge of the candidates."""


@dataclass(frozen=True)
class LatePoints:
    """Points that were seen a while after the hand was where it is said to be."""

    T_world_hand: Array
    """(n_lags, 4, 4) the hand's pose at t - lag for every lag."""
    pixels: Array
    """(K, 3) u_left, v, u_right of each point; nan where it was not seen."""


@dataclass(frozen=True)
class ClockSearch:
    """Learns how late the camera is, from a stream that tells the hand's pose at any time."""

    learner: HandEyePoints
    lags: tuple[float, ...] = (-1 / 30, 0.0, 1 / 30, 2 / 30, 3 / 30)
    """s, evenly spaced, in rising order; three or more."""

    def __post_init__(self) -> None:
        steps = np.diff(self.lags)
        if len(self.lags) < 3 or not np.allclose(steps, steps[0]) or steps[0] <= 0:
            raise InputError(
                f"lags must be three or more, evenly spaced and rising; got {self.lags}."
            )

    def finer(self, lag: float) -> ClockSearch:
        """A search round a found lag, in steps a sixth as long.

        A parabola over long steps is off by a few tenths of a millisecond, because the hand's path
        bends in between; over short steps it is not.
        """
        step = (self.lags[1] - self.lags[0]) / 6
        return replace(self, lags=tuple(lag + step * i for i in (-2, -1, 0, 1, 2)))

    def start(self) -> tuple[PointMemory, ...]:
        """Nothing seen."""
        return tuple(PointMemory.empty(self.learner.points) for _ in self.lags)

    def step(
        self, state: tuple[PointMemory, ...], moment: tuple[LatePoints, ...]
    ) -> tuple[tuple[PointMemory, ...], tuple[int, ...]]:
        """The sums for every lag after one moment, and how many points were seen."""
        return in_turn(self._add, state, moment)

    def _add(
        self, state: tuple[PointMemory, ...], sample: LatePoints
    ) -> tuple[tuple[PointMemory, ...], int]:
        pixels = sample.pixels
        depth = self.learner.stereo.depth(pixels)[None]
        keep = np.isfinite(depth) & np.isfinite(pixels).all(axis=1)
        numbers = self.learner.stereo.numbers
        after = tuple(
            memory.add(np.ascontiguousarray(T)[None], pixels[None], depth, keep, numbers)
            for memory, T in zip(state, sample.T_world_hand, strict=True)
        )
        return after, int(np.sum(keep))

    def solve(self, state: tuple[PointMemory, ...]) -> Lag:
        """The lag, from the parabola through the three lowest costs."""
        fits = [self._fit(memory) for memory in state]
        costs = np.array([memory.cost(theta) for memory, theta in zip(state, fits, strict=True)])
        best, step = int(np.argmin(costs)), self.lags[1] - self.lags[0]
        if best in (0, len(costs) - 1):
            return Lag(self.lags[best], np.inf)
        left, middle, right = costs[best - 1 : best + 2]
        bend = left - 2 * middle + right
        lag = self.lags[best] + step * (left - right) / (2 * bend)
        # The wrong lags' residuals are correlated through the motion; only the best one's tau is
        # about noise.
        tau = correlation_time(state[best].correlation(fits[best]))
        return Lag(float(lag), float(step * np.sqrt(2 * tau / bend)))

    def _fit(self, memory: PointMemory) -> CameraAndPoints:
        found = [descend(PointCost(memory, 1.0, None), start) for start in search(memory.D)]
        return min(found, key=lambda each: each[1].cost)[0]
