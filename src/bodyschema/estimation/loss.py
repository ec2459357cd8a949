"""Loss: how much a residual costs. One robust family, chosen once.

A sample of d numbers has the squared length Q, each number in units of its noise. It is Student-t
distributed (Lange, Little and Taylor 1989), which costs

    c(Q) = (nu + d)/2 log(1 + Q/nu),      weight w = 2 dc/dQ = (nu + d) / (nu + Q)

so that a few gross outliers cost nothing but their own rows; nu = inf is normal noise, c = Q/2.

Under that noise Q/d is F-distributed with (d, nu) degrees of freedom. A sample is an outlier where
so large a Q has less than the chance `false_alarm` among all samples of a recording (Bonferroni).

One nu does not suit all. At 4 a fifth of bad samples is borne, but normal noise costs 6 % of
accuracy and gets levels 10 % too low, and outliers make levels 20 to 90 % too high. So the first
fit and the gate have nu = `freedom`; what passes the gate is fitted again with the nu that its
residuals ask for, see `gate`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, fdtrc, gammaln

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Loss:
    """The robust family and its gate."""

    freedom: float = 4.0
    """nu of the first fit and of the gate; inf for normal noise without outliers."""
    false_alarm: float = 0.05
    """Chance that a whole recording without outliers has one sample called an outlier."""
    adapt: bool = True
    """Fit what passes the gate again, with a nu of its own; otherwise nothing is taken out, and
    nu stays."""

    def good(self, lengths: Sequence[Array], dimensions: Sequence[int]) -> tuple[Mask, ...]:
        """Which samples are no outliers, (n,) for each sense.

        Args:
            lengths: (n,) Q of each sense.
            dimensions: d of each sense.
        """
        total = sum(len(Q) for Q in lengths)
        pairs = zip(lengths, dimensions, strict=True)
        return tuple(beyond(Q, d, self.freedom) * total >= self.false_alarm for Q, d in pairs)


def beyond(Q: Array, d: int, nu: float) -> Array:
    """Chance of a sample at least as far out as Q, (n,)."""
    return np.asarray(chdtrc(d, Q) if np.isinf(nu) else fdtrc(d, nu, Q / d))


def cost(Q: Array, d: int, nu: float) -> Array:
    """c(Q), (n,)."""
    return Q / 2 if np.isinf(nu) else (nu + d) / 2 * np.log1p(Q / nu)


def weight(Q: Array, d: int, nu: float) -> Array:
    """Robust weight w, (n,): near 1 and above for good samples, near 0 for outliers."""
    return np.ones(len(Q)) if np.isinf(nu) else (nu + d) / (nu + Q)


def fisher_share(nu: float, d: int) -> float:
    """Fisher information of a Student-t sample, over that of its weighted square J^T J w / s^2.

    (nu + d) / (nu + d + 2), Lange, Little and Taylor 1989: part of the weight is spent on finding
    out how much the sample can be trusted. 1 for normal noise.
    """
    return 1.0 if np.isinf(nu) else (nu + d) / (nu + d + 2)


def normaliser(d: int, nu: float) -> float:
    """Log of what makes exp(-c) a density of d numbers of unit scale."""
    if np.isinf(nu):
        return -d / 2 * float(np.log(2 * np.pi))
    return float(gammaln((nu + d) / 2) - gammaln(nu / 2) - d / 2 * np.log(np.pi * nu))
