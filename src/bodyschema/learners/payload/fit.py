"""The most likely rotation, bias and loads, from the sums alone.

With x = [vec R (9, rows first), b (6), phi_1 .. phi_K] and the sums S of each segment s (`sums`),

    F = sum_s sum_i z_si^T S_si z_si / v_i + pull^T Lambda pull,      z_si a part of x,

is minimised over the chart (`chart`) by damped Gauss-Newton on the exact sums. v_i is the long-run
variance of component i: its mean squared residual at the last solution times tau, how much slower
than white noise it averages out. So errors of the accelerations, of the sensor's gain or of the
model weigh what they are seen to weigh, nobody needs to declare a noise level, and chi-square per
degree of freedom is about 1.

Noise in y adds sum_i R_i Sigma R_i^T / v_i to F, which draws R towards the quieter axes; against a
load of a newton the pull is below a microradian, and it is left in.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.relation_fit import descend
from bodyschema.learners.payload.chart import SHARED, Guess, Prior, open_information
from bodyschema.learners.payload.noise_levels import Levels, Segment, measured_levels
from bodyschema.learners.payload.problem import PayloadProblem, slope_of, weighted
from bodyschema.learners.payload.start import best_start

Array = NDArray[np.float64]

STEPS, WARM, GAIN = 40, 8, 1e-3
"""Most evaluations of a descent, cold and warm, and the gain in chi-square that is worth one."""


@dataclass(frozen=True)
class Solution:
    """The minimum and what is round it."""

    guess: Guess
    covariance: Array
    """(9 + 10 K, 9 + 10 K) of w, b, phi_1 .. phi_K."""
    levels: Levels
    cost: float
    settled: bool

    def phi_covariance(self, k: int) -> Array:
        """(10, 10) of load k's inertial parameters."""
        at = slice(SHARED + 10 * k, SHARED + 10 * (k + 1))
        return self.covariance[at, at]


def solve(
    segments: Sequence[Segment],
    prior: Prior,
    start: Guess | None,
    noise: Levels,
    rounds: int = 6,
) -> Solution:
    """Minimise F and settle the noise levels, by turns.

    Args:
        segments: with the loads that each carries.
        prior: of the chart.
        start: where to begin; None asks a linear solution.
        noise: that is believed at first.
        rounds: most turns.
    """
    guess = best_start(segments, prior, noise) if start is None else start
    levels = noise if start is None else measured_levels(segments, guess, noise)
    settled = False
    steps = STEPS if rounds > 1 else WARM
    for _ in range(rounds):
        problem = PayloadProblem(weighted(segments, len(guess.eta), levels), prior)
        guess, _, rested = descend(problem, guess, steps, GAIN)
        after = measured_levels(segments, guess, noise)
        settled = rested and bool(np.abs(np.log(after.v / levels.v)).max() < 0.02)
        levels = after
        if settled:
            break
    C = weighted(segments, len(guess.eta), levels)
    cost = PayloadProblem(C, prior).normal(guess).cost
    return Solution(guess, _covariance(C, prior, guess), levels, cost, settled)


def _covariance(C: Array, prior: Prior, guess: Guess) -> Array:
    """Of w, b and the linear parameters of the loads."""
    K = len(guess.eta)
    J = slope_of(guess, np.tile(np.eye(10), (K, 1, 1)))
    H = J.T @ C @ J
    H[:SHARED, :SHARED] += prior.information[:SHARED, :SHARED]
    H[SHARED:, SHARED:] += np.diag(np.concatenate([open_information(p) for p in guess.phi]))
    # Variables differ by many powers of ten; balanced, the inverse keeps its digits.
    scale = 1 / np.sqrt(np.diag(H))
    inverse = np.linalg.inv(H * np.outer(scale, scale)) * np.outer(scale, scale)
    return np.asarray((inverse + inverse.T) / 2)
