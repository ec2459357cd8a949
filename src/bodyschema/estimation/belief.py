"""What a learner believes, in one form: forget a part, doubt it, certify it, ask if it diverged.

A belief is a mean with covariance P over variables that fall into blocks, the noise that it met
(`stream_noise`: level a, long-run variance tau), and what its samples cost it. Filters, sums over a
memory and outlines come by these each in its way; what follows from them stands here, once:

    forget    block t is eliminated (Schur) and gets its prior,
              Lambda_kk <- Lambda_kk - Lambda_kt Lambda_tt^-1 Lambda_tk,  Lambda_kt <- 0
    doubt     noise that remembers, or is larger than P was made for, widens P: P max(tau a / t, 1),
              t the variance by which it counted already
    explain   the cost c of n independent residuals is credible, c <= n + 6 sqrt(2 n)
    certify   P in the directions that matter, residuals and rivals are within a `Tolerance`
    diverge   most of the last samples are outliers, or residuals are far larger than the noise
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.certificate import Certificate, Tolerance, certify
from bodyschema.estimation.stream_noise import StreamNoise

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

FOREIGN, LOST = 0.3, 0.5
"""Share of outliers among the last thirty samples or so from which nothing is certified, and from
which a belief has diverged."""

SURE = 6.0
"""Standard deviations by which a cost may be too large."""

FAR = 8.0
"""Standard deviations of excess that no noise makes."""


UNKNOWN = 1e6
"""rad, m: standard deviation that stands for knowing nothing, where the information is singular."""


@dataclass(frozen=True)
class WhiteInnovation:
    """A moment against what a belief predicts, in units of the sensor's noise."""

    e: Array
    """(m,) seen less predicted: unit variance when the belief is exact."""
    J: Array
    """(m, k) slope: variables that differ by d from the belief add J d to e."""
    source: Ints
    """(m,) which measurement a row belongs to: rows of one source are outliers together."""


class Slopes(NamedTuple):
    """How a thing that must be known moves with the variables."""

    J: Array
    """(n, d, k) in as many postures as matter."""
    unit: str
    """Of the thing, SI."""


@dataclass(frozen=True)
class GaussianBelief:
    """A belief and how it has fared."""

    covariance: Array
    """(k, k) P, with noise as it counted when the belief was made."""
    tolerance: Tolerance = field(default_factory=lambda: Tolerance({}))
    """What must be known, and how well."""
    noise: StreamNoise = StreamNoise()  # noqa: RUF009  (frozen)
    """Of the residuals, in units of the declared noise."""
    tempered: float = 1.0
    """t: variance, over the declared one, by which noise counts in P."""
    cost: float = 0.0
    """c: residuals and the pull against the prior, over the noise."""
    rows: float = 0.0
    """n: independent residuals behind it; about equal when all is well."""
    fit: float = 1.0
    """Mean squared residual over what the noise explains; 1 where the noise was found from it."""
    freedom: float = np.inf
    """Independent residuals behind the fit."""
    gap: float = np.inf
    """By how much the next best answer far away fits worse, in units of chi-square."""
    begun: bool = True
    """Whether there are enough samples to speak of."""

    @cached_property
    def doubt(self) -> Array:
        """(k, k) how far the belief may be off."""
        grown = max(self.noise.long_run * self.level / self.tempered, 1.0)
        # A covariance of a singular information is no number, or none that can be worked with.
        if not np.abs(self.covariance).max() * grown < UNKNOWN**2:
            return UNKNOWN**2 * np.eye(len(self.covariance))
        P = self.covariance * grown
        return np.asarray((P + P.T) / 2)

    @property
    def level(self) -> float:
        """a, 1 or more: what the declared noise does not explain is noise too."""
        return max(self.noise.level, 1.0)

    @property
    def explains(self) -> bool:
        """Whether it explains the samples that it learned from."""
        return bool(self.cost <= self.rows + SURE * np.sqrt(2 * self.rows))

    @property
    def diverged(self) -> bool:
        """Whether a belief that is still being learned contradicts its own samples."""
        excess = self.fit - 1 - self.tolerance.misfit
        far = bool(excess > FAR * np.sqrt(2 / max(self.freedom, 1.0)))
        return self.begun and (self.noise.recent > LOST or far)

    def certificate(self, known: Mapping[str, Slopes]) -> Certificate:
        """Whether every thing is known well enough, in its worst posture."""
        if not self.begun:
            return Certificate(False, {}, np.inf, ("too few samples for a first fit.",))
        spread = {name: widest(self.doubt, slopes.J) for name, slopes in known.items()}
        units = {name: slopes.unit for name, slopes in known.items()}
        found = certify(self.tolerance, spread, self.fit, self.freedom, self.gap, units)
        if self.noise.recent < FOREIGN:
            return found
        foreign = "most of the last samples do not fit."
        return replace(found, holds=False, missing=(*found.missing, foreign))


def inverse(C: Array) -> Array:
    """Covariance from information or back, balanced: variables differ by many powers of ten."""
    scale = 1 / np.sqrt(np.diag(C))
    balanced = np.linalg.inv(C * np.outer(scale, scale)) * np.outer(scale, scale)
    return np.asarray((balanced + balanced.T) / 2)


def widest(P: Array, J: Array) -> Array:
    """(d, d) covariance of a thing with slopes (n, d, k), where its widest direction is widest."""
    spread = J @ P @ np.swapaxes(J, 1, 2)
    return np.asarray(spread[np.argmax(np.linalg.eigvalsh(spread)[:, -1])])


def forget(information: Array, block: Ints, prior: Array | float = 0.0) -> Array:
    """Information (k, k) after a block is forgotten; what was known of the rest stays known.

    Args:
        information: Lambda.
        block: (b,) places of its variables.
        prior: information that the block starts from, (b, b) or (b,) of each variable.
    """
    across = information[:, block]
    told = across @ np.linalg.solve(information[np.ix_(block, block)], across.T)
    left = information - told
    left[block], left[:, block] = 0.0, 0.0
    fresh = np.broadcast_to(prior, (len(block),)) if np.ndim(prior) < 2 else prior
    left[np.ix_(block, block)] = np.diag(fresh) if np.ndim(fresh) < 2 else fresh
    return np.asarray((left + left.T) / 2)
