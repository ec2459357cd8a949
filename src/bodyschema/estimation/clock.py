"""Was the body seen at the moment when its joints were read? A test for late rows.

If row i was seen after the robot had begun to move on, its residual points along the motion that
followed, m_i = J(q_i) (q_(i+1) - q_i). The projection z_i = m_i . r_i / |m_i|, in units of its own
spread, is about standard normal for honest rows and positive for late ones. The statistic
sum max(z, 0)^2 is compared with its values when every motion is given the residual of some other
row: that keeps residuals and motions as they are and breaks only the link between them. Residuals
that resemble their neighbours, because a model error changes slowly along a smooth movement, are
moved in runs twice as long as the resemblance; single rows would promise more than they know.

Shuffles are drawn a block at a time and end early when enough of them have reached the statistic
(Besag and Clifford 1991): the p-value stays exact, and an honest recording costs little.

Which rows are late is told by a mixture, fitted by expectation-maximisation: honest rows are
z ~ N(0, 1), late ones z ~ N(0, 1) plus an exponential shift,

    p(z | late) = exp(1 / (2 k^2) - z / k) Phi(z - 1 / k) / k,     k the mean shift.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, log_ndtr

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.normal_equations import level_rows
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SHUFFLES = 2000
ENOUGH = 50
"""Shuffles that reach the statistic after which no more are drawn; p is then known to 14 %."""

BLOCK = 100_000
"""Projections that are held at a time; the median of so many is known to half a percent."""

FEWEST_RUNS = 10
"""So many runs of residuals at least: fewer have too few orders for a small p-value."""

FALSE_ALARM = 0.01
"""Chance of calling a fault where there is none."""

SHARED = 0.9
"""Share of the longest sense's rows that another one must have to be tested with it."""

FEWEST_ROWS = 10

SQRT_2PI = float(np.sqrt(2 * np.pi))

LARGEST = 4.0
"""Standard deviations at which the mixture clips z: one very late row must not set the scale."""


@dataclass(frozen=True)
class ClockCheck:
    """Verdict on the clocks of one recording."""

    p_value: float
    """Chance of so much agreement between residuals and following motions without a fault."""
    late_rows: tuple[int, ...]
    """Rows more likely late than not; empty when there is no fault."""
    instead: str = ""
    """Another cause that explains the residuals better, in words; "" if there is none."""

    @property
    def faulty(self) -> bool:
        """Whether a clock fault is certain enough to report."""
        return self.p_value < FALSE_ALARM


def check_clock(fit: Estimate, senses: Sequence[Sense], seed: int = 0) -> ClockCheck:
    """Test the residuals of a fit for rows seen after the robot had begun to move on.

    Args:
        fit: of a body to these samples.
        senses: what was seen; row numbers in the order of recording.
        seed: of the shuffles.
    """
    rows, residual, slope, q = _common_rows(fit, senses)
    n = len(rows) - 1
    if n < FEWEST_ROWS:
        return ClockCheck(1.0, ())
    residual, motion = residual[:n], _following(slope[:n], q)
    p_value, spread = chance(residual, motion, np.random.default_rng(seed))
    if p_value >= FALSE_ALARM:
        return ClockCheck(p_value, ())
    z = np.sum(residual * motion, axis=1) / spread
    late = rows[:n][_late_share(np.minimum(z, LARGEST)) > 0.5]
    return ClockCheck(p_value, tuple(int(row) for row in late))


