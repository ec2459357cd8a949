"""A start from nothing: the camera's rotation among all rotations, from the accumulated sums.

In the paper's relation R c + r_o - R_h r_k - p = 0 everything but R is linear. With D = sum A^T A
over all points, i the entries (vec R; 1) and j those of r_o and r_1 .. r_K, eliminating j leaves

    Q = D_ii - D_ij D_jj^-1 D_ji,   F(R) = y^T Q y,   y = (vec R; 1)                (10 x 10)

F has several minima over SO(3), and slow motion makes wrong ones deep. Damped Gauss-Newton from 48
rotations that cover SO(3) (the cube's 24 and the same 24 turned) finds all that matter. For
rotations the noise of c adds a constant to F, tr Sigma, so the right minimum has no bias.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import permutations, product

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.learners.hand_eye.chart import CameraAndPoints, from_transform

Array = NDArray[np.float64]

ROUNDS, LONGEST = 25, 0.8
"""Steps, and rad of the longest one."""

APART = 0.05
"""rad: closer minima are the same one."""

KEPT = 4


@lru_cache(maxsize=1)
def covering_rotations() -> Array:
    """(48, 3, 3) rotations of the cube, and the same after a twist."""
    cube = []
    for order in permutations(range(3)):
        for signs in product((1.0, -1.0), repeat=3):
            R = np.zeros((3, 3))
            R[range(3), list(order)] = signs
            if np.linalg.det(R) > 0:
                cube.append(R)
    twist = lie.exp_so3([0.45, 0.3, -0.4])
    return np.concatenate([np.array(cube), twist @ np.array(cube)])


def search(D: Array) -> list[CameraAndPoints]:
    """The deepest minima, best first, at most KEPT.

    Args:
        D: (K, 16, 16) sums of the paper's rows, one matrix a point.
    """
    whole = _join_points(D)
    size = len(whole)
    i, j = [*range(9), size - 1], [*range(9, size - 1)]
    # A ridge far below the noise: motions that leave r_o open must not end the search.
    rest = whole[np.ix_(j, j)] + 1e-9 * np.trace(whole) / size * np.eye(size - 10)
    solved = np.linalg.solve(rest, whole[np.ix_(j, i)])
    Q = whole[np.ix_(i, i)] - whole[np.ix_(i, j)] @ solved
    R, F = descend_all((Q + Q.T) / 2)
    found: list[CameraAndPoints] = []
    kept: list[Array] = []
    for n in np.argsort(F):
        if any(float(np.sum(R[n] * other)) > 1 + 2 * np.cos(APART) for other in kept):
            continue
        z = -solved @ _unknowns(R[n : n + 1])[0]
        kept.append(R[n])
        found.append(from_transform(lie.transform(R[n], z[:3]), z[3:].reshape(-1, 3)))
        if len(found) == KEPT:
            break
    return found


def _join_points(D: Array) -> Array:
    """One matrix over (vec R, r_o, r_1 .. r_K, 1) from one a point."""
    K = len(D)
    whole = np.zeros((13 + 3 * K, 13 + 3 * K))
    for k, part in enumerate(D):
        at = [*range(12), *range(12 + 3 * k, 15 + 3 * k), 12 + 3 * K]
        whole[np.ix_(at, at)] += part
    return whole


def _unknowns(R: Array) -> Array:
    """y (n, 10): columns of the rotations, then 1."""
    columns = np.swapaxes(R, 1, 2).reshape(-1, 9)
    return np.hstack([columns, np.ones((len(R), 1))])


def descend_all(Q: Array) -> tuple[Array, Array]:
    """Minima (48, 3, 3) of y^T Q y reached from all starts, and their costs (48,)."""
    R = covering_rotations()
    y = _unknowns(R)
    F = np.einsum("ni,ij,nj->n", y, Q, y)
    mu = np.full(len(R), 1e-3)
    generators = np.asarray(lie.skew(np.eye(3)))
    for _ in range(ROUNDS):
        # d vec(exp(w) R) / d w_k, columns of [e_k]x R.
        by = np.einsum("kab,nbc->nkca", generators, R).reshape(len(R), 3, 9)
        H = by @ Q[:9, :9] @ np.swapaxes(by, 1, 2)
        g = (by @ (y @ Q)[:, :9, None])[..., 0]
        level = mu * np.trace(H, axis1=1, axis2=2) + 1e-300
        step = -np.linalg.solve(H + level[:, None, None] * np.eye(3), g[..., None])[..., 0]
        length = np.linalg.norm(step, axis=1)
        step *= np.minimum(1.0, LONGEST / np.maximum(length, 1e-300))[:, None]
        there = lie.exp_so3(step) @ R
        y_there = _unknowns(there)
        F_there = np.einsum("ni,ij,nj->n", y_there, Q, y_there)
        better = F_there < F
        R = np.where(better[:, None, None], there, R)
        y, F = np.where(better[:, None], y_there, y), np.where(better, F_there, F)
        mu = np.where(better, mu / 5, mu * 10)
        if length.max() < 1e-6:
            break
    return R, F
