"""Gauss-Newton on what was accumulated: no sample is needed again.

The unknowns of a linear relation often lie on a curved surface x(theta): a rotation is nine numbers
with three degrees of freedom. On the accumulated matrix C = sum A^T A the cost

    F(theta) = x^T (C - N) x,   J = dx/dtheta,   H = J^T C J,   g = J^T (C - N) x

is exact, whatever the number of samples behind it. N is what measurement noise adds to C on average
(it enters the columns of A), so that C - N has no bias. Steps are -(H + mu diag H)^-1 g; they are
taken when F falls, else mu grows (Levenberg 1944, Marquardt 1963).
"""

from __future__ import annotations

from typing import NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

Array = NDArray[np.float64]
Theta = TypeVar("Theta")


class Normal(NamedTuple):
    """A cost with its normal equations at one place."""

    cost: float
    gradient: Array
    """(k,) half the slope of the cost."""
    H: Array
    """(k, k)."""


class Problem(Protocol[Theta]):
    """A sum of squares over a surface."""

    def normal(self, theta: Theta) -> Normal:
        """Cost, gradient and H at theta."""
        ...

    def move(self, theta: Theta, delta: Array) -> Theta:
        """theta after a step (k,), kept to a length that the surface's chart allows."""
        ...


def descend(
    problem: Problem[Theta], theta: Theta, rounds: int = 30, tolerance: float = 1e-7
) -> tuple[Theta, Normal, bool]:
    """Minimise a problem from theta.

    Args:
        problem: the cost.
        theta: where to start.
        rounds: most evaluations.
        tolerance: smallest gain that is worth a step, in the unit of the cost.

    Returns:
        the place, the normal equations there, and whether the descent came to rest.
    """
    here, mu = problem.normal(theta), 1e-6
    for _ in range(rounds):
        damped = here.H + np.diag(mu * np.diag(here.H) + 1e-12)
        _, delta, trouble = lapack.dposv(damped, -here.gradient)
        if trouble:
            mu = max(10 * mu, 1e-3)
            continue
        expected = -float(here.gradient @ delta)
        if expected < tolerance:
            return theta, here, True
        there = problem.move(theta, delta)
        reached = problem.normal(there)
        if reached.cost < here.cost:
            theta, here, mu = there, reached, mu / 10
        elif mu > 1e8:
            return theta, here, expected < 1e-3
        else:
            mu = max(10 * mu, 1e-4)
    return theta, here, False
