"""Rotations and rigid transforms: SO(3) and SE(3), batched, exact near zero and near pi.

Symbols: w is a rotation vector (rad), R = exp(w) its matrix, T_a_b a 4x4 transform that takes
coordinates from frame b to frame a. All functions take any leading batch axes.

The Jacobians follow exp(w + d) ~ exp(J_left(w) d) exp(w) = exp(w) exp(J_right(w) d)
(Sola, Deray, Atchuthan 2018, "A micro Lie theory for state estimation in robotics", Eq. 143-146).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

SMALL_ANGLE = 1e-4
"""rad; below it the trigonometric quotients are replaced by their series (error < 1e-17)."""


def skew(vector: ArrayLike) -> Array:
    """Cross-product matrix: skew(v) @ u = v x u. (*batch, 3) -> (*batch, 3, 3)."""
    v = np.asarray(vector, dtype=np.float64)
    matrix = np.zeros((*v.shape, 3))
    matrix[..., 0, 1], matrix[..., 0, 2], matrix[..., 1, 2] = -v[..., 2], v[..., 1], -v[..., 0]
    matrix[..., 1, 0], matrix[..., 2, 0], matrix[..., 2, 1] = v[..., 2], -v[..., 1], v[..., 0]
    return matrix


def _quotients(angle: Array) -> tuple[Array, Array, Array]:
    """sin(t)/t, (1 - cos(t))/t^2 and (t - sin(t))/t^3."""
    t2 = angle * angle
    small = angle < SMALL_ANGLE
    safe = np.where(small, 1.0, angle)
    sine = np.where(small, 1 - t2 / 6, np.sin(safe) / safe)
    # 1 - cos(t) = 2 sin(t/2)^2 keeps all digits for small t.
    cosine = np.where(small, 0.5 - t2 / 24, 2 * np.sin(safe / 2) ** 2 / safe**2)
    cubic = np.where(small, 1 / 6 - t2 / 120, (safe - np.sin(safe)) / safe**3)
    return sine, cosine, cubic


def exp_so3(rotation_vector: ArrayLike) -> Array:
    """Rotation matrix of a rotation vector (rad). (*batch, 3) -> (*batch, 3, 3)."""
    w = np.asarray(rotation_vector, dtype=np.float64)
    sine, cosine, _ = _quotients(np.linalg.norm(w, axis=-1))
    W = skew(w)
    return np.asarray(np.eye(3) + sine[..., None, None] * W + cosine[..., None, None] * (W @ W))


def log_so3(rotation: ArrayLike) -> Array:
    """Rotation vector (rad, length <= pi) of a rotation matrix. (*batch, 3, 3) -> (*batch, 3).

    While no angle of the batch passes 120 degrees, the skew part sin(t) a and the trace tell it
    all, which is quick; beyond, the quaternion keeps the digits that the skew part loses.
    """
    R = np.asarray(rotation, dtype=np.float64)
    cosine = (R[..., 0, 0] + R[..., 1, 1] + R[..., 2, 2] - 1) / 2
    if cosine.size and cosine.min() > -0.5:
        vector = 0.5 * (R - np.swapaxes(R, -1, -2))[..., [2, 0, 1], [1, 2, 0]]
        sine = np.sqrt((vector * vector).sum(axis=-1))
        small = sine < SMALL_ANGLE
        safe = np.where(small, 1.0, sine)
        factor = np.where(small, 1 + sine**2 / 6, np.arctan2(sine, cosine) / safe)
        return np.asarray(factor[..., None] * vector)
    quaternion = quaternion_xyzw(R)
    vector, scalar = quaternion[..., :3], quaternion[..., 3]
    length = np.linalg.norm(vector, axis=-1)
    small = length < SMALL_ANGLE
    safe = np.where(small, 1.0, length)
    # t / sin(t/2) = 2 + (2/3) |v|^2 / 2 + ... where |v| = sin(t/2).
    factor = np.where(small, 2 + length**2 / 3, 2 * np.arctan2(length, scalar) / safe)
    return np.asarray(factor[..., None] * vector)


def left_jacobian(rotation_vector: ArrayLike) -> Array:
    """J_left(w): exp(w + d) ~ exp(J_left(w) d) exp(w). (*batch, 3) -> (*batch, 3, 3)."""
    w = np.asarray(rotation_vector, dtype=np.float64)
    _, cosine, cubic = _quotients(np.linalg.norm(w, axis=-1))
    W = skew(w)
    return np.asarray(np.eye(3) + cosine[..., None, None] * W + cubic[..., None, None] * (W @ W))


def right_jacobian(rotation_vector: ArrayLike) -> Array:
    """J_right(w) = J_left(-w): exp(w + d) ~ exp(w) exp(J_right(w) d)."""
    return left_jacobian(-np.asarray(rotation_vector, dtype=np.float64))


def inverse_left_jacobian(rotation_vector: ArrayLike) -> Array:
    """Inverse of J_left(w): log(exp(d) exp(w)) ~ w + J_left(w)^-1 d, for |w| < 2 pi."""
    w = np.asarray(rotation_vector, dtype=np.float64)
    angle = np.linalg.norm(w, axis=-1)
    small = angle < 1e-2
    safe = np.where(small, 1.0, angle)
    series = 1 / 12 + angle**2 / 720 + angle**4 / 30240
    closed = 1 / safe**2 - 1 / (2 * safe * np.tan(safe / 2))
    W = skew(w)
    factor = np.where(small, series, closed)[..., None, None]
    return np.asarray(np.eye(3) - 0.5 * W + factor * (W @ W))


def nearest_rotation(matrix: ArrayLike) -> Array:
    """The rotation closest to a matrix in the Frobenius norm (orthogonal Procrustes).

    (*batch, 3, 3) -> (*batch, 3, 3).
    """
    U, _, Vt = np.linalg.svd(np.asarray(matrix, dtype=np.float64))
    U[..., 2] *= np.sign(np.linalg.det(U @ Vt))[..., None]
    return np.asarray(U @ Vt)


def transform(rotation: ArrayLike, translation: ArrayLike) -> Array:
    """4x4 transform from (*batch, 3, 3) and (*batch, 3)."""
    R, t = np.asarray(rotation, dtype=np.float64), np.asarray(translation, dtype=np.float64)
    T = np.zeros((*np.broadcast_shapes(R.shape[:-2], t.shape[:-1]), 4, 4))
    T[..., :3, :3], T[..., :3, 3], T[..., 3, 3] = R, t, 1.0
    return T


def matrices(transforms: Any) -> Array:
    """Transforms as matrices, (*batch, 4, 4): of arrays, or scipy's RigidTransform, or a list."""
    if isinstance(transforms, list | tuple) and any(
        hasattr(one, "as_matrix") for one in transforms
    ):
        return np.stack([matrices(one) for one in transforms])
    made = transforms.as_matrix() if hasattr(transforms, "as_matrix") else transforms
    return np.asarray(made, dtype=np.float64)


