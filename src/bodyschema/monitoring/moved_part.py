"""One part against new samples: how far it would have moved, and what that explains.

Objective, symbols and sources are those of `change`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.special import fdtrc

from bodyschema.estimation.discrepancy import Field, matern
from bodyschema.estimation.estimate import Estimate
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]

FREEDOM = 4.0
"""nu of the Student-t noise, as in `estimation.solver`."""

ROUNDS = 5

LEAST = 0.1
"""Of the noise level: how much of it must be noise beside a residual field."""


@dataclass(frozen=True)
class Suspect:
    """One part that may have changed."""

    part: str
    """Name of a joint or of a frame."""
    p_value: float
    """Chance of so much evidence without a change of this part; not corrected for many parts."""
    evidence: float
    """T_B less what its number of parameters would gain by chance."""
    change: Array
    """(k,) estimated change, rad and m."""
    names: tuple[str, ...]
    """(k,) of the parameters that changed."""
    effect: float = float("nan")
    """m: 95 % of how far the change moves what was seen, in the postures of the new samples."""
    share: float = float("nan")
    """T_B over that of all parts together."""


@dataclass(frozen=True)
class Block:
    """One component of one sense: rows of every sample, with its noise and residual field."""

    residual: Array
    """(n, axes)."""
    jacobian: Array
    """(n, axes, n_parameters)."""
    correlation: Array
    """(n, n) of the field; zero without one."""
    amplitude: float
    noise: float
    first: int
    """Number of the block's first sample among all samples."""

    @property
    def samples(self) -> slice:
        """Its samples among all."""
        return slice(self.first, self.first + len(self.residual))


@dataclass(frozen=True)
class Fitted:
    """The change of one part that explains the new samples best at given weights."""

    change: Array
    """(k,)."""
    moved: Array
    """(n_parameters,) that and e."""
    squared: float
    """u^T S^-1 u."""
    degrees: int
    """rank(S)."""


@dataclass(frozen=True)
class Tested:
    """One part, tested with weights and a spread of its own."""

    suspect: Suspect
    fitted: Fitted
    spread: float
    rest: float
    """Degrees of freedom behind the spread."""


def blocks_of(
    estimate: Estimate,
    variables: Variables,
    senses: Sequence[Sense],
    fields: Mapping[str, Field],
) -> list[Block]:
    x = np.concatenate([estimate.x, np.zeros(len(variables) - len(estimate.x))])
    blocks, first = [], 0
    for sense in senses:
        linear = sense.linearize(estimate.reference, variables, x)
        field = fields.get(sense.label)
        for i, (name, unit, part) in enumerate(sense.components):
            noise = (estimate.noise or {})[f"{sense.label}: {name} ({unit})"]
            amplitude, correlation = 0.0, np.zeros((len(sense), len(sense)))
            if field is not None:
                amplitude, noise = field.amplitude[i], max(field.noise[i], LEAST * noise)
                correlation = matern(sense.q, sense.q, field.length)
            residual, J = linear.residual[:, part], linear.by_parameter[:, part]
            blocks.append(Block(residual, J, correlation, amplitude, noise, first))
        first += len(sense)
    return blocks


def tested(
    part: str,
    rows: Sequence[int],
    estimate: Estimate,
    variables: Variables,
    blocks: Sequence[Block],
) -> Tested:
    """Fit the change of one part, with weights of its own, and test it against none."""
    moved = np.zeros(len(variables))
    for _ in range(ROUNDS):
        H, g = normal_equations(blocks, weights_at(blocks, moved))
        fitted = fitted_part(rows, H, g, estimate.information)
        moved = fitted.moved
    spread, rest = _spread(blocks, moved, fitted.degrees)
    T = fitted.squared / spread
    p_value = float(fdtrc(fitted.degrees, rest, T / fitted.degrees))
    names = tuple(variables.names[i] for i in rows)
    evidence = T - cost_of(fitted.degrees, rest)
    suspect = Suspect(part, p_value, evidence, fitted.change, names)
    return Tested(suspect, fitted, spread, rest)


def fitted_part(rows: Sequence[int], H: Array, g: Array, information: Array) -> Fitted:
    """The change of the parameters in `rows`, e eliminated."""
    known, B = len(information), list(rows)
    prior = H[:known, :known] + information
    M = np.linalg.solve(prior, np.column_stack([H[:known][:, B], g[:known]]))
    S = H[np.ix_(B, B)] - H[B][:, :known] @ M[:, :-1]
    u = g[B] - H[B][:, :known] @ M[:, -1]
    values, vectors = np.linalg.eigh((S + S.T) / 2)
    seen = values > 1e-9 * max(values[-1], 1e-300)
    along = vectors[:, seen].T @ u
    change = vectors[:, seen] @ (along / values[seen])
    moved = np.zeros(len(g))
    moved[:known] = M[:, -1] - M[:, :-1] @ change
    moved[B] += change
    return Fitted(change, moved, float(np.sum(along**2 / values[seen])), int(np.sum(seen)))


def cost_of(degrees: int, rest: float) -> float:
    """What so many parameters gain by chance (Schwarz 1978)."""
    return float(degrees * np.log(max(rest, 2.0)))


def normal_equations(blocks: Sequence[Block], weights: Array) -> tuple[Array, Array]:
    """H and g of the module's text."""
    n = blocks[0].jacobian.shape[2]
    H, g = np.zeros((n, n)), np.zeros(n)
    for block in blocks:
        w = weights[block.samples]
        K = block.amplitude**2 * block.correlation + np.diag(block.noise**2 / w)
        factor = cho_factor(K)
        for axis in range(block.residual.shape[1]):
            J = block.jacobian[:, axis]
            KJ = cho_solve(factor, J)
            H += J.T @ KJ
            g -= KJ.T @ block.residual[:, axis]
    return H, g


def _squared(blocks: Sequence[Block], x: Array) -> tuple[Array, Array]:
    """Squared residual of each sample in units of field and noise, and its number of rows."""
    n = max(block.samples.stop for block in blocks)
    squared, d = np.zeros(n), np.zeros(n)
    for block in blocks:
        left = block.residual + block.jacobian @ x
        size = block.amplitude**2 + block.noise**2
        squared[block.samples] += np.sum(left**2, axis=1) / size
        d[block.samples] += left.shape[1]
    return squared, d


def weights_at(blocks: Sequence[Block], x: Array) -> Array:
    """Student-t weight of each sample when the parameters have moved by x."""
    squared, d = _squared(blocks, x)
    return np.asarray((FREEDOM + d) / (FREEDOM + squared))


def _spread(blocks: Sequence[Block], x: Array, degrees: int) -> tuple[float, float]:
    """Variance of the estimated change over S^-1, and the degrees of freedom behind it.

    The sandwich of an M-estimate (Huber 1967): with psi = w r it is
    mean(psi^2) mean(w) / mean(psi')^2, where psi' averaged over directions is
    w (1 - 2 |r|^2 / (d (nu + |r|^2))).
    """
    squared, d = _squared(blocks, x)
    w = (FREEDOM + d) / (FREEDOM + squared)
    slope = w * (1 - 2 * squared / (d * (FREEDOM + squared)))
    rest = max(float(np.sum(d)) - degrees, 1.0)
    variance = np.sum(w**2 * squared) * np.sum(d) / rest
    return float(variance * np.sum(w * d) / np.sum(slope * d) ** 2), rest
