"""Torques of an arm's joints, linear in the inertial parameters of its links and in friction.

The load of every link is carried by all joints above it. With J_k the Jacobian of link k's frame
along its own axes, and Y_k the regressor of `wrenches` for the motion of that frame,

    tau = sum_k J_k^T Y_k phi_k + sum_m G_m^T (I_m s'_m + v_m s_m + c_m sign s_m + o_m),  s = G q'

(Atkeson, An and Hollerbach 1986). The rows of G say which joints a motor turns: the identity, or
with a coupled wrist a motor that turns with two joints. Rotor inertia I_m, viscous and Coulomb
friction v_m and c_m, and an offset o_m belong to the motors. Which combinations of all these the
joints can feel is a matter of rank (`base_directions`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import FIXED
from bodyschema.model.kinematics import frame_jacobian, relative_pose
from bodyschema.model.tree import Body
from bodyschema.senses.wrenches import load_regressor

Array = NDArray[np.float64]

STICKING = 0.01
"""rad/s over which the sign of a speed changes."""


@dataclass(frozen=True)
class ArmMotion:
    """Joint positions and their derivatives at many moments."""

    q: Array
    """(n, n_joints) rad or m."""
    dq: Array
    ddq: Array


def arm_regressor(
    body: Body, motion: ArmMotion, down: tuple[float, float, float] = (0.0, 0.0, -9.81)
) -> Array:
    """(n, n_joints, 10 n_links): columns are phi of each link that a joint moves, in order."""
    blocks = [_link_block(body, motion, link, np.asarray(down)) for link in moved_links(body)]
    return np.concatenate(blocks, axis=2)


def moved_links(body: Body) -> tuple[str, ...]:
    """Frames that hang on a moving joint; what is fixed to them is counted with them."""
    return tuple(frame for frame, kind in zip(body.frames, body.kind, strict=True) if kind != FIXED)


def _link_block(body: Body, motion: ArmMotion, link: str, down: Array) -> Array:
    """J^T Y of one link, (n, n_joints, 10)."""
    root, h = body.frames[0], 1e-5
    q, dq = motion.q, motion.dq
    R = relative_pose(body, q, root, link)[:, :3, :3]
    J, before, after = (frame_jacobian(body, q + s * h * dq, root, link) for s in (0, -1, 1))
    # Twists along the root's axes at the link's origin; dJ/dt q' by differences along the motion.
    change = np.einsum("nij,nj->ni", (after - before) / (2 * h), dq)
    twist = np.einsum("nij,nj->ni", J, dq)
    rate = np.einsum("nij,nj->ni", J, motion.ddq) + change
    a_g, w, dw = (
        np.einsum("nji,nj->ni", R, v) for v in (rate[:, :3] - down, twist[:, 3:], rate[:, 3:])
    )
    Y = load_regressor(a_g, w, dw)
    own = np.concatenate([np.swapaxes(R, 1, 2) @ J[:, :3], np.swapaxes(R, 1, 2) @ J[:, 3:]], axis=1)
    return np.asarray(np.swapaxes(own, 1, 2) @ Y)


def motor_regressor(motion: ArmMotion, G: Array) -> Array:
    """(n, n_joints, 4 n_motors): rotor inertia, viscous, Coulomb and offset of each motor.

    Args:
        motion: of the joints.
        G: (n_motors, n_joints) which joints each motor turns.
    """
    s, ds = motion.dq @ G.T, motion.ddq @ G.T
    columns = np.stack([ds, s, np.tanh(s / STICKING), np.ones_like(s)], axis=2)
    out = np.einsum("mj,nmc->njmc", G, columns)
    return np.asarray(out).reshape(len(s), G.shape[1], -1)


def base_directions(W: Array, tolerance: float = 1e-8) -> tuple[Array, list[int]]:
    """Which combinations of parameters the samples can tell.

    Args:
        W: (rows, parameters).
        tolerance: singular values below it times the largest are none, columns being scaled to
            length one.

    Returns:
        (parameters, rank) orthonormal directions in units of the scaled columns, and columns that
        are independent of each other (the base parameters' leading members), in order.
    """
    from scipy.linalg import qr

    length = np.linalg.norm(W, axis=0)
    scaled = W / np.where(length > 0, length, 1.0)
    _, sizes, Vt = np.linalg.svd(scaled, full_matrices=False)
    rank = int(np.sum(sizes > tolerance * sizes[0]))
    order = qr(scaled, mode="r", pivoting=True)[1]
    return Vt[:rank].T, sorted(int(k) for k in order[:rank])
