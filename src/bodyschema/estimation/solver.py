"""Batch calibration: the parameters that explain all samples at once, robustly, with noise levels.

Samples are Student-t distributed round the prediction, one scale for each component of a sense
(positions and rotations of a pose share the sample's weight). Expectation-maximisation (Lange,
Little, Taylor 1989) alternates

    weights   w_i = (nu + d) / (nu + |r_i / s|^2)            d rows a sample
    levels    s^2 = sum_i w_i (|r_i|^2 + tr J_i C J_i^T) / (n d)       C posterior covariance
    step      one Levenberg-Marquardt step on the weighted normal equations

until nothing moves. The trace accounts for what the parameters have absorbed, so the levels stay
right with few samples. A few gross outliers cost nothing but their own rows; no threshold is set by
hand. The covariance that is reported uses the Fisher information of the Student-t distribution,
(nu + d) / (nu + d + 2) of J_i^T J_i w_i / s^2.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.estimation.estimate import Estimate, Levels
from bodyschema.estimation.normal_equations import (
    Whitened,
    fisher_share,
    information,
    level_rows,
    positive_factor,
    solve_factored,
    whiten,
    whitened_residual,
)
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]

SETTLED = 1e-3
"""Largest last step, in posterior standard deviations, of a fit that counts as converged."""

SMALLEST_LEVEL = 1e-3
"""Of the believed noise: exact (simulated) data must not divide by zero."""


@dataclass(frozen=True)
class Solver:
    """Robust maximum a posteriori by Levenberg-Marquardt inside expectation-maximisation."""

    freedom: float = 4.0
    """nu of the Student-t distribution; inf for Gaussian noise."""
    max_iterations: int = 100
    tolerance: float = 1e-7
    """Stop when no parameter moves by more than this share of its posterior std."""
    learn_levels: bool = True
    """Estimate noise levels; otherwise the senses' own covariances are taken as they are."""

    def fit(self, reference: Body, variables: Variables, senses: Sequence[Sense]) -> Estimate:
        """Fit the parameters to the samples.

        Args:
            reference: body at x = 0, with every frame of the senses attached and started.
            variables: what may be wrong, with priors.
            senses: what was seen.

        Raises:
            InputError: no samples at all.
        """
        if not sum(len(sense) for sense in senses):
            raise InputError("there is not a single sample to learn from.")
        x = np.zeros(len(variables))
        levels = tuple(first_levels(sense, reference, self.learn_levels) for sense in senses)
        damping, moved, iterations = 1e-6, np.inf, 0
        parts = [whiten(sense, reference, variables, x) for sense in senses]
        while iterations < self.max_iterations:
            iterations += 1
            weights = tuple(
                self.weights(part.residual, part.sense, level)
                for part, level in zip(parts, levels, strict=True)
            )
            H, g = information(parts, levels, weights)
            old = x
            x, damping, C = _descend(
                reference, variables, senses, levels, weights, H, g, x, damping
            )
            parts = [whiten(sense, reference, variables, x) for sense in senses]
            before = levels
            if self.learn_levels:
                levels = tuple(
                    _level(part, weight, C) for part, weight in zip(parts, weights, strict=True)
                )
            moved = float(np.max(np.abs(x - old) / np.sqrt(np.diag(C)), initial=0.0))
            if moved < self.tolerance and _change(levels, before) < self.tolerance:
                break
        weights = tuple(
            self.weights(part.residual, part.sense, level)
            for part, level in zip(parts, levels, strict=True)
        )
        told = [
            fisher_share(self.freedom, part.residual.shape[1]) * weight
            for part, weight in zip(parts, weights, strict=True)
        ]
        H, _ = information(parts, levels, told)
        noise = named_levels(senses, levels)
        settled = moved < SETTLED
        return Estimate(reference, variables, x, H, noise, levels, weights, iterations, settled)

    def weights(self, residual: Array, sense: Sense, levels: Sequence[float]) -> Array:
        """Student-t weight of each sample from its whitened residual, (n,)."""
        if np.isinf(self.freedom):
            return np.ones(len(residual))
        squared = np.sum((residual / level_rows(sense, levels)) ** 2, axis=1)
        return np.asarray((self.freedom + residual.shape[1]) / (self.freedom + squared))


