"""Visual servoing: small steps to the aims by the body as it is believed at that moment.

With the pose x_c of each hand in the eye, by the adapted body, and its aim x_d (Eq. 28-31 of
Vicente, Jamone, Bernardino 2016; position based, the eyes looking at the hand):

    e = (p_c - p_d, log(R_c R_d^T))          twist in the frame of the eye, at the hand
    dq = -g k J*(theta + beta^) e            g = lambda dt, the share of the error taken in a frame

e is a pose error, not a difference of matrices. J* is the pseudo-inverse in which a singular value
s below s_0 is damped, s / (s^2 + (1 - (s / s_0)^2) d^2) (Nakamura and Hanafusa 1986; Chiaverini
1997), so that near a singular posture the joints stay slow. Joints that would leave their range are
held and the others solve again. With several aims e and J are stacked: two arms move at once, and
joints that they share serve both.

The gate k follows from what is known of the hand: with P the covariance of its position in the eye
and r = sqrt(largest eigenvalue of P), k falls from 1 at r = `sure` to 0 at r = `lost`, for the
worst hand. A robot that does not know where its hand is stands still.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema import lie
from bodyschema.acting.inverse_kinematics import Aim
from bodyschema.errors import InputError
from bodyschema.model.kinematics import frame_jacobian, relative_pose
from bodyschema.model.tree import Body

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ServoStep:
    """The next command, and why it is no larger."""

    q: Array
    """(n_joints,) encoder readings to go to."""
    position_error: float
    """m, of the worst aim, as far as the body knows."""
    rotation_error: float
    """rad, of the worst aim."""
    uncertainty: float
    """r, m; 0 where no covariance was given."""
    gate: float
    """k, 0 to 1."""
    held: tuple[str, ...]
    """Joints that stand at the end of their range and would have to leave it."""


@dataclass(frozen=True)
class Servoing:
    """Settings of the control law."""

    gain: float = 0.3
    """g; the paper's lambda is 5 1/s and its frame time is not stated: 0.06 s."""
    arm: float = 0.3
    """m a rad: an error of one radian weighs as much as this length."""
    slow_below: float = 0.05
    """s_0, m a rad: singular values below are damped."""
    damping: float = 0.02
    """d, m a rad."""
    largest_step: float = 0.05
    """rad, of any joint in a frame."""
    sure: float = 0.01
    """m; so well known, the hand moves at full speed."""
    lost: float = 0.03
    """m; so badly known, it stands still."""

    def step(
        self,
        body: Body,
        q: ArrayLike,
        aims: Sequence[Aim],
        joints: Sequence[str],
        offset_covariance: ArrayLike | None = None,
    ) -> ServoStep:
        """One frame's command.

        Args:
            body: the adapted one, such as `replace(body, offset=body.offset + beta)`.
            q: (n_joints,) encoder readings now.
            aims: where which hands should be, seen from where.
            joints: those that may move.
            offset_covariance: (len(joints),) * 2 rad^2, what is known of their offsets; None where
                the body is taken for granted.

        Raises:
            InputError: no aim, no such frame or joint, or a covariance of another size.
        """
        readings = np.asarray(q, dtype=np.float64)
        columns = np.array([body.joint_index(name) for name in joints], dtype=np.int64)
        if not aims:
            raise InputError("there is no aim to go to; give at least one.")
        errors, slopes = _stacked(body, readings, aims, columns)
        r = _uncertainty(slopes, offset_covariance)
        k = float(np.clip((self.lost - r) / (self.lost - self.sure), 0.0, 1.0))
        weight = np.where(np.arange(errors.shape[1]) < 3, 1.0, self.arm)
        A = (slopes * weight[:, None]).reshape(-1, len(columns))
        e = (errors * weight).ravel()
        room = (body.lower - readings)[columns], (body.upper - readings)[columns]
        dq, held = self._within(A, -self.gain * k * e, room)
        there = readings.copy()
        there[columns] += dq
        sizes = np.linalg.norm(errors.reshape(-1, 2, 3), axis=2).max(axis=0)
        names = tuple(name for name, is_held in zip(joints, held, strict=True) if is_held)
        return ServoStep(
            np.clip(there, body.lower, body.upper), float(sizes[0]), float(sizes[1]), r, k, names
        )

    def _within(self, A: Array, wanted: Array, room: tuple[Array, Array]) -> tuple[Array, Array]:
        """dq with A dq near `wanted`, within low..high, and which joints had to be held."""
        low, high = room
        held = np.zeros(A.shape[1], dtype=bool)
        while True:
            dq = np.where(held, 0.0, self._damped_solve(A * ~held, wanted))
            dq *= min(1.0, self.largest_step / max(np.abs(dq).max(), 1e-12))
            # At the end of the range and pushing on; a joint on its way there is clipped later.
            beyond = ~held & (((dq < 0) & (low >= -1e-9)) | ((dq > 0) & (high <= 1e-9)))
            if not beyond.any():
                return np.asarray(np.clip(dq, np.minimum(low, 0), np.maximum(high, 0))), held
            held |= beyond

    def _damped_solve(self, A: Array, wanted: Array) -> Array:
        """J* wanted."""
        U, s, Vt = np.linalg.svd(A, full_matrices=False)
        damped = np.maximum(1 - (s / self.slow_below) ** 2, 0.0) * self.damping**2
        inverse = np.divide(s, s**2 + damped, out=np.zeros_like(s), where=s > 1e-12)
        return np.asarray(Vt.T @ (inverse * (U.T @ wanted)))


def pose_error(T_a_c: ArrayLike, T_a_d: ArrayLike) -> Array:
    """e = (p_c - p_d, log(R_c R_d^T)), (*batch, 6) m and rad, in frame a (Eq. 28)."""
    c, d = np.asarray(T_a_c, dtype=np.float64), np.asarray(T_a_d, dtype=np.float64)
    turn = lie.log_so3(c[..., :3, :3] @ np.swapaxes(d[..., :3, :3], -1, -2))
    return np.concatenate([c[..., :3, 3] - d[..., :3, 3], turn], axis=-1)


def _stacked(
    body: Body, q: Array, aims: Sequence[Aim], columns: NDArray[np.int64]
) -> tuple[Array, Array]:
    """Errors (n_aims, 6) and Jacobians (n_aims, 6, n) of all aims; free rotations are zero."""
    errors, slopes = [], []
    for aim in aims:
        T = relative_pose(body, q, aim.seen_from, aim.seen)
        J = frame_jacobian(body, q, aim.seen_from, aim.seen)[:, columns]
        R_d = T[:3, :3] if aim.rotation is None else aim.rotation
        if aim.rotation is None:
            J[3:] = 0.0
        errors.append(pose_error(T, lie.transform(R_d, aim.position)))
        slopes.append(J)
    return np.stack(errors), np.stack(slopes)


def _uncertainty(slopes: Array, offset_covariance: ArrayLike | None) -> float:
    """r of the hand that is known worst, m."""
    if offset_covariance is None:
        return 0.0
    C = np.asarray(offset_covariance, dtype=np.float64)
    n = slopes.shape[2]
    if C.shape != (n, n):
        raise InputError(f"expected a covariance ({n}, {n}) of the offsets, got {C.shape}.")
    J = slopes[:, :3]
    P = J @ C @ np.swapaxes(J, 1, 2)
    return float(np.sqrt(max(np.linalg.eigvalsh(P).max(), 0.0)))
