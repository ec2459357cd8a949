"""Scores: what every number that was seen still says, once a fit is made.

    z = sqrt(w) r / s          residuals in units of their noise, w the robust weight
    A = sqrt(w) J / s          their slopes, the variables in units of their prior
    C = (A^T A + P)^-1         posterior covariance in these units, P = 1 (0 without a prior)

At the end of a fit A^T z + P x = 0: the samples hold each other in balance. All tests of this room
ask who pulls where. What a learner has not yet taken of its samples, the step -C (A^T z + P x), is
taken here (z with it) and remembered.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.moments import SAME_POSTURE, moments_of
from bodyschema.estimation.normal_equations import level_rows, solve_rows, whiten
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Scores:
    """The whitened rows of a fit, all senses one below the other."""

    estimate: Estimate
    senses: tuple[Sense, ...]
    roots: tuple[Array, ...]
    """(n,) sqrt(w) for each sense."""
    seen: Array
    """(N,) z where the learner stands."""
    A: Array
    """(N, P)."""
    sample: Ints
    """(N,) which sample a number belongs to, counted through all senses."""
    moment: Ints
    """(n_samples,) number of the moment of each sample, in the order of recording."""

    @classmethod
    def of(cls, estimate: Estimate, senses: Sequence[Sense]) -> Scores:
        """Linearise once more where the fit has come to rest.

        Args:
            estimate: of a body to these samples.
            senses: what was seen.
        """
        weights = estimate.weights or tuple(np.ones(len(sense)) for sense in senses)
        roots = tuple(np.sqrt(np.maximum(w, 0.0)) for w in weights)
        z, A = [], []
        for sense, root, levels in zip(senses, roots, estimate.levels, strict=True):
            part = whiten(sense, estimate.reference, estimate.variables, estimate.x)
            scale = root[:, None] / level_rows(sense, levels)
            z.append((part.residual * scale).ravel())
            rows = part.jacobian * (scale[..., None] * estimate.variables.scale)
            A.append(rows.reshape(part.residual.size, len(estimate.variables)))
        counts = np.concatenate([np.full(len(s), len(s.covariance)) for s in senses])
        return cls(
            estimate,
            tuple(senses),
            roots,
            np.concatenate(z),
            np.concatenate(A),
            np.repeat(np.arange(len(counts)), counts),
            _in_order(senses, estimate),
        )

    def under(self, prior_std: Array) -> Scores:
        """The same rows, the variables under another prior, (P,)."""
        variables = self.estimate.variables
        other = variables.with_prior(prior_std)
        estimate = replace(self.estimate, variables=other)
        return replace(self, estimate=estimate, A=self.A * (other.scale / variables.scale))

    @cached_property
    def precision(self) -> Array:
        """(P,) diagonal of P."""
        variables = self.estimate.variables
        return np.asarray((variables.scale / variables.prior_std) ** 2)

    @cached_property
    def step(self) -> Array:
        """(P,) what the learner has not yet taken, in units of the prior."""
        x = self.estimate.x / self.estimate.variables.scale
        return np.asarray(-self.C @ (self.A.T @ self.seen + self.precision * x))

    @cached_property
    def z(self) -> Array:
        """(N,) at rest."""
        return np.asarray(self.seen + self.A @ self.step)

    @cached_property
    def root(self) -> Array:
        """(P, P) L with C = L L^T."""
        values, vectors = np.linalg.eigh(self.A.T @ self.A + np.diag(self.precision))
        # Rounding must not make more of a direction than the prior knows.
        least = min(self.precision.min(initial=1.0), 1.0)
        return np.asarray(vectors / np.sqrt(np.maximum(values, max(least, 1e-12))))

    @cached_property
    def C(self) -> Array:
        """(P, P)."""
        return np.asarray(self.root @ self.root.T)

    @cached_property
    def squared(self) -> float:
        """|z|^2."""
        return float(self.z @ self.z)

    @cached_property
    def numbers(self) -> float:
        """Numbers seen, each by its weight."""
        return sum(
            float(np.sum(root**2)) * len(sense.covariance)
            for root, sense in zip(self.roots, self.senses, strict=True)
        )

    @cached_property
    def freedom(self) -> float:
        """Numbers seen, less those that the variables have absorbed."""
        absorbed = float(np.sum((self.A @ self.root) ** 2))
        return max(self.numbers - absorbed, 1.0)

    @cached_property
    def n_moments(self) -> int:
        """How many moments there are."""
        return int(self.moment.max(initial=-1)) + 1

    @cached_property
    def time(self) -> Array:
        """(n_samples,) s."""
        return np.concatenate([sense.time for sense in self.senses])

    @cached_property
    def q(self) -> Array:
        """(n_samples, n_joints)."""
        return np.concatenate([sense.q for sense in self.senses])

    def whitened(self, effects: Sequence[Array]) -> Array:
        """Effects on the residuals, (n, d, k) a sense, as the rows of A are: (N, k)."""
        found = []
        pairs = zip(self.senses, self.roots, self.estimate.levels, effects, strict=True)
        for sense, root, levels, effect in pairs:
            L = np.asarray(np.linalg.cholesky(sense.covariance), dtype=np.float64)
            scale = root[:, None] / level_rows(sense, levels)
            rows = solve_rows(L, effect) * scale[..., None]
            found.append(rows.reshape(root.size * len(sense.covariance), effect.shape[2]))
        return np.concatenate(found)


def _in_order(senses: Sequence[Sense], estimate: Estimate) -> Ints:
    """Moment of each sample, numbered by its first row."""
    rows, moment = moments_of(senses, SAME_POSTURE, estimate.reference)
    first = np.full(moment.max() + 1, np.iinfo(np.int64).max)
    np.minimum.at(first, moment, np.arange(len(rows)))
    place = np.empty(len(first), dtype=np.int64)
    place[np.argsort(first)] = np.arange(len(first))
    seen = np.concatenate([sense.rows for sense in senses])
    return np.asarray(place[moment[np.searchsorted(rows, seen)]])
