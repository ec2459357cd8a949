"""How late the camera is, learned from which lag explains the motions best.

Every motion gives each candidate lag a score: the nats by which it speaks for cells being me, added
over the cells. The lag is the peak of the sum of scores, between candidates by a parabola. How well
it is known is read off how far the peaks of the single motions scatter about it: with weights w
(height of the peak over the mean of the scores) and n = (sum w)^2 / sum w^2 motions,

    sd^2 = sum w (peak - lag)^2 / sum w / max(n - 1, 1/2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CLEAR = 10.0
"""nats by which a motion's peak must stand out to say something about the lag."""
FADING = 0.97
"""Of scores, from motion to motion."""


@dataclass(frozen=True)
class LagBelief:
    """State: scores and the scatter of the peaks, lags counted in steps."""

    score: Array
    """(L,) nats."""
    weight: float = 0.0
    """sum w"""
    weight_squared: float = 0.0
    """sum w^2"""
    first: float = 0.0
    """sum w peak"""
    second: float = 0.0
    """sum w peak^2"""

    @property
    def best(self) -> int:
        """The candidate that explains most."""
        return int(np.argmax(self.score))

    @property
    def known(self) -> bool:
        """Whether any motion has said something about the lag."""
        return self.weight > 0

    def lag(self) -> float:
        """Steps; nan if no motion has said anything yet."""
        return peak(self.score) if self.known else np.nan

    def sd(self) -> float:
        """Steps; nan if fewer than two motions have said something."""
        if self.weight == 0 or self.weight**2 <= 1.001 * self.weight_squared:
            return np.nan
        lag, n = self.lag(), self.weight**2 / self.weight_squared
        spread = (self.second - 2 * lag * self.first) / self.weight + lag**2
        return float(np.sqrt(max(spread, 0.0) / max(n - 1, 0.5)))


def after_motion(state: LagBelief, score: Array) -> LagBelief:
    """With the scores (L,) of one more motion."""
    total = FADING * state.score + score
    w = float(score.max() - score.mean())
    if w < CLEAR:
        return LagBelief(total, state.weight, state.weight_squared, state.first, state.second)
    here = peak(score)
    return LagBelief(
        total, state.weight + w, state.weight_squared + w * w, state.first + w * here,
        state.second + w * here * here,
    )  # fmt: skip


def peak(score: Array) -> float:
    """Place of the highest score, between candidates by a parabola through three."""
    at = int(np.argmax(score))
    if at in (0, len(score) - 1):
        return float(at)
    low, high, right = score[at - 1 : at + 2]
    bend = low - 2 * high + right
    return at if bend == 0 else float(at + 0.5 * (low - right) / bend)
