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

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import FIXED
from bodyschema.model.kinematics import frame_jacobian, relative_pose
from bodyschema.model.motion import Motion, frame_motions, own
from bodyschema.model.tree import Body
from bodyschema.senses.wrenches import load_regressor

Array = NDArray[np.float64]

STICKING = 0.01
"""rad/s over which the sign of a speed changes."""


def arm_regressor(
    body: Body, motion: Motion, down: tuple[float, float, float] = (0.0, 0.0, -9.81)
) -> Array:
    """(n, n_joints, 10 n_links): columns are phi of each link that a joint moves, in order.

    Args:
        body: the arm.
        motion: of its joints.
        down: m/s^2, gravity along the root's axes.
    """
    g = np.tile(np.asarray(down), (len(motion.q), 1))
    felt = link_wrenches(body, motion, moved_links(body), g)
    return np.concatenate([np.swapaxes(J, 1, 2) @ Y for J, Y in felt], axis=2)


def moved_links(body: Body) -> tuple[str, ...]:
    """Frames that hang on a moving joint; what is fixed to them is counted with them."""
    return tuple(frame for frame, kind in zip(body.frames, body.kind, strict=True) if kind != FIXED)


def link_wrenches(
    body: Body, motion: Motion, links: Sequence[str], down: Array
) -> Iterator[tuple[Array, Array]]:
    """For each link in turn its twists by the joints J (n, 6, n_joints), and Y (n, 6, 10).

    Args:
        body: the arm.
        motion: of its joints.
        links: frames that the loads are written in.
        down: (n, 3) m/s^2, gravity along the root's axes.
    """
    root, moved = body.frames[0], frame_motions(body, motion, links)
    for link in links:
        R = relative_pose(body, motion.q, root, link)[:, :3, :3]
        J, felt = frame_jacobian(body, motion.q, root, link), moved[link]
        twists = np.concatenate([own(R, J[:, :3]), own(R, J[:, 3:])], axis=1)
        yield twists, load_regressor(felt.a - own(R, down), felt.w, felt.dw)


def motor_regressor(motion: Motion, G: Array) -> Array:
    """(n, n_joints, 4 n_motors): rotor inertia, viscous, Coulomb and offset of each motor.

    Args:
        motion: of the joints.
        G: (n_motors, n_joints) which joints each motor turns.
    """
    s, ds = motion.dq @ G.T, motion.ddq @ G.T
    columns = np.stack([ds, s, np.tanh(s / STICKING), np.ones_like(s)], axis=2)
    out = np.einsum("mj,nmc->njmc", G, columns)
    return np.asarray(out).reshape(len(s), G.shape[1], 4 * len(G))


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
