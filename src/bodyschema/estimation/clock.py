"""Was the body seen at the moment when its joints were read? A test for late rows.

If row i was seen after the robot had begun to move on, its residual points along the motion that
followed, m_i = J(q_i) (q_(i+1) - q_i). The projection z_i = m_i . r_i / |m_i|, in units of its own
spread, is about standard normal for honest rows and positive for late ones. The statistic
sum max(z, 0)^2 is compared with its values when every row is given the posture that followed some
other row: that keeps the sizes of residuals and motions and breaks only the link between them.

Which rows are late is told by a mixture, fitted by expectation-maximisation: honest rows are
z ~ N(0, 1), late ones z ~ N(0, 1) plus an exponential shift.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import exponnorm, norm

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.normal_equations import level_rows
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SHUFFLES = 2000
FALSE_ALARM = 0.01
"""Chance of calling a fault where there is none."""

FEWEST_ROWS = 10

LARGEST = 4.0
"""Standard deviations at which the mixture clips z: one very late row must not set the scale."""


@dataclass(frozen=True)
class ClockCheck:
    """Verdict on the clocks of one recording."""

    p_value: float
    """Chance of so much agreement between residuals and following motions without a fault."""
    late_rows: tuple[int, ...]
    """Rows more likely late than not; empty when there is no fault."""

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
    rng = np.random.default_rng(seed)
    steps = np.array([rng.permutation(n) for _ in range(SHUFFLES)]) + 1
    null = np.array([_projections(residual, slope, q, following) for following in steps])
    # The median of |z| for a standard normal z is 0.6745.
    spread = max(float(np.median(np.abs(null))) / 0.6745, 1e-300)
    z = _projections(residual, slope, q, np.arange(1, n + 1)) / spread
    reached = np.sum(_agreement(null / spread) >= _agreement(z))
    p_value = float((reached + 1) / (SHUFFLES + 1))
    late = (
        rows[:n][_late_share(np.minimum(z, LARGEST)) > 0.5] if p_value < FALSE_ALARM else rows[:0]
    )
    return ClockCheck(p_value, tuple(int(row) for row in late))


def _agreement(z: Array) -> Array:
    return np.asarray(np.sum(np.maximum(z, 0) ** 2, axis=-1))


def _common_rows(fit: Estimate, senses: Sequence[Sense]) -> tuple[Ints, Array, Array, Array]:
    """Rows that every sense has; residuals (n, d) in noise units, slopes (n, d, n_joints), q."""
    rows = senses[0].rows
    for sense in senses[1:]:
        rows = np.intersect1d(rows, sense.rows)
    residuals, slopes = [], []
    for sense, levels in zip(senses, fit.levels, strict=True):
        kept = sense.take(np.flatnonzero(np.isin(sense.rows, rows)))
        scale = np.sqrt(np.diag(sense.covariance)) * level_rows(sense, levels)
        linear = kept.linearize(fit.reference, fit.variables, fit.x)
        residuals.append(linear.residual / scale)
        slopes.append(-linear.by_joint / scale[:, None])
    return rows, np.concatenate(residuals, axis=1), np.concatenate(slopes, axis=1), kept.q


def _projections(residual: Array, slope: Array, q: Array, following: Ints) -> Array:
    """z of all rows but the last, if row i was followed by the posture of row `following[i]`."""
    step = q[following] - q[: len(following)]
    motion = (slope[: len(following)] @ step[..., None])[..., 0]
    length = np.linalg.norm(motion, axis=1)
    along = np.sum(motion * residual[: len(following)], axis=1)
    return np.asarray(along / np.where(length > 0, length, 1.0))


def _late_share(z: Array) -> Array:
    """Probability of each row to be late, (n,)."""
    share, shift = 0.2, 2.0
    for _ in range(200):
        honest = (1 - share) * norm.pdf(z)
        late = share * exponnorm.pdf(z, shift)
        posterior = late / (honest + late)
        share = float(np.clip(posterior.mean(), 1e-3, 0.9))
        shift = float(max(np.sum(posterior * np.maximum(z, 0)) / posterior.sum(), 0.5))
    return np.asarray(posterior)
