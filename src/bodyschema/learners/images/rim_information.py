"""How much the outline of a body in several pictures says, and of what.

With H = J^T W J of all rows (see `rim_fit`), z = (x, y), y the doubts with prior covariance D, what
the rows say of x alone is the Schur complement

    H_x = H_xx - H_xy (H_yy + D^-1)^-1 H_yx

Pixels along a contour err together, and so do all points of one piece in one picture when the mask
is wrong there. The sums of w r J over such groups g, their share of the doubts taken off, tell by
how much the information of independent points is too large:

    f = G / (G - 1) sum_g |H_x^-1/2 u_g|^2 / n,    u_g = sum_i in g w_i r_i (J_x - J_y (H_yy +
        D^-1)^-1 H_yx)_i

for n unknowns and G groups: pieces in pictures, or whole postures, whichever gives more. H_x / f is
the information of the data: f is the design effect of cluster sampling (Kish 1965; Liang and Zeger
1986, here as one factor), with the noise level in it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.images.rim_fit import RimRows

Array = NDArray[np.float64]

LEAST_EFFECT = 0.27
"""pixels^2: 0.3 pixels that err together over 3 pixels of contour. Postures that are much alike
agree better than that, and are wrong together."""


def design_effect(rows: Sequence[RimRows], scale: Array, n: int) -> float:
    """f, pixels^2: what J^T W J of all rows has to be divided by.

    Args:
        rows: of several postures.
        scale: (size,) standard deviations of the prior of z.
        n: how many of z are not doubts.
    """
    H = np.sum([r.H for r in rows], axis=0) * np.outer(scale, scale)
    B = H[:n, n:] / LEAST_EFFECT
    shares = np.linalg.solve(H[n:, n:] / LEAST_EFFECT + np.eye(len(H) - n), B.T)
    pulls = [
        (r.J[:, :n] * scale[:n] - (r.J[:, n:] * scale[n:]) @ shares) * (r.weight * r.left)[:, None]
        for r in rows
    ]
    by_piece = [
        pull[r.group == g].sum(axis=0)
        for r, pull in zip(rows, pulls, strict=True)
        for g in np.unique(r.group)
    ]
    values, vectors = np.linalg.eigh(H[:n, :n] - H[:n, n:] @ shares)
    told = values > 1e-9 * values[-1]
    found = [LEAST_EFFECT]
    for u in (by_piece, [pull.sum(axis=0) for pull in pulls]):
        if len(u) > 1 and told.any():
            white = (np.array(u) @ vectors[:, told]) / np.sqrt(values[told])
            found.append(len(u) / (len(u) - 1) * float(np.sum(white**2)) / int(told.sum()))
    return max(found)


def without(H: Array, scale: Array, n: int) -> Array:
    """Information of the first n unknowns when the others are known by their prior only.

    Args:
        H: (size, size) information of the data.
        scale: (size,) standard deviations of the prior; 0 for what is known.
        n: how many are kept.
    """
    B, S = H[:n, n:] * scale[n:], scale[n:]
    C = H[n:, n:] * np.outer(S, S) + np.eye(len(S))
    A = H[:n, :n] - B @ np.linalg.solve(C, B.T)
    return np.asarray((A + A.T) / 2)
