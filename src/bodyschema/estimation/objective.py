"""Objective: the robust posterior of a body, its slope and its curvature at one place.

    q_ic = |r_ic|^2 / s_c^2     r whitened by the shape of the believed noise, s_c = exp theta_c
    C    = sum_i u_i c(Q_i) + 1/2 x^T P x          Q_i = sum_c q_ic, c and w as in `loss`
    g    = sum_i w_i J_i^T r_i / s^2 + P x         w_i = u_i w(Q_i)
    H    = sum_c H_c + P                           H_c = sum_i w_i J_ic^T J_ic / s_c^2

u_i is what a sample is worth beside others of its moment and posture (`repeats`), 0 for one that
the gate has taken out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation import loss
from bodyschema.estimation.noise import Noise
from bodyschema.estimation.normal_equations import (
    Whitened,
    pulled,
    scatter,
    whiten,
    whitened_residual,
)
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]

MOST_BENT = 0.95
"""Share of a sample's curvature that its robust loss may take away: an outlier must not make the
curvature of the whole negative."""


@dataclass(frozen=True)
class Place:
    """All senses linearised at one x."""

    x: Array
    parts: tuple[Whitened, ...]
    squares: tuple[Array, ...]
    """(n, components) |r_ic|^2 for each sense, before levels."""


@dataclass(frozen=True)
class Objective:
    """What is to be minimised, for fixed worth of the samples and fixed nu."""

    reference: Body
    variables: Variables
    senses: tuple[Sense, ...]
    worth: tuple[Array, ...]
    """(n,) u for each sense."""
    freedom: tuple[float, ...]
    """nu of each sense."""

    @cached_property
    def noise(self) -> Noise:
        """What theta means."""
        return Noise(self.senses)

    @cached_property
    def counts(self) -> Array:
        """(K,) n_c = sum u_i d_c: the numbers of each component."""
        return np.array([
            u.sum() * (part.stop - part.start)
            for sense, u in zip(self.senses, self.worth, strict=True)
            for _, _, part in sense.components
        ])  # fmt: skip

    @cached_property
    def precision(self) -> Array:
        """(N,) diagonal of P."""
        return np.asarray(self.variables.prior_std**-2.0)

    def place(self, x: Array) -> Place:
        """Linearise: once for an accepted step."""
        parts = tuple(whiten(s, self.reference, self.variables, x) for s in self.senses)
        return Place(x, parts, self.squares([part.residual for part in parts]))

    def residuals(self, x: Array) -> list[Array]:
        """Whitened residuals, (n, dimension) for each sense."""
        body = self.reference.with_variables(self.variables, x)
        return [whitened_residual(sense, body) for sense in self.senses]

    def squares(self, residuals: Sequence[Array]) -> tuple[Array, ...]:
        """|r_ic|^2, (n, components) for each sense."""
        return tuple(
            np.stack([np.sum(r[:, part] ** 2, axis=1) for _, _, part in sense.components], axis=1)
            for sense, r in zip(self.senses, residuals, strict=True)
        )

    def lengths(self, squares: Sequence[Array], theta: Array) -> list[Array]:
        """Q, (n,) for each sense."""
        scale = np.exp(-2 * theta)
        return [q @ scale[span] for q, span in zip(squares, self.noise.spans, strict=True)]

    def cost(self, x: Array, squares: Sequence[Array], theta: Array) -> float:
        """C, but for what the levels add."""
        total = 0.5 * float(x @ (self.precision * x))
        threes = zip(self.lengths(squares, theta), self.worth, self._kinds, strict=True)
        return total + sum(float(u @ loss.cost(Q, d, nu)) for Q, u, (d, nu) in threes)

    def weights(self, squares: Sequence[Array], theta: Array) -> tuple[Array, ...]:
        """w, (n,) for each sense."""
        threes = zip(self.lengths(squares, theta), self.worth, self._kinds, strict=True)
        return tuple(u * loss.weight(Q, d, nu) for Q, u, (d, nu) in threes)

    def pull(
        self, place: Place, residuals: Sequence[Array], weights: Sequence[Array], theta: Array
    ) -> Array:
        """sum w J^T r / s^2 for any residuals, (N,); for the place's own the data's part of g."""
        scales = self.noise.rows(np.exp(-2 * theta))
        total = np.zeros(len(self.variables))
        for part, r, w, scale in zip(place.parts, residuals, weights, scales, strict=True):
            total += pulled(part.jacobian, r * w[:, None] * scale)
        return total

    def shares(self, place: Place, weights: Sequence[Array]) -> Array:
        """(K, N, N) s_c^2 H_c."""
        found = [
            scatter(part.jacobian[:, rows], np.sqrt(w))
            for part, w in zip(place.parts, weights, strict=True)
            for _, _, rows in part.sense.components
        ]
        return np.array(found)

    def bend(self, place: Place, weights: Sequence[Array], theta: Array) -> Array:
        """(N, N) what the robust loss takes from H: sum 2 w/(nu + Q) v v^T, v = J_i^T r_i / s^2."""
        total = np.zeros((len(self.variables), len(self.variables)))
        scales, lengths = self.noise.rows(np.exp(-2 * theta)), self.lengths(place.squares, theta)
        for part, w, scale, Q, (_, nu) in zip(
            place.parts, weights, scales, lengths, self._kinds, strict=True
        ):
            if np.isfinite(nu):
                v = (part.residual * scale)[:, None, :] @ part.jacobian
                c = w * np.minimum(2 / (nu + Q), MOST_BENT / np.maximum(Q, 1e-300))
                total += scatter(v, np.sqrt(c))
        return total

    def coupled(self, squares: Sequence[Array], weights: Sequence[Array], theta: Array) -> Array:
        """(K, K) sum w q q^T / (nu + Q), see `noise`."""
        found = np.zeros((len(theta), len(theta)))
        scale, lengths = np.exp(-2 * theta), self.lengths(squares, theta)
        for squared, w, span, Q, (_, nu) in zip(
            squares, weights, self.noise.spans, lengths, self._kinds, strict=True
        ):
            q = squared * scale[span]
            found[span, span] = (q * (w / (nu + Q))[:, None]).T @ q
        return found

    @property
    def _kinds(self) -> list[tuple[int, float]]:
        """Dimension and nu of each sense."""
        pairs = zip(self.senses, self.freedom, strict=True)
        return [(len(sense.covariance), nu) for sense, nu in pairs]