def chance(residual: Array, motion: Array, rng: np.random.Generator) -> tuple[float, float]:
    """How often residuals agree so well with motions that are not their own.

    Args:
        residual: (n, d) in noise units.
        motion: (n, d) unit vectors, or zero where nothing moved.
        rng: of the shuffles.

    Returns:
        The p-value, and the spread of the projection of an honest row.
    """
    n, length = len(residual), _run_length(residual)
    real = _agreement(np.sum(residual * motion, axis=1))
    drawn, reached, spread = 0, 0, 0.0
    while drawn < SHUFFLES:
        count = min(max(BLOCK // n, 1), SHUFFLES - drawn)
        order = np.array([_shuffled(n, length, rng) for _ in range(count)])
        pairs = zip(motion.T, residual.T, strict=True)
        null = np.sum([along * part[order] for along, part in pairs], axis=0)
        if not drawn:
            # The median of |z| for a standard normal z is 0.6745.
            spread = max(float(np.median(np.abs(null))) / 0.6745, 1e-300)
        reaches = reached + np.cumsum(_agreement(null) >= real)
        if reaches[-1] >= ENOUGH:
            return ENOUGH / (drawn + int(np.searchsorted(reaches, ENOUGH)) + 1), spread
        drawn, reached = drawn + count, int(reaches[-1])
    return (reached + 1) / (SHUFFLES + 1), spread


def _run_length(residual: Array) -> int:
    """How many neighbouring residuals are moved together: 1 if they do not resemble each other,
    else twice the rows over which they do by two standard errors."""
    n, d = residual.shape
    longest = max(len(residual) // FEWEST_RUNS, 1)
    power = float(np.mean(np.sum(residual**2, axis=1)))
    for lag in range(1, longest):
        alike = float(np.mean(np.sum(residual[lag:] * residual[:-lag], axis=1)))
        if alike <= 2 / np.sqrt(n * d) * power:
            return 1 if lag == 1 else min(2 * lag, longest)
    return longest


def _shuffled(n: int, length: int, rng: np.random.Generator) -> Ints:
    """An order of n rows in which runs of some length stay together."""
    runs = rng.permutation(n // length)
    order = (length * runs[:, None] + np.arange(length)).ravel()
    order = np.append(order, np.arange(len(order), n))
    return np.asarray((order + rng.integers(n)) % n)


def _agreement(z: Array) -> Array:
    return np.asarray(np.sum(np.maximum(z, 0) ** 2, axis=-1))


def _common_rows(fit: Estimate, senses: Sequence[Sense]) -> tuple[Ints, Array, Array, Array]:
    """Rows that several senses have; residuals (n, d) in noise units, slopes (n, d, n_joints), q.

    Of the sense with the most rows, and of the others that have nearly all of them too.
    """
    batches = [
        _by_row(fit, sense, levels)
        for sense, levels in zip(senses, fit.levels, strict=True)
        if len(sense)
    ]
    longest = max(batches, key=lambda batch: len(batch.rows)).rows
    joined = [batch for batch in batches if np.isin(longest, batch.rows).mean() >= SHARED]
    rows = reduce(np.intersect1d, (batch.rows for batch in joined))
    kept = [np.isin(batch.rows, rows) for batch in joined]
    pairs = list(zip(joined, kept, strict=True))
    return (
        rows,
        np.concatenate([batch.residual[mask] for batch, mask in pairs], axis=1),
        np.concatenate([batch.slope[mask] for batch, mask in pairs], axis=1),
        joined[0].q[kept[0]],
    )


class _Rows(NamedTuple):
    """One sense, its samples of one row (the corners of a picture) taken together."""

    rows: Ints
    residual: Array
    slope: Array
    q: Array


def _by_row(fit: Estimate, sense: Sense, levels: Sequence[float]) -> _Rows:
    """Sums over the samples of each row, over the root of their number: unit noise again."""
    scale = np.sqrt(np.diag(sense.covariance)) * level_rows(sense, levels)
    linear = sense.linearize(fit.reference, fit.variables, fit.x)
    rows, first, index, count = np.unique(
        sense.rows, return_index=True, return_inverse=True, return_counts=True
    )

    def summed(values: Array) -> Array:
        total = np.zeros((len(rows), *values.shape[1:]))
        np.add.at(total, index.ravel(), values)
        return np.asarray((total.T / np.sqrt(count)).T)

    residual, slope = summed(linear.residual / scale), summed(-linear.by_joint / scale[:, None])
    return _Rows(rows, residual, slope, sense.q[first])


def _following(slope: Array, q: Array) -> Array:
    """Directions (n - 1, d) in which the prediction of each row but the last went next."""
    motion = np.einsum("ndj,nj->nd", slope, np.diff(q, axis=0))
    length = np.linalg.norm(motion, axis=1, keepdims=True)
    return np.asarray(motion / np.where(length > 0, length, 1.0))


def _late_share(z: Array) -> Array:
    """Probability of each row to be late, (n,)."""
    share, shift = 0.2, 2.0
    for _ in range(200):
        # Logarithms of both densities, times sqrt(2 pi): far below zero either underflows.
        honest = -0.5 * z**2
        late = 0.5 / shift**2 - z / shift + log_ndtr(z - 1 / shift) + np.log(SQRT_2PI / shift)
        posterior = expit(late - honest + np.log(share / (1 - share)))
        share = float(np.clip(posterior.mean(), 1e-3, 0.9))
        shift = float(max(np.sum(posterior * np.maximum(z, 0)) / posterior.sum(), 0.5))
    return np.asarray(posterior)
