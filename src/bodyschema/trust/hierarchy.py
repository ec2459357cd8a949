"""Hierarchy: how wrong the numbers of this robot are, group by group, as its own rows tell.

A prior says how wrong robots are, generously. The numbers of one group (zeros, axes, links) are
wrong by about as much as one another, and some are seen so well that they tell of the others: with
y what the rows say of the variables x, in units of the prior, and of the sizes gamma of something
that is not in the model (`explanations`),

    y = A x + Z gamma + e,   e ~ N(0, s^2),  x_g ~ N(0, s^2 rho_g^2),  gamma ~ N(0, s^2 tau^2)

    p(y | rho, tau) ~ |M|^-1/2 (y^T y - |M^-1/2 D b|^2)^-n/2,
    M = 1 + D S D,  S = [A Z]^T [A Z],  b = [A Z]^T y,  D = diag(rho, tau)

with s unknown (prior 1 / s) and about 1: rows are whitened. The sizes rho and tau are tried on a
grid, all alike likely beforehand; what the rows do not tell of them stays open, and is open in the
error that is stated. Frames and parts keep their priors. See Gelman and Hill 2007, "Data analysis
using regression and multilevel/hierarchical models", and MacKay 1992, "Bayesian interpolation".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Self

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.pulls import pulls
from bodyschema.trust.scores import Scores

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

GROUPS = ("offsets", "axes", "links")
"""Whose size is learnt: many numbers each, and alike."""

SIZES = np.array([0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0])
"""rho, in units of the prior: 0.1 to 10 mm of links, 0.06 to 6 degrees of zeros."""

SHARES = np.array([0.1, 0.5, 2.0, 8.0, 32.0])
"""tau: root mean square of a row of Z gamma, in units of the noise."""

EVERY = 2
"""Sizes from one to the next that are tried beside an explanation."""

UNTOLD = 1e3
"""rho of a variable without a prior, m or rad."""

AT_ONCE = 2_000_000
"""Numbers of the matrices M that are held at once."""


@dataclass(frozen=True)
class Sizes:
    """Sizes that were tried."""

    D: Array
    """(K, p) rho of each variable, then tau."""
    log_weight: Array
    """(K,) log likelihood, with the chance that each had beforehand."""


@dataclass(frozen=True)
class Hierarchy:
    """The rows of a fit, as they speak of its variables and of a further Z."""

    rows: Array
    """(N, p) A, then Z."""
    y: Array
    """(N,)."""
    n: float
    """Numbers seen, each by its weight."""
    base: Array
    """(P,) rho as the priors have it."""
    groups: tuple[Ints, ...]
    """Columns of each group whose size is learnt."""

    @classmethod
    def of(cls, scores: Scores) -> Self:
        """What the rows of a fit say of its variables."""
        variables = scores.estimate.variables
        base = np.where(scores.precision > 0, 1.0, UNTOLD)
        columns = [np.flatnonzero([g == name for g in variables.groups]) for name in GROUPS]
        told = scores.A @ (scores.estimate.x / variables.scale) - scores.seen
        alike, n = alikeness(scores), independent(scores)
        root = np.sqrt(alike)
        groups = tuple(c for c in columns if len(c))
        return cls(scores.A / root, told / root, n / alike, base, groups)

    def beside(self, Z: Array) -> Hierarchy:
        """The same with something that is not in the model, (N, k)."""
        rows = np.concatenate([self.rows[:, : len(self.base)], Z], axis=1)
        return Hierarchy(rows, self.y, self.n, self.base, self.groups)

    @cached_property
    def squares(self) -> tuple[Array, Array, float]:
        """S (p, p), b (p,) and y^T y."""
        return self.rows.T @ self.rows, self.rows.T @ self.y, float(self.y @ self.y)

    def alone(self) -> Sizes:
        """All sizes of the groups, without anything else."""
        return self._tried([SIZES] * len(self.groups), None)

    def smaller(self, most: Array) -> Sizes:
        """Sizes of Z, beside groups that are no larger than they would be alone.

        Args:
            most: (P,) rho of each variable without it.
        """
        steps = [SIZES[: _place(most[c], self.base[c]) + 1][::-EVERY] for c in self.groups]
        return self._tried(steps, SHARES)

    def _tried(self, steps: Sequence[Array], shares: Array | None) -> Sizes:
        extra = self.rows.shape[1] - len(self.base)
        tried = list(product(*steps, (0.0,) if shares is None else shares))
        D = np.tile(np.concatenate([self.base, np.zeros(extra)]), (len(tried), 1))
        values = np.array(tried)
        for i, columns in enumerate(self.groups):
            D[:, columns] *= values[:, i, None]
        D[:, len(self.base) :] = values[:, -1:]
        # As many alike as there are in all: a coarser grid stands for more of them each.
        stands_for = 1 if shares is None else EVERY ** len(self.groups) / len(shares)
        beforehand = np.log(stands_for / len(SIZES) ** len(self.groups))
        return Sizes(D, self._log_likelihood(D) + beforehand)

    def _log_likelihood(self, D: Array) -> Array:
        S, b, yy = self.squares
        found, some = np.empty(len(D)), max(1, AT_ONCE // max(S.size, 1))
        for i in range(0, len(D), some):
            d = D[i : i + some]
            L = np.linalg.cholesky(np.eye(len(S)) + d[:, :, None] * S * d[:, None, :])
            w = np.linalg.solve(L, (d * b)[:, :, None])[:, :, 0]
            left = np.maximum(yy - np.sum(w**2, axis=1), 1e-12 * max(yy, 1e-300))
            half_log = np.sum(np.log(np.diagonal(L, axis1=1, axis2=2)), axis=1)
            found[i : i + some] = -0.5 * self.n * np.log(left) - half_log
        return found

    def draws(self, D: Array, count: int, rng: np.random.Generator, spread: float = 1.0) -> Array:
        """(count, p) variables and gamma as they may be.

        Args:
            D: (p,) one choice of sizes.
            count: of the draws.
            rng: of the draws.
            spread: by how much they lie further from their mean than independent rows would say.
        """
        S, b, yy = self.squares
        L = np.linalg.cholesky(np.eye(len(S)) + D[:, None] * S * D)
        w = np.linalg.solve(L, D * b)
        left = max(yy - float(w @ w), 1e-12 * max(yy, 1e-300))
        s = spread * np.sqrt(left / rng.chisquare(self.n, size=(count, 1)))
        return np.asarray(np.linalg.solve(L.T, (w + s * rng.normal(size=(count, len(w)))).T).T * D)


def independent(scores: Scores) -> float:
    """Numbers seen that are worth one each: sum w, or (sum w)^2 / sum w^2 if that is less.

    Frames of one posture weigh less than one; the good of a recording with outliers more.
    """
    found = 0.0
    for root, sense in zip(scores.roots, scores.senses, strict=True):
        w = root**2
        total = float(np.sum(w))
        found += len(sense.covariance) * min(total, total**2 / max(float(np.sum(w**2)), 1e-300))
    return max(found, 1.0)


def alikeness(scores: Scores) -> float:
    """How many numbers of one moment are worth one, as far as the variables feel it; 1 or more.

    phi = sum |L^T g_c|^2 / (s^2 |A L|^2) of the moments' pulls g_c (`estimation.pulls`): markers on
    one hand share the error of its joints.
    """
    several = scores.n_moments < len(scores.moment)
    if not several or not scores.A.shape[1]:
        return 1.0
    B = scores.A @ scores.root
    pulled = pulls(B, scores.z, scores.moment[scores.sample], np.eye(B.shape[1]), 0.5)
    s2 = scores.squared / scores.freedom
    return max(1.0, float(np.sum(pulled**2) / max(s2 * np.sum(B**2), 1e-300)))


def _place(most: Array, base: Array) -> int:
    """Which of SIZES a group has."""
    return int(np.argmin(np.abs(np.log(SIZES) - np.log(most[0] / base[0]))))
