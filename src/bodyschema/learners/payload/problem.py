"""The cost of a guess on the sums, with its normal equations.

x = [vec R (9, rows first), b (6), phi_1 .. phi_K] is linear in every component's relation, so the
sums of all components and segments, each over its noise level, are one matrix C over x:

    F = x^T C x + pull^T Lambda pull,   H = J^T C J + Lambda,   J = dx / d(w, b, eta).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.relation_fit import Normal
from bodyschema.learners.payload.chart import SHARED, Guess, Prior
from bodyschema.learners.payload.noise_levels import Levels, Segment
from bodyschema.learners.payload.sums import SIZE

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PayloadProblem:
    """F at fixed noise levels; see `relation_fit.descend`."""

    C: Array
    """(15 + 10 K, 15 + 10 K) the weighted sums over x."""
    prior: Prior

    def normal(self, theta: Guess) -> Normal:
        """Cost, half slope and H."""
        phi, slopes = theta.loads_and_slopes()
        x, J = np.concatenate([theta.R.ravel(), theta.bias, phi.ravel()]), slope_of(theta, slopes)
        Cx, pull = self.C @ x, self.prior.pull(theta)
        drawn = self.prior.information @ pull
        H = J.T @ self.C @ J + self.prior.information
        return Normal(float(x @ Cx + pull @ drawn), J.T @ Cx + drawn, (H + H.T) / 2)

    def move(self, theta: Guess, delta: Array) -> Guess:
        """See `chart`."""
        return theta.moved(delta)


def weighted(segments: Sequence[Segment], loads: int, levels: Levels) -> Array:
    """C of the module's text: all sums over x."""
    C = np.zeros((15 + 10 * loads, 15 + 10 * loads))
    v = levels.v
    for segment in segments:
        for i in range(6):
            at = _places(i, segment.loads)
            S = segment.sums.S[0, i] / v[i]
            spread = np.zeros((SIZE, len(at)))
            spread[:3, :3] = np.eye(3)
            for n in range(len(segment.loads)):
                spread[3:13, 3 + 10 * n : 13 + 10 * n] = np.eye(10)
            spread[13, -1] = 1.0
            C[np.ix_(at, at)] += spread.T @ S @ spread
    return C


def _places(i: int, loads: tuple[int, ...]) -> list[int]:
    """Where row i of R, the loads and the bias stand in x."""
    row = 3 * (i % 3)
    phi = [15 + 10 * k + p for k in loads for p in range(10)]
    return [row, row + 1, row + 2, *phi, 9 + i]


def slope_of(theta: Guess, slopes: Array) -> Array:
    """dx / d(w, b, loads), (15 + 10 K, 9 + 10 K); slopes (K, 10, 10) are those of the loads."""
    K = len(theta.eta)
    J = np.zeros((15 + 10 * K, SHARED + 10 * K))
    for k in range(3):
        # d (exp(w) R) / d w_k = [e_k]x R.
        after, last = (k + 1) % 3, (k + 2) % 3
        J[3 * last : 3 * last + 3, k] = theta.R[after]
        J[3 * after : 3 * after + 3, k] = -theta.R[last]
    J[9:15, 3:9] = np.eye(6)
    for k, slope in enumerate(slopes):
        J[15 + 10 * k : 25 + 10 * k, SHARED + 10 * k : SHARED + 10 * (k + 1)] = slope
    return J
