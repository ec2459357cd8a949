"""Turning: first orientations of frames that nobody measured, in closed form, then polished.

Symbols are those of `ends`: R and t of K between the frames that are known, X the placement of the
frame that looks, Y that of the frame that is seen. One unknown rotation aligns two sets of vectors;
of two unknowns the products are found first, see `placing`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.senses.placing import polished

Array = NDArray[np.float64]


def by_points(K: Array, seen: Array, v: Array, open_ends: tuple[bool, bool]) -> tuple[Array, Array]:
    """The transforms X and Y with K_i Y v_i = X p_i, (4, 4) each; identity where not open.

    One of them aligns two point sets. Both: R_K R_Y v + R_K t_Y - R_X p - t_X = -t_K is linear in
    their 24 numbers, whose rotations are put right before the polish.

    Args:
        K: (n, 4, 4).
        seen: (n, 3) m, the p_i.
        v: (n, 3) m.
        open_ends: whether X and Y are unknown.
    """
    R, t = K[:, :3, :3], K[:, :3, 3]
    find_x, find_y = open_ends

    def parts(z: Array) -> tuple[Array, Array]:
        ends = [lie.transform(lie.exp_so3(w), place) for w, place in z.reshape(-1, 2, 3)]
        return ends[0] if find_x else np.eye(4), ends[-1] if find_y else np.eye(4)

    def wrong(z: Array) -> Array:
        X, Y = parts(z)
        reached = t + np.einsum("nij,nj->ni", R, v @ Y[:3, :3].T + Y[:3, 3])
        return np.asarray(reached - seen @ X[:3, :3].T - X[:3, 3]).ravel()

    if not find_y:
        first = [_aligned(seen, t + np.einsum("nij,nj->ni", R, v))]
    elif not find_x:
        first = [_aligned(v, np.einsum("nji,nj->ni", R, seen - t))]
    else:
        first = _both_linear(R, t, seen, v)
    guess = np.concatenate([[*lie.log_so3(T[:3, :3]), *T[:3, 3]] for T in first])
    return parts(polished(wrong, [guess]))


def by_directions(
    R: Array, seen: Array, open_ends: tuple[bool, bool], X: Array, up: Array
) -> tuple[Array, Array]:
    """The rotation X and the direction u for which X^T R_i u is the direction that was seen.

    X alone is Wahba's problem, u alone a mean. Of both, the seen f = (X^T x u) vec R is linear in
    27 products, whose leading singular vectors are X and u; where the turns R are too few for
    that, the axes of the frame are tried as u.

    Args:
        R: (n, 3, 3).
        seen: (n, 3), about unit length.
        open_ends: whether X and u are unknown.
        X: (3, 3), kept if known.
        up: (3,) unit, kept if known.
    """
    find_x, find_up = open_ends

    def parts(z: Array) -> tuple[Array, Array]:
        u = z[-3:] / np.linalg.norm(z[-3:]) if find_up else up
        return lie.exp_so3(z[:3]) if find_x else X, u

    def wrong(z: Array) -> Array:
        turned, u = parts(z)
        return np.asarray(seen - (R @ u) @ turned).ravel()

    if not find_x:
        return parts(polished(wrong, [np.einsum("nji,nj->i", R, seen @ X.T)]))
    if not find_up:
        return parts(polished(wrong, [lie.log_so3(_turn(seen, R @ up))]))
    axes = [*np.eye(3), *-np.eye(3), *_lifted_up(R, seen)]
    guesses = [np.concatenate([lie.log_so3(_turn(seen, R @ u)), u]) for u in axes]
    return parts(polished(wrong, guesses))


def _both_linear(R: Array, t: Array, seen: Array, v: Array) -> list[Array]:
    """X and Y of `by_points` from its linear equation, (4, 4) each."""
    n, ones = len(seen), np.ones((len(seen), 1))
    of_x = np.einsum("ij,nk->nijk", -np.eye(3), np.hstack([seen, ones])).reshape(3 * n, 12)
    of_y = np.einsum("nij,nk->nijk", R, np.hstack([v, ones])).reshape(3 * n, 12)
    numbers = np.linalg.lstsq(np.hstack([of_x, of_y]), -t.ravel(), rcond=None)[0]
    return [
        lie.transform(lie.nearest_rotation(M[:, :3]), M[:, 3]) for M in numbers.reshape(2, 3, 4)
    ]


def _aligned(source: Array, target: Array) -> Array:
    """The transform that takes points (n, 3) best onto others (Kabsch 1976), (4, 4)."""
    a, b = source.mean(axis=0), target.mean(axis=0)
    R = _turn(source - a, target - b)
    return lie.transform(R, b - R @ a)


def _turn(source: Array, target: Array) -> Array:
    """The rotation that takes directions (n, 3) best onto others (Wahba 1965)."""
    return lie.nearest_rotation(target.T @ source)


def _lifted_up(R: Array, seen: Array) -> Array:
    """The direction u of f = (X^T x u) vec R, and its opposite, (2, 3)."""
    products = np.linalg.lstsq(R.reshape(-1, 9), seen, rcond=None)[0].T
    u = np.linalg.svd(products.reshape(9, 3))[2][0]
    return np.stack([u, -u])
