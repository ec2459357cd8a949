"""Closed forms for frames that nobody measured: point sets, A X = X B and K Y = X T.

All take weights, so that the robust loop in `starts` can call them again and again; all return
transforms, never iterate, and need no first guess.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.lie import nearest_rotation

Array = NDArray[np.float64]

RELATIVE_ROUNDING = 1e-13
"""Singular value, relative to the largest, below which a direction is not told."""


def align_points(source: Array, target: Array, weights: Array) -> Array:
    """The transform T that minimises sum w |T source - target|^2 (Kabsch 1976; Umeyama 1991).

    Args:
        source: (n, 3) points.
        target: (n, 3) the same points in the other frame.
        weights: (n,).
    """
    w = weights / weights.sum()
    centre_s, centre_t = w @ source, w @ target
    R = nearest_rotation((target - centre_t).T @ (w[:, None] * (source - centre_s)))
    return lie.transform(R, centre_t - R @ centre_s)


def mean_transform(transforms: Array, weights: Array) -> Array:
    """Chordal mean of (*batch, n, 4, 4) transforms under weights (*batch, n)."""
    w = weights / weights.sum(axis=-1, keepdims=True)
    R = nearest_rotation(np.einsum("...n,...nij->...ij", w, transforms[..., :3, :3]))
    return lie.transform(R, np.einsum("...n,...ni->...i", w, transforms[..., :3, 3]))


def solve_ax_xb(A: Array, B: Array, weights: Array) -> Array:
    """Hand-eye equation A_i X = X B_i from relative motions (Park and Martin 1994).

    The rotation aligns the motions' rotation vectors, log A_i = R_X log B_i; then the translation
    is linear: (R_A - 1) t_X = R_X t_B - t_A. Motions must turn about at least two axes.

    Args:
        A: (*batch, n, 4, 4) motions of the hand.
        B: (*batch, n, 4, 4) the same motions seen by the eye.
        weights: (*batch, n).
    """
    a, b = lie.log_so3(A[..., :3, :3]), lie.log_so3(B[..., :3, :3])
    R = nearest_rotation(np.einsum("...n,...ni,...nj->...ij", weights, a, b))
    root = np.sqrt(weights)[..., None]
    left = root[..., None] * (A[..., :3, :3] - np.eye(3))
    right = root * (B[..., :3, 3] @ np.swapaxes(R, -1, -2) - A[..., :3, 3])
    return lie.transform(R, least_squares(left, right))


def solve_ky_xt(K: Array, T: Array, weights: Array) -> tuple[Array, Array]:
    """Robot-world and hand-eye equation K_i Y = X T_i (Shah 2013).

    vec(R_X) = (R_T x R_K) vec(R_Y) for every sample, so the leading singular vectors of the mean
    of the Kronecker products are both rotations; then R_K t_Y - t_X = R_X t_T - t_K is linear.

    Args:
        K: (n, 4, 4) the robot's own kinematics.
        T: (n, 4, 4) what was seen.
        weights: (n,).

    Returns:
        X (4, 4) and Y (4, 4).
    """
    R_K, R_T = K[:, :3, :3], T[:, :3, :3]
    entries = np.tensordot(weights[:, None, None] * R_T, R_K, (0, 0))
    product = entries.transpose(0, 2, 1, 3).reshape(9, 9)
    U, _, Vt = np.linalg.svd(product)
    R_X, R_Y = U[:, 0].reshape(3, 3).T, Vt[0].reshape(3, 3).T
    # The pair of vectors is known up to one common sign: rotations have determinant +1.
    sign = np.sign(np.linalg.det(R_X))
    R_X, R_Y = nearest_rotation(sign * R_X), nearest_rotation(sign * R_Y)
    root = np.sqrt(weights)[:, None]
    left = np.concatenate([R_K, np.tile(-np.eye(3), (len(K), 1, 1))], axis=2) * root[..., None]
    right = (T[:, :3, 3] @ R_X.T - K[:, :3, 3]) * root
    t = least_squares(left, right)
    return lie.transform(R_X, t[3:]), lie.transform(R_Y, t[:3])


def least_squares(A: Array, b: Array) -> Array:
    """The shortest x that minimises sum |A_i x - b_i|^2, for many rows and few columns.

    A triangle first (QR), so that singular values are found of a small matrix only.

    Args:
        A: (*batch, n, d, k).
        b: (*batch, n, d).

    Returns:
        (*batch, k).
    """
    k = A.shape[-1]
    both = np.concatenate([A, b[..., None]], axis=-1).reshape(*A.shape[:-3], -1, k + 1)
    R = np.asarray(np.linalg.qr(both, mode="r"))
    inverse = np.linalg.pinv(R[..., :k], rcond=RELATIVE_ROUNDING)
    return np.asarray((inverse @ R[..., k:])[..., 0])
