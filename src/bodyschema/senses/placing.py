"""Placing: first positions of frames that nobody measured, in closed form, then polished.

Symbols are those of `ends`: R and t of K between the frames that are known, x the position in the
frame that looks, y that in the frame that is seen. Equations with products of unknowns become
linear when the products count as unknowns of their own (lifting); a robust polish follows, since a
lifted solution forgets what ties the products to their factors.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def by_distances(
    R: Array, known: Array, d: Array, open_ends: tuple[bool, bool], uncertain_zero: bool
) -> tuple[Array, Array]:
    """Positions x and y that put R_i y + k_i - x at distance d_i - c from zero, (3,) m each.

    |R y + k - x|^2 = (d - c)^2 reads, with s = x^2 + y^2 - c^2,

        d^2 - k^2 = s + 2 (R^T k) . y - 2 k . x - 2 sum_ij R_ij x_i y_j + 2 c d

    which is linear in x, y, their nine products, c and s.

    Args:
        R: (n, 3, 3).
        known: (n, 3) m, the k_i.
        d: (n,) m.
        open_ends: whether x and y are unknown; zero if not.
        uncertain_zero: whether the readings may have a zero c of their own.
    """
    find_x, find_y = open_ends
    widths = (3 * find_x, 3 * find_y, int(uncertain_zero))
    a, b, c = (slice(sum(widths[:k]), sum(widths[: k + 1])) for k in range(3))

    def wrong(z: Array) -> Array:
        p = known + (R @ z[b] if find_y else 0.0) - (z[a] if find_x else 0.0)
        return np.asarray(np.linalg.norm(p, axis=1) - d + z[c].sum())

    columns = [-2 * known] if find_x else []
    columns += [2 * np.einsum("nij,ni->nj", R, known)] if find_y else []
    columns += [2 * d[:, None]] if uncertain_zero else []
    columns += [-2 * R.reshape(-1, 9)] if find_x and find_y else []
    lifted = np.hstack([*columns, np.ones((len(d), 1))])
    first = np.linalg.lstsq(lifted, d**2 - np.sum(known**2, axis=1), rcond=None)[0]
    z = polished(wrong, [first[: sum(widths)], np.zeros(sum(widths))])
    none = np.zeros(3)
    return z[a] if find_x else none, z[b] if find_y else none


def by_heights(
    R: Array, known: Array, height: Array, open_ends: tuple[bool, bool], up: Array
) -> tuple[Array, float, Array]:
    """The plane n . p = c and the point y for which n . (R_i y + k_i) - c is the known height.

    The plane alone is the thinnest direction of the points; the point alone is linear; of both the
    products n_i y_j are unknown too, and the thinnest direction of all 13 columns has them. The
    opposite normal fits as well: `up` says which of the two is meant.

    Args:
        R: (n, 3, 3).
        known: (n, 3) m, the k_i.
        height: (n,) m, zero for a point that touches, the radius for a ball.
        open_ends: whether the plane and the point are unknown; z = 0 and zero if not.
        up: (3,) roughly the side that the normal points to.
    """
    plane, point = open_ends

    def parts(z: Array) -> tuple[Array, float, Array]:
        n = z[:3] / np.linalg.norm(z[:3]) if plane else np.array([0.0, 0.0, 1.0])
        return n, float(z[3]) if plane else 0.0, z[-3:] if point else np.zeros(3)

    def wrong(z: Array) -> Array:
        n, c, y = parts(z)
        return np.asarray((known + R @ y) @ n - c - height)

    if not plane:
        first = np.asarray(np.linalg.lstsq(R[:, 2], height - known[:, 2], rcond=None)[0])
        return parts(polished(wrong, [first]))
    columns = [R.reshape(-1, 9)] if point else []
    thin = _thinnest(np.hstack([*columns, known, np.ones((len(known), 1))]))
    n, c = thin[-4:-1], -thin[-1]
    size = np.linalg.norm(n) * (1.0 if n @ up >= 0 else -1.0)
    y = thin[:9].reshape(3, 3).T @ n / (n @ n) if point else np.empty(0)
    first = np.concatenate([n / size, [c / size - height.mean()], y]).astype(np.float64)
    return parts(polished(wrong, [first]))


def _thinnest(columns: Array) -> Array:
    """The unit vector that a matrix shrinks most."""
    return np.asarray(np.linalg.svd(columns, full_matrices=True)[2][-1])


def polished(residual: Callable[[Array], Array], guesses: Sequence[Array]) -> Array:
    """The guess that a robust least-squares polish takes lowest, after the polish.

    Cauchy loss at twice the median residual of each guess holds off a minority of wrong samples;
    the guess with the smallest median residual wins.

    Args:
        residual: (k,) unknowns -> (m,) residuals in one unit.
        guesses: (k,) each.
    """
    from scipy.optimize import least_squares

    best, lowest = guesses[0], np.inf
    for guess in guesses:
        width = 2 * float(np.median(np.abs(residual(guess)))) + 1e-12
        for _ in range(2):
            found = least_squares(residual, guess, loss="cauchy", f_scale=width, max_nfev=50)
            guess, middle = found.x, float(np.median(np.abs(residual(found.x))))
            width = 2 * middle + 1e-12
        if middle < lowest:
            best, lowest = guess, middle
    return np.asarray(best)
