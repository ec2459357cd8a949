"""Noise: the level of each component of each sense, in units of the noise that was believed.

theta_c = log s_c is found where the marginal likelihood is stationary. With the squared lengths
q_ic = |r_ic|^2 / s_c^2, the robust weights w_i, the worth u_i of a sample, n_c = sum u_i d_c the
numbers of a component, H_c the information that it brings (sum H_c + P = C^-1) and
gamma_c = tr C H_c what the variables have absorbed of it,

    g_c   = n_c - sum w q_c - gamma_c + kappa theta_c
    A     = 2 diag(sum w q_c) - 2 sum w q q^T / (nu + Q) + 2 (diag gamma - T) + kappa 1
    T_cb  = tr C H_c C H_b

and one Newton step is -A^-1 g; A is positive, being diagonally dominant. The gamma give back what
the fit has absorbed, so that levels stay right with few samples. C must be that of the place where
the residuals were taken, or flat directions leak into the level.

A sense may state its noise. Its level then never falls below what was stated, and what exceeds it
is error of the model, not noise.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.special import gammaincinv

from bodyschema.estimation.normal_equations import level_rows, whitened_residual
from bodyschema.model.tree import Body
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Levels = tuple[tuple[float, ...], ...]
"""A level of each component of each sense, in believed noise."""

SMALLEST_LEVEL = 1e-3
"""Of the believed noise: exact (simulated) data must not divide by zero."""

KAPPA = float(np.log(10.0) ** -2)
"""Belief in the believed noise: to a decade. It keeps the level of a sense with one row in place;
two numbers of data outweigh it."""

SHRINKS, GROWS = -0.5, 1.0
"""Longest steps of log s; the information changes with its square."""

SURE = 3.0
"""Standard errors of a level by which it must exceed stated noise to be called model error."""


@dataclass(frozen=True)
class Noise:
    """The components of all senses, one after the other: what a vector theta (K,) means."""

    senses: tuple[Sense, ...]

    @cached_property
    def spans(self) -> tuple[slice, ...]:
        """Where the components of each sense stand in theta."""
        ends = np.cumsum([0, *(len(sense.components) for sense in self.senses)])
        return tuple(slice(int(a), int(b)) for a, b in pairwise(ends))

    @cached_property
    def lowest(self) -> Array:
        """(K,) smallest log level: for stated noise that which was stated."""
        floors = [
            0.0 if sense.stated else np.log(SMALLEST_LEVEL)
            for sense in self.senses
            for _ in sense.components
        ]
        return np.array(floors)

    def first(self, body: Body) -> Array:
        """Log levels before the first step: the median length of each residual, (K,)."""
        return self.theta([first_levels(sense, body) for sense in self.senses])

    def theta(self, levels: Sequence[Sequence[float]]) -> Array:
        """Log levels in one row, (K,)."""
        flat = [s for sense in levels for s in sense]
        return np.maximum(np.log(np.maximum(flat, SMALLEST_LEVEL)), self.lowest)

    def levels(self, theta: Array) -> Levels:
        """Levels by sense and component."""
        return tuple(tuple(float(s) for s in np.exp(theta[span])) for span in self.spans)

    def rows(self, values: Array) -> tuple[Array, ...]:
        """A value of each component (K,) at each number of a residual, (dimension,) a sense."""
        pairs = zip(self.senses, self.spans, strict=True)
        return tuple(level_rows(sense, values[span]) for sense, span in pairs)


def first_levels(sense: Sense, body: Body) -> tuple[float, ...]:
    """Median length of the residual of each component, in that of the believed noise."""
    if not len(sense):
        return tuple(1.0 for _ in sense.components)
    residual, found = whitened_residual(sense, body), []
    for _, _, part in sense.components:
        typical = np.sqrt(2 * gammaincinv((part.stop - part.start) / 2, 0.5))
        length = float(np.median(np.linalg.norm(residual[:, part], axis=1)))
        found.append(max(length / typical, SMALLEST_LEVEL))
    return tuple(found)


def newton_step(
    theta: Array, counts: Array, squares: Array, coupled: Array, shares: Array, C: Array
) -> Array:
    """One Newton step of the marginal likelihood on the log levels, (K,).

    Args:
        theta: (K,) log levels.
        counts: (K,) n_c.
        squares: (K,) sum w q_c.
        coupled: (K, K) sum w q q^T / (nu + Q).
        shares: (K, N, N) H_c.
        C: (N, N) posterior covariance.
    """
    told = C @ shares
    gamma = np.trace(told, axis1=1, axis2=2)
    T = np.einsum("cij,bji->cb", told, told, optimize=True)
    g = counts - squares - gamma + KAPPA * theta
    A = 2 * (np.diag(squares + gamma) - coupled - T) + KAPPA * np.eye(len(theta))
    return np.asarray(np.clip(-np.linalg.solve(A, g), SHRINKS, GROWS))


def named_levels(senses: Sequence[Sense], levels: Sequence[Sequence[float]]) -> dict[str, float]:
    """Noise level of each component in its unit, by name; of a stated one what was stated."""
    named = {}
    for sense, level in zip(senses, levels, strict=True):
        for name, believed, s in _entries(sense, level):
            named[name] = believed * (1.0 if sense.stated else s)
    return named


def model_error(senses: Sequence[Sense], levels: Sequence[Sequence[float]]) -> Mapping[str, float]:
    """What exceeds the stated noise, by component, in its unit: sqrt(s^2 - 1) of it, or 0.

    A level known from m numbers has a standard error of 1 / sqrt(2 m).
    """
    found = {}
    for sense, level in zip(senses, levels, strict=True):
        if not sense.stated:
            continue
        for (name, believed, s), (_, _, part) in zip(
            _entries(sense, level), sense.components, strict=True
        ):
            numbers = max(len(sense) * (part.stop - part.start), 1)
            excess = s > 1 + SURE / np.sqrt(2 * numbers)
            found[name] = believed * float(np.sqrt(s**2 - 1)) if excess else 0.0
    return found


def _entries(sense: Sense, level: Sequence[float]) -> list[tuple[str, float, float]]:
    """Name with unit, believed noise and level of each component."""
    believed = np.sqrt(np.diag(sense.covariance))
    return [
        (f"{sense.label}: {name} ({unit})", float(np.mean(believed[part])), float(s))
        for (name, unit, part), s in zip(sense.components, level, strict=True)
    ]
