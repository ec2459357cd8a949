"""Huber weights: how much a sample counts, given its residual whitened by the believed noise.

    w(r) = min(1, k / |r|)

k is the 95 % quantile of |r| for normal noise of that dimension; the weighted J^T J is then the
information of the estimate to within half a percent (Huber 1964: E[w r . r]^2 / E[w^2 r . r]
against E[w] d, for d = 3 and 6).
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

Array = NDArray[np.float64]

CLIPPED, GROSS = 0.05, 1e-3
"""Shares of normal samples that lie beyond k, and beyond what counts as a gross outlier."""


def huber_weights(residual: Array) -> Array:
    """Weight of each sample from its whitened residual, (n, dimension) -> (n,)."""
    k2 = _beyond(CLIPPED, residual.shape[1])
    return np.asarray(np.sqrt(k2 / np.maximum(np.sum(residual**2, axis=1), k2)))


def gross(dimension: int) -> float:
    """Squared whitened residual beyond which a sample counts as a gross outlier."""
    return _beyond(GROSS, dimension)


@lru_cache
def _beyond(share: float, dimension: int) -> float:
    """Squared length that a share of standard normal vectors exceeds."""
    return float(chdtri(dimension, share))
