"""When an estimate may be called known: bounds, fit, no rival, nothing open.

The bound of a thing with d components is sqrt(chi2_d(99 %)) times its largest standard deviation in
any direction (3.37 times for a place, 2.58 for a number), with a declared budget for what the fit
cannot see (errors of kinematics and intrinsics bend the answer and leave the residuals small) in
quadrature.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

Array = NDArray[np.float64]

RISK = 0.01
"""Chance of an error beyond the bound. Not 5 %: of a hundred robots that believe that they know
themselves, at most one may be wrong."""

SHOWN = {"m": (1e3, "mm"), "rad": (180 / np.pi, "deg"), "kg": (1e3, "g")}
"""SI unit -> factor and unit of sentences."""


@dataclass(frozen=True)
class Tolerance:
    """How well each thing must be known, in SI units, and what is not worth a doubt."""

    bounds: Mapping[str, float]
    """Thing -> largest allowed bound."""
    budget: Mapping[str, float] = field(default_factory=dict)
    """Thing -> error that model and intrinsics may cause, which no residual shows."""
    misfit: float = 0.1
    """By how much mean squared residuals may differ from what the noise explains: nobody knows
    the noise of a sensor exactly."""
    gap: float = 30.0
    """By how much the next best answer must fit worse, in units of chi-square."""


@dataclass(frozen=True)
class Certificate:
    """Whether a tolerance is met, and what is missing if not."""

    holds: bool
    bounds: Mapping[str, float]
    """Thing -> 99 % bound, SI units."""
    fit: float
    """Mean squared residual over what the noise explains; about 1."""
    missing: tuple[str, ...]
    """One sentence for each thing that is missing; empty when it holds."""


def reach(dimension: int) -> float:
    """Standard deviations from the mean to the bound, for so many components."""
    return float(np.sqrt(chdtri(dimension, RISK)))


def bound(covariance: Array, budget: float = 0.0) -> float:
    """The 99 % bound of a thing with covariance (d, d) and a declared budget."""
    widest = max(float(np.linalg.eigvalsh(covariance)[-1]), 0.0)
    return float(np.hypot(reach(len(covariance)) * np.sqrt(widest), budget))


def certify(
    tolerance: Tolerance,
    covariances: Mapping[str, Array],
    fit: float,
    freedom: float,
    gap: float,
    units: Mapping[str, str],
) -> Certificate:
    """Compare an estimate with a tolerance.

    Args:
        tolerance: what is asked for.
        covariances: thing -> (d, d).
        fit: mean squared residual over what the noise explains.
        freedom: independent residuals behind `fit`.
        gap: to the next best answer.
        units: thing -> SI unit.
    """
    bounds = {name: bound(C, tolerance.budget.get(name, 0.0)) for name, C in covariances.items()}
    missing = []
    for name, most in tolerance.bounds.items():
        factor, unit = SHOWN[units[name]]
        if not bounds[name] <= most:
            missing.append(
                f"{name} is known to {factor * bounds[name]:.2g} {unit}, "
                f"wanted {factor * most:.2g} {unit}."
            )
    allowed = tolerance.misfit + 5 * np.sqrt(2 / max(freedom, 1.0))
    if not abs(fit - 1) < allowed:
        missing.append(f"residuals are {fit:.2f} times what the noise explains.")
    if not gap > tolerance.gap:
        missing.append("another, far answer fits nearly as well.")
    return Certificate(not missing, bounds, fit, tuple(missing))
