"""When an estimate may be called known: bounds, fit, no rival, nothing open.

A part's bound is 3.37 times its largest standard deviation in any direction (3.37^2 is the 99 %
point of chi-square with three degrees of freedom), with a declared budget for what the fit cannot
see (errors of kinematics and intrinsics bend the answer and leave the residuals small) in
quadrature.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

REACH = 3.37
"""Standard deviations to the 99 % bound of a vector of three. Not 95 %: of a hundred robots that
believe that they know themselves, at most one may be wrong."""


@dataclass(frozen=True)
class Demand:
    """How well each part must be known, in rad or m, and what is not worth a doubt."""

    bounds: Mapping[str, float]
    """Part -> largest allowed bound."""
    budget: Mapping[str, float] = field(default_factory=dict)
    """Part -> error that model and intrinsics may cause, which no residual shows."""
    misfit: float = 0.1
    """By how much mean squared residuals may differ from what the noise explains: nobody knows
    the noise of a sensor exactly."""
    gap: float = 30.0
    """By how much the next best answer must fit worse, in units of chi-square."""


@dataclass(frozen=True)
class Certificate:
    """Whether the demand is met, and what is missing if not."""

    holds: bool
    bounds: Mapping[str, float]
    """Part -> 99 % bound, rad or m."""
    fit: float
    """Mean squared residual over what the noise explains; about 1."""
    missing: tuple[str, ...]
    """One sentence for each thing that is missing; empty when it holds."""


def bound(covariance: Array, budget: float) -> float:
    """The 99 % bound of a part with covariance (3, 3) and the declared budget."""
    return float(np.hypot(REACH * np.sqrt(max(np.linalg.eigvalsh(covariance)[-1], 0.0)), budget))


def certify(
    demand: Demand,
    covariances: Mapping[str, Array],
    fit: float,
    freedom: float,
    gap: float,
    units: Mapping[str, tuple[float, str]],
) -> Certificate:
    """Compare an estimate with a demand.

    Args:
        demand: what is asked for.
        covariances: part -> (3, 3).
        fit: mean squared residual over what the noise explains.
        freedom: independent residuals behind `fit`.
        gap: to the next best answer.
        units: part -> factor and unit for sentences.
    """
    bounds = {p: bound(c, demand.budget.get(p, 0.0)) for p, c in covariances.items()}
    missing = []
    for part, most in demand.bounds.items():
        factor, unit = units[part]
        if not bounds[part] <= most:
            missing.append(
                f"{part} is known to {factor * bounds[part]:.2g} {unit}, "
                f"wanted {factor * most:.2g} {unit}."
            )
    allowed = demand.misfit + 5 * np.sqrt(2 / max(freedom, 1.0))
    if not abs(fit - 1) < allowed:
        missing.append(f"residuals are {fit:.2f} times what the noise explains.")
    if not gap > demand.gap:
        missing.append("another, far answer fits nearly as well.")
    return Certificate(not missing, bounds, fit, tuple(missing))
