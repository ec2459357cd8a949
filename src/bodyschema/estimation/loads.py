"""Loads as people read them: mass, centre and moments of an estimate that holds their roots."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.estimate import Estimate
from bodyschema.model.inertia import Inertia, phi_of_log_cholesky

Array = NDArray[np.float64]

SIX = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
"""Places of the moments in their order: xx, xy, yy, xz, yz, zz."""


def load_of(estimate: Estimate, name: str) -> tuple[Inertia, Array]:
    """A load in its own frame, and the covariance (10, 10) of its parameters phi.

    Numbers of it that were not free count as known.
    """
    part = estimate.body.part(name)
    phi, slope = phi_of_log_cholesky(part.values)
    columns, numbers = estimate.variables.of_part(name)
    J = slope[:, numbers]
    P = estimate.covariance[np.ix_(columns, columns)]
    return Inertia.from_phi(phi), np.asarray(J @ P @ J.T)


def free_loads(estimate: Estimate) -> tuple[str, ...]:
    """Names of the loads that were free, in order."""
    groups = dict.fromkeys(estimate.variables.groups)
    return tuple(group.removeprefix("load:") for group in groups if group.startswith("load:"))


def com_covariance(load: Inertia, P: Array) -> Array:
    """(3, 3) m^2 of the centre of mass c = h / m, from that of phi (10, 10)."""
    J = com_slope(load)
    return np.asarray(J @ P[:4, :4] @ J.T)


def com_slope(load: Inertia) -> Array:
    """(3, 4) d c / d (m, h) of the centre of mass c = h / m."""
    return np.hstack([-load.com[:, None], np.eye(3)]) / load.mass


def moments_covariance(load: Inertia, P: Array) -> Array:
    """(6, 6) of xx, xy, yy, xz, yz, zz about the centre of mass, from that of phi (10, 10)."""
    phi, J = load.phi, np.zeros((6, 10))
    for k in range(10):
        step = 1e-6 * max(abs(float(phi[k])), 1e-3)
        ends = [Inertia.from_phi(phi + s * step * np.eye(10)[k]).moments for s in (1, -1)]
        J[:, k] = [(ends[0][i, j] - ends[1][i, j]) / (2 * step) for i, j in SIX]
    return np.asarray(J @ P @ J.T)