def inverse(T_a_b: ArrayLike) -> Array:
    """T_b_a of T_a_b, without a matrix inversion. (*batch, 4, 4) -> (*batch, 4, 4)."""
    T = np.asarray(T_a_b, dtype=np.float64)
    R_b_a = np.swapaxes(T[..., :3, :3], -1, -2)
    return transform(R_b_a, -(R_b_a @ T[..., :3, 3:])[..., 0])


def quaternion_xyzw(rotation: ArrayLike) -> Array:
    """Unit quaternion with scalar >= 0 of a rotation matrix. (*batch, 3, 3) -> (*batch, 4).

    Each of the four components may lead; the largest is used, so no digit is lost anywhere.
    """
    R = np.asarray(rotation, dtype=np.float64)
    x, y, z = R[..., 0, 0], R[..., 1, 1], R[..., 2, 2]
    # Rows are q * 4 q_i for i = x, y, z, w.
    sums = (R + np.swapaxes(R, -1, -2))[..., [0, 0, 1], [1, 2, 2]]  # xy, xz, yz
    turns = (R - np.swapaxes(R, -1, -2))[..., [2, 0, 1], [1, 2, 0]]  # x, y, z
    candidates = np.empty((*x.shape, 4, 4))
    candidates[..., 0, :] = _stack(1 + x - y - z, sums[..., 0], sums[..., 1], turns[..., 0])
    candidates[..., 1, :] = _stack(sums[..., 0], 1 - x + y - z, sums[..., 2], turns[..., 1])
    candidates[..., 2, :] = _stack(sums[..., 1], sums[..., 2], 1 - x - y + z, turns[..., 2])
    candidates[..., 3, :] = _stack(turns[..., 0], turns[..., 1], turns[..., 2], 1 + x + y + z)
    largest = np.argmax(np.stack([x, y, z, x + y + z], axis=-1), axis=-1)
    q = np.take_along_axis(candidates, largest[..., None, None], axis=-2)[..., 0, :]
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    return np.asarray(np.where(q[..., 3:] < 0, -q, q))


