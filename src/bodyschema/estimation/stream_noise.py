"""What the residuals of a stream look like: how large, how long remembered, how often outliers.

White residuals e (in units of the believed noise) of d rows, samples of one sense in a row, give

    level        a = mean e^2
    correlation  r = mean e_t e_t-1 / mean e^2

as running means over at most `LONGEST` samples. In the long run such noise weighs as much as white
noise whose variance is tau = (1 + r) / (1 - r) times as large. Residuals beyond the 1.5e-5 point of
chi-square are counted as outliers and left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

Array = NDArray[np.float64]

LONGEST = 1000.0
"""Samples that a running mean remembers."""

RARE = 1.5e-5
"""Chance of a good sample to be taken for an outlier."""

FEW = 20.0
"""Samples that the first guess counts for."""

LARGEST = 0.99
"""Correlation that is believed at most."""

MEDIAN = 0.4549
"""Of chi-square with one degree of freedom."""

PIECE = 150
"""Samples of one piece of a recording, in `measured`."""


@lru_cache(maxsize=64)
def outlier_limit(rows: int) -> float:
    """Squared white residual of so many rows beyond which a sample is an outlier."""
    return float(chdtri(rows, RARE))


@dataclass(frozen=True)
class StreamNoise:
    """Running size and memory of white residuals."""

    level: float = 1.0
    product: float = 0.0
    """Mean of e_t e_t-1 over level."""
    samples: float = FEW
    outliers: float = 2.0
    """Their number; the first two are a prior."""
    recent: float = 0.0
    """Share of outliers among the last thirty or so."""

    @property
    def correlation(self) -> float:
        """r, never below zero."""
        return float(np.clip(self.product, 0.0, LARGEST))

    @property
    def long_run(self) -> float:
        """tau."""
        return (1 + self.correlation) / (1 - self.correlation)

    @property
    def outlier_share(self) -> float:
        """Upper estimate of the share of outliers."""
        return max(self.outliers / (self.samples + 100), 1e-3)

    def learn(self, e: Array, before: Array | None, squared: float) -> StreamNoise:
        """One sample more.

        Args:
            e: (d,) its white residual.
            before: (d,) that of the sample before, if that was good.
            squared: its squared innovation, the belief's own error taken into account.
        """
        d = len(e)
        outlier = squared > outlier_limit(d) * self.level
        recent = self.recent + (float(outlier) - self.recent) / 30
        if outlier:
            return StreamNoise(self.level, self.product, self.samples, self.outliers + 1, recent)
        n = min(self.samples + 1, LONGEST)
        level = self.level + (squared / d - self.level) / n
        product = self.product
        if before is not None:
            product += (float(e @ before) / (d * level) - product) / n
        return StreamNoise(level, product, self.samples + 1, self.outliers, recent)


def measured(e: Sequence[Array], J: Sequence[Array]) -> StreamNoise:
    """Noise of a recording, whatever changed in it: residuals that no parameter explains.

    The recording is cut into short pieces; in each, what any step of the parameters would explain
    is taken out by least squares. A change inside a piece spoils that piece alone: the median over
    pieces is taken.

    Args:
        e: (n_s, d_s) white residuals of each sense, in order of time.
        J: (n_s, d_s, k) their slopes.
    """
    level, product, count = [], [], 0
    for residual, slope in zip(e, J, strict=True):
        count += len(residual)
        pieces = max(1, len(residual) // PIECE)
        for rows in np.array_split(np.arange(len(residual)), pieces):
            left, freedom = _left_over(residual[rows], slope[rows])
            variance = float(np.median(left**2)) / MEDIAN
            good = np.sum(left**2, axis=1) <= outlier_limit(left.shape[1]) * variance
            both = good[1:] & good[:-1]
            shared = np.sum(left[1:] * left[:-1], axis=1)[both]
            level.append(float(np.mean(left[good] ** 2)) / freedom)
            # An exact recording has neither size nor memory.
            size = max(float(np.sum(left[1:][both] ** 2)), 1e-300)
            product.append(float(np.sum(shared)) / size)
    return StreamNoise(float(np.median(level)), float(np.median(product)), float(count))


def _left_over(e: Array, J: Array) -> tuple[Array, float]:
    """Residuals that the slopes do not explain, (n, d), and the share of freedom that remains."""
    wide, y = J.reshape(-1, J.shape[2]), e.reshape(-1)
    basis, sizes, _ = np.linalg.svd(wide, full_matrices=False)
    basis = basis[:, sizes > 1e-6 * sizes[0]]
    left = (y - basis @ (basis.T @ y)).reshape(e.shape)
    return left, max(1 - basis.shape[1] / y.size, 0.1)
