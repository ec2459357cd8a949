"""The weighted normal equations of any number of senses at one vector of variables.

    cost      C(x) = 1/2 sum_i w_i |r_i|^2 / s^2  +  1/2 x^T P x,      P = diag(prior_std^-2)
    gradient  g = sum_i w_i J_i^T r_i / s^2 + P x
    Hessian   H = sum_i w_i J_i^T J_i / s^2 + P                       (Gauss-Newton)

r is the residual whitened by the shape of the noise, s the noise level of each component of a
sense (a sense of poses has one for positions and one for rotations), w_i the robust weight.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]

RELATIVE_ROUNDING = 1e-13
"""Smallest eigenvalue, relative to the largest, that a Cholesky factor of this size carries."""

CHUNK = 4096
"""Rows that are scaled at once: they stay in the cache, and no second copy of a large Jacobian is
made."""


@dataclass(frozen=True)
class Whitened:
    """One sense's residuals in units of its believed noise, before level and robust weight."""

    sense: Sense
    residual: Array
    """(n, dimension)."""
    jacobian: Array
    """(n, dimension, n_parameters)."""
    factor: Array
    """(dimension, dimension) Cholesky factor of the noise: factor @ residual is in SI units."""


def whiten(sense: Sense, reference: Body, variables: Variables, x: Array) -> Whitened:
    """Residual and Jacobian multiplied by the inverse Cholesky factor of the noise."""
    linear = sense.linearize(reference, variables, x)
    L = np.asarray(np.linalg.cholesky(sense.covariance), dtype=np.float64)
    residual = solve_rows(L, linear.residual[..., None])[..., 0]
    return Whitened(sense, residual, solve_rows(L, linear.by_parameter), L)


def solve_rows(L: Array, J: Array) -> Array:
    """L^-1 J_i for every sample, (n, d, k); noise without correlations only scales the rows."""
    if np.count_nonzero(L) == len(L):
        return np.asarray(J / np.diag(L)[:, None])
    n, d, k = J.shape
    flat, _ = lapack.dtrtrs(L, J.transpose(1, 0, 2).reshape(d, n * k), lower=1)
    return np.ascontiguousarray(flat.reshape(d, n, k).transpose(1, 0, 2))


def whitened_residual(sense: Sense, body: Body) -> Array:
    """Residual of a body in units of the believed noise, (n, dimension)."""
    L = np.asarray(np.linalg.cholesky(sense.covariance))
    return solve_rows(L, sense.residual(body)[..., None])[..., 0]


def level_rows(sense: Sense, levels: Sequence[float] | Array) -> Array:
    """Noise level of each row of the residual, (dimension,)."""
    rows = np.empty(len(sense.covariance))
    for (_, _, part), level in zip(sense.components, levels, strict=True):
        rows[part] = level
    return rows


def scatter(J: Array, root: Array) -> Array:
    """sum_i root_i^2 J_i^T J_i: (n, d, N) and (n,) or (n, d) -> (N, N)."""
    n, d, N = J.shape
    total, rows = np.zeros((N, N)), max(CHUNK // max(d, 1), 1)
    scale = root if root.ndim == 2 else root[:, None]
    for a in range(0, n, rows):
        A = J[a : a + rows] * scale[a : a + rows, :, None]
        A = A.reshape(len(A) * d, N)
        total += A.T @ A
    return total


def pulled(J: Array, r: Array) -> Array:
    """sum_i J_i^T r_i: (n, d, N) and (n, d) -> (N,)."""
    return np.asarray(r.ravel() @ J.reshape(r.size, J.shape[2]))


def information(
    parts: Sequence[Whitened], levels: Sequence[Sequence[float]], weights: Sequence[Array]
) -> tuple[Array, Array]:
    """Data part of the Hessian and of the gradient: (N, N) and (N,)."""
    n_parameters = parts[0].jacobian.shape[2]
    H, g = np.zeros((n_parameters, n_parameters)), np.zeros(n_parameters)
    for part, level, weight in zip(parts, levels, weights, strict=True):
        root = np.sqrt(weight)[:, None] / level_rows(part.sense, level)
        H += scatter(part.jacobian, root)
        g += pulled(part.jacobian, root**2 * part.residual)
    return H, g


def positive_factor(H: Array) -> Array:
    """Lower Cholesky factor of an information matrix in units of the prior, (N, N).

    Its eigenvalues are 1 or more, 1 being the prior. When nearly exact data meet directions that
    they do not touch, rounding can push such an eigenvalue below zero; it is then put back to 1,
    or to the smallest value that the factor can carry. LAPACK is called directly: at this size
    its wrappers take longer than the work.
    """
    if not len(H):
        return H
    L, failed = lapack.dpotrf(H, lower=1)
    if failed:
        values, vectors = np.linalg.eigh(H)
        values = np.maximum(values, max(1.0, RELATIVE_ROUNDING * values[-1]))
        L, _ = lapack.dpotrf((vectors * values) @ vectors.T, lower=1)
    return np.asarray(L)


def solve_factored(L: Array, b: Array) -> Array:
    """H^-1 b from the factor of H, (N,) or (N, k)."""
    return np.asarray(lapack.dpotrs(L, b, lower=1)[0]) if len(L) else b
