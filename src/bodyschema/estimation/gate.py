"""The gate: which samples are outliers, and what noise the others have; nothing is moved for it.

1. Samples beyond the gate of `loss` are taken out, the levels are found anew without them, and so
   on until no more go: many outliers make the level so high that they hide one another.
2. Of the samples that are left, each sense gets the nu under which its residuals are likeliest,
   levels adjusted, on a grid from 1 to 1000.

Both at the x of a finished fit, where the residuals of good samples are as good as final. Samples
that were taken out are outliers for good: under the nu of 2 a heavy-tailed sense would forgive
most of them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.descent import State, absorbed
from bodyschema.estimation.loss import Loss, Mask, cost, normaliser, weight
from bodyschema.estimation.noise import GROWS, KAPPA, SHRINKS
from bodyschema.estimation.objective import Objective

Array = NDArray[np.float64]

GRID = tuple(float(nu) for nu in np.geomspace(1.0, 1000.0, 31))
"""Values of nu to choose from, ten a decade; at 1000 the noise is normal for all that matters."""

ROUNDS = 20
"""Most times that the gate looks again."""

FEWEST = 10.0
"""Numbers that a fit must leave of a sense before anything is said of its tails."""

REFINEMENTS = 3
"""Newton steps on the levels of one sense, from those of a neighbouring nu."""


@dataclass(frozen=True)
class Judgement:
    """What the gate says of a finished fit."""

    good: tuple[Mask, ...]
    """(n,) for each sense: which samples are no outliers."""
    freedom: tuple[float, ...]
    """nu that the residuals of the good samples ask for, by sense."""
    theta: Array
    """(K,) log levels that go with it."""


@dataclass(frozen=True)
class Residuals:
    """What a fit has left of one sense's samples."""

    squared: Array
    """(n, components) |r_ic|^2, before levels."""
    d: int
    """Numbers of a sample."""
    worth: Array
    """(n,) u of each sample; 0 for one that was taken out."""
    numbers: Array
    """(components,) numbers of each component that the fit has left: n_c - gamma_c of `noise`."""
    lowest: Array
    """(components,) smallest log levels."""

    def lengths(self, theta: Array) -> Array:
        """Q, (n,)."""
        return np.asarray(self.squared @ np.exp(-2 * theta))

    def levels(self, theta: Array, nu: float) -> Array:
        """Likeliest log levels, (components,), by Newton steps from theta."""
        for _ in range(REFINEMENTS):
            q = self.squared * np.exp(-2 * theta)
            Q = q.sum(axis=1)
            wq = q * (self.worth * weight(Q, self.d, nu))[:, None]
            A = 2 * (np.diag(wq.sum(axis=0)) - (wq / (nu + Q)[:, None]).T @ q)
            rise = wq.sum(axis=0) - self.numbers - KAPPA * theta
            step = np.linalg.solve(A + KAPPA * np.eye(len(A)), rise)
            theta = np.maximum(theta + np.clip(step, SHRINKS, GROWS), self.lowest)
        return theta

    def unlikeliness(self, theta: Array, nu: float) -> float:
        """Negative log likelihood under levels and nu, up to a constant."""
        costs = cost(self.lengths(theta), self.d, nu) - normaliser(self.d, nu)
        return float(self.worth @ costs + self.numbers @ theta)

    def asked(self, theta: Array) -> tuple[float, Array]:
        """nu under which the samples are likeliest, and its log levels (components,)."""
        tried = []
        for nu in GRID:
            theta = self.levels(theta, nu)
            tried.append((self.unlikeliness(theta, nu), nu, theta))
        _, nu, best = min(tried, key=lambda entry: entry[0])
        return nu, best


def judge(objective: Objective, state: State, loss: Loss, learn_levels: bool) -> Judgement:
    """What the gate says of a finished fit.

    Args:
        objective: with nu of the gate.
        state: where its descent came to rest.
        loss: the gate.
        learn_levels: otherwise levels and nu stay as they are.
    """
    noise, theta = objective.noise, state.theta.copy()
    gamma = absorbed(objective, state)
    good = tuple(np.ones(len(sense), dtype=bool) for sense in objective.senses)
    left = _left(objective, state, good, gamma)
    for _ in range(ROUNDS):
        lengths = [r.lengths(theta[span]) for r, span in zip(left, noise.spans, strict=True)]
        passed = loss.good(lengths, [r.d for r in left])
        fewer = tuple(a & b for a, b in zip(good, passed, strict=True))
        if all((a == b).all() for a, b in zip(good, fewer, strict=True)):
            break
        good, left = fewer, _left(objective, state, fewer, gamma)
        if learn_levels:
            for residuals, span in zip(left, noise.spans, strict=True):
                theta[span] = residuals.levels(theta[span], loss.freedom)
    freedom = list(objective.freedom)
    if learn_levels and np.isfinite(loss.freedom):
        for i, (residuals, span) in enumerate(zip(left, noise.spans, strict=True)):
            if residuals.numbers.sum() > FEWEST:
                freedom[i], theta[span] = residuals.asked(theta[span])
    return Judgement(good, tuple(freedom), theta)


def _left(
    objective: Objective, state: State, good: tuple[Mask, ...], gamma: Array
) -> list[Residuals]:
    """What the fit has left of each sense's good samples."""
    kept = replace(objective, worth=masked(objective.worth, good))
    numbers = np.maximum(kept.counts - gamma, 0.0)
    return [
        Residuals(squared, len(sense.covariance), u, numbers[span], kept.noise.lowest[span])
        for squared, sense, u, span in zip(
            state.place.squares, kept.senses, kept.worth, kept.noise.spans, strict=True
        )
    ]


def masked(worth: tuple[Array, ...], good: tuple[Mask, ...]) -> tuple[Array, ...]:
    """The worth of samples, none of those that are not good."""
    return tuple(u * mask for u, mask in zip(worth, good, strict=True))