def first_levels(sense: Sense, body: Body, learn: bool) -> tuple[float, ...]:
    """Levels before the first step: the median length of the residual, in believed noise."""
    if not learn or not len(sense):
        return tuple(1.0 for _ in sense.components)
    residual = whitened_residual(sense, body)
    # The median length of a standard normal 3-vector is 1.538.
    lengths = [np.linalg.norm(residual[:, part], axis=1) / 1.538 for _, _, part in sense.components]
    return tuple(max(float(np.median(length)), SMALLEST_LEVEL) for length in lengths)


def _descend(
    reference: Body,
    variables: Variables,
    senses: Sequence[Sense],
    levels: Levels,
    weights: Sequence[Array],
    H: Array,
    g: Array,
    x: Array,
    damping: float,
) -> tuple[Array, float, Array]:
    """One accepted Levenberg-Marquardt step: new x, new damping, posterior covariance at the old x.

    All is scaled by the prior, so that the damping means the same for radians and metres.
    """
    D = variables.scale
    precision = variables.prior_std**-2.0
    H = (H + np.diag(precision)) * np.outer(D, D)
    g = (g + precision * x) * D
    start = _cost(reference, variables, senses, levels, weights, x)
    covariance = solve_factored(positive_factor(H), np.eye(len(x))) * np.outer(D, D)
    while damping < 1e12:
        step = -D * solve_factored(positive_factor(H + damping * np.diag(np.diag(H))), g)
        there = np.clip(x + step, -variables.bound, variables.bound)
        cost = _cost(reference, variables, senses, levels, weights, there)
        if cost <= start * (1 + 1e-12):
            return there, max(damping / 10, 1e-12), covariance
        damping *= 10
    return x, 1e-6, covariance


def _cost(
    reference: Body,
    variables: Variables,
    senses: Sequence[Sense],
    levels: Levels,
    weights: Sequence[Array],
    x: Array,
) -> float:
    body = reference.with_variables(variables, x)
    cost = float(np.sum((x / variables.prior_std) ** 2))
    for sense, level, weight in zip(senses, levels, weights, strict=True):
        scaled = whitened_residual(sense, body) / level_rows(sense, level)
        cost += float(weight @ np.sum(scaled**2, axis=1))
    return cost / 2


def _level(part: Whitened, weight: Array, C: Array) -> tuple[float, ...]:
    """The EM update of the noise levels of one sense."""
    found = []
    for _, _, rows in part.sense.components:
        r, J = part.residual[:, rows], part.jacobian[:, rows]
        absorbed = np.sum((J @ C) * J, axis=2)
        total = float(weight @ np.sum(r**2 + absorbed, axis=1))
        found.append(max(np.sqrt(total / r.size), SMALLEST_LEVEL) if r.size else 1.0)
    return tuple(found)


def _change(now: Levels, before: Levels) -> float:
    """Largest relative change of any level."""
    pairs = [(a, b) for x, y in zip(now, before, strict=True) for a, b in zip(x, y, strict=True)]
    return max((abs(a - b) / b for a, b in pairs), default=0.0)


def named_levels(senses: Sequence[Sense], levels: Levels) -> dict[str, float]:
    """Noise level of each component in its unit, by name."""
    named = {}
    for sense, level in zip(senses, levels, strict=True):
        believed = np.sqrt(np.diag(sense.covariance))
        for (name, unit, rows), value in zip(sense.components, level, strict=True):
            named[f"{sense.label}: {name} ({unit})"] = float(value * np.mean(believed[rows]))
    return named
