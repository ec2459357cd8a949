"""Where to begin: a linear solution, at a rotation that is believed or the best of all.

Everything but the rotation is linear in the sums (`problem`). If nobody knows how the sensor sits
on its mount, the rest is eliminated: with r the nine entries of R and l the rest of x,

    Q = C_rr - C_rl (C_ll + prior)^-1 C_lr,   F(R) = r^T Q r,

a quadratic over SO(3), descended from 48 rotations that cover it. Gravity turning in the hand is
what tells them apart.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.relation_fit import descend
from bodyschema.learners.hand_eye.rotation_search import covering_rotations, descend_all
from bodyschema.learners.payload.chart import SHARED, Guess, Prior
from bodyschema.learners.payload.noise_levels import Levels, Segment
from bodyschema.learners.payload.problem import PayloadProblem, weighted
from bodyschema.model.inertia import log_cholesky, nearest_physical

Array = NDArray[np.float64]

APART = 0.1
"""rad: closer minima are the same one."""

KEPT = 3

ROUNDS = 40
"""Most evaluations of a descent."""


def rotation_starts(C: Array, ridge: Array) -> Sequence[Array]:
    """The deepest minima (3, 3) over all rotations, best first, at most KEPT.

    Args:
        C: (9 + m, 9 + m) weighted sums, the rotation's rows first.
        ridge: (m,) inverse variances of the rest.
    """
    rest = C[9:, 9:] + np.diag(ridge)
    Q = C[:9, :9] - C[:9, 9:] @ np.linalg.solve(rest, C[9:, :9])
    # The search reads nine entries column after column, so it finds R^T.
    whole = np.zeros((10, 10))
    whole[:9, :9] = (Q + Q.T) / 2
    turned, F = descend_all(whole)
    kept: list[Array] = []
    for n in np.argsort(F):
        R = turned[n].T
        if all(float(np.sum(R * other)) < 1 + 2 * np.cos(APART) for other in kept):
            kept.append(R)
        if len(kept) == KEPT:
            break
    return kept or [covering_rotations()[0]]


def best_start(segments: Sequence[Segment], prior: Prior, levels: Levels) -> Guess:
    """A linear solution at the believed rotation, or at the best of all if none is believed."""
    loads = len(prior.guess.eta)
    C = weighted(segments, loads, levels)
    unit = np.concatenate([1 / np.diag(prior.information)[3:SHARED], *[SPREAD**2] * loads])
    if prior.information[0, 0] > 1 / NOBODY_KNOWS**2:
        return linear_start(C, unit, prior.guess.R)
    problem = PayloadProblem(C, prior)
    ends = [
        descend(problem, linear_start(C, unit, R), ROUNDS) for R in rotation_starts(C, 1 / unit)
    ]
    return min(ends, key=lambda end: end[1].cost)[0]


def linear_start(C: Array, unit: Array, R: Array) -> Guess:
    """Loads and bias by least squares at a rotation, made physical.

    Args:
        C: weighted sums over x.
        unit: (6 + 10 K,) variances that keep finite what the motion does not show.
        R: (3, 3).
    """
    found = np.linalg.solve(C[9:, 9:] + np.diag(1 / unit), -C[9:, :9] @ R.ravel())
    phi: Array = np.asarray(found[6:]).reshape(-1, 10)
    eta = [log_cholesky(nearest_physical(_with_mass(p))) for p in phi]
    return Guess(R, np.asarray(found[:6]), np.array(eta))


SPREAD = np.array([10.0, *[1.0] * 3, *[0.1] * 6])
"""kg, kg m and kg m^2: how far a load may be from none in a linear start."""

NOBODY_KNOWS = 0.5
"""rad: a rotation believed less well than this is searched for."""

LEAST = 1e-3
"""kg of a linear start."""


def _with_mass(phi: Array) -> Array:
    """A start with a mass above zero, whatever the linear solution says."""
    return phi if phi[0] > LEAST else np.array([LEAST, *[0.0] * 9])