def _stack(*columns: Array) -> Array:
    return np.stack(columns, axis=-1)


def rotation_from_xyzw(quaternion: ArrayLike) -> Array:
    """Rotation matrix of a quaternion of any length but zero. (*batch, 4) -> (*batch, 3, 3)."""
    q = np.asarray(quaternion, dtype=np.float64)
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    V, scalar = skew(q[..., :3]), q[..., 3, None, None]
    return np.asarray(np.eye(3) + 2 * (scalar * V + V @ V))


def rotation_from_rpy(rpy: ArrayLike) -> Array:
    """URDF's fixed-axis roll, pitch, yaw (rad): R = Rz(yaw) Ry(pitch) Rx(roll)."""
    angles = np.asarray(rpy, dtype=np.float64)
    turn = np.zeros((3, *angles.shape))
    for i in range(3):
        turn[i, ..., i] = angles[..., i]
    return np.asarray(exp_so3(turn[2]) @ exp_so3(turn[1]) @ exp_so3(turn[0]))


def rpy_from_rotation(rotation: ArrayLike) -> Array:
    """Fixed-axis roll, pitch, yaw (rad) of a rotation matrix; yaw = 0 at gimbal lock.

    Roll is read after yaw is undone: near gimbal lock its error then cancels that of yaw.
    """
    R = np.asarray(rotation, dtype=np.float64)
    level = np.hypot(R[..., 0, 0], R[..., 1, 0])
    pitch = np.arctan2(-R[..., 2, 0], level)
    yaw = np.where(level < 1e-12, 0.0, np.arctan2(R[..., 1, 0], R[..., 0, 0]))
    c, s = np.cos(yaw), np.sin(yaw)
    # The second row of Rz(-yaw) R = Ry(pitch) Rx(roll) is 0, cos(roll), -sin(roll).
    roll = np.arctan2(s * R[..., 0, 2] - c * R[..., 1, 2], c * R[..., 1, 1] - s * R[..., 0, 1])
    return _stack(roll, pitch, yaw)


def tangent_basis(axis: ArrayLike) -> Array:
    """Two unit vectors that complete a unit vector to a right-handed triad, without a pole.

    (*batch, 3) -> (*batch, 3, 2). Duff et al. 2017, "Building an orthonormal basis, revisited".
    """
    a = np.asarray(axis, dtype=np.float64)
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    sign = np.copysign(1.0, z)
    p = -1 / (sign + z)
    q = x * y * p
    first = _stack(1 + sign * x * x * p, sign * q, -sign * x)
    second = _stack(q, sign + y * y * p, -y)
    return np.stack([first, second], axis=-1)
