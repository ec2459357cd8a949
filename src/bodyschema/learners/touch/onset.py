"""Whether anything touches: the smoothed wrench against what noise and the load's errors make.

    x_t = x_t-1 + c_t (w_t - x_t-1),   c_t = max(1 / age, `SHARE`),   L smoothed in the same way
    cov(x_t) = v_t N + L L^T,          v_t = (1 - c_t)^2 v_t-1 + c_t^2,     z = x^T cov(x)^-1 x

without a touch z is chi-square with six degrees of freedom, or where N was measured on m samples
Hotelling's: 6 (m - 1) / (m - 6) times an F of 6 and m - 6. With a false touches an hour to be borne
at R samples a second, the limit is its 1 - a / (3600 R) quantile: neighbours are alike, so the true
rate is lower. Two samples above it in a row begin a touch. A sample that is `JUMP` standard
deviations away begins a new average, so that a hard touch and its end are not smeared. A touch is
over when z is back below its 99.9 % quantile for some samples in a row.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri, fdtri

from bodyschema.model.kernels import kernel

Array = NDArray[np.float64]

SHARE = 0.2
"""Least weight of the latest sample."""

JUMP = 6.0
"""Standard deviations of one of the six readings."""

CALM = 1e-3
"""Share of samples without a touch that are above the lower limit."""


@dataclass(frozen=True)
class Smoothed:
    """The latest wrench, without most of its noise."""

    wrench: Array
    """(6,) x: N, Nm."""
    factor: Array
    """(6, k) L."""
    variance: float = 0.0
    """v: what is left of a sample's noise."""
    age: int = 0
    """Samples since the average began."""
    surprise: float = 0.0
    """z."""

    def follow(self, wrench: Array, factor: Array, noise: Array) -> Smoothed:
        """After one more sample, (6,), (6, k) and the noise (6, 6) of a sample."""
        steps = (wrench - self.wrench) ** 2 > JUMP**2 * (1 + self.variance) * noise.diagonal()
        age = 1 if steps.any() else self.age + 1
        share = max(1 / age, SHARE)
        variance = (1 - share) ** 2 * self.variance + share**2
        x, L, z = followed(self.wrench, self.factor, wrench, factor, noise, share, variance)
        return Smoothed(x, L, variance, age, z)


@lru_cache(maxsize=16)
def limits(false_per_hour: float, rate: float, samples: float) -> tuple[float, float]:
    """z above which a touch begins, and below which it ends.

    Args:
        false_per_hour: a.
        rate: R.
        samples: m; inf if the noise is known.
    """
    chances = np.array([false_per_hour / (3600 * rate), CALM])
    if samples == np.inf:
        upper, lower = chdtri(6, chances)
    else:
        upper, lower = 6 * (samples - 1) / (samples - 6) / fdtri(samples - 6, 6, chances)
    return float(upper), float(lower)


@kernel
def followed(
    wrench: Array,
    factor: Array,
    now: Array,
    factor_now: Array,
    noise: Array,
    share: float,
    variance: float,
) -> tuple[Array, Array, float]:
    """x, L and z after one more sample."""
    x, L = wrench + share * (now - wrench), factor + share * (factor_now - factor)
    C = np.empty((6, 6))
    white = np.empty(6)
    z = 0.0
    # Cholesky's root of cov(x) and the solution of C white = x, row by row.
    for i in range(6):
        for j in range(i + 1):
            entry = variance * noise[i, j]
            for k in range(L.shape[1]):
                entry += L[i, k] * L[j, k]
            for k in range(j):
                entry -= C[i, k] * C[j, k]
            C[i, j] = entry / C[j, j] if j < i else np.sqrt(entry)
        rest = x[i]
        for k in range(i):
            rest -= C[i, k] * white[k]
        white[i] = rest / C[i, i]
        z += white[i] * white[i]
    return x, L, z
