"""How a frame moves through space when the joints move: what a sensor or a load on it feels.

Along the frame's own axes, w its angular velocity, dw the rate of w, a the acceleration of its
origin. From the parent outward, with T = (R, r) the pose of frame k in its parent and u its axis
(Luh, Walker and Paul 1980, "On-line computational scheme for mechanical manipulators"),

    a_k  = R^T (a + dw x r + w x (w x r))             w_k = R^T w,  dw_k = R^T dw
    turning joint   dw_k += w_k x u s' + u s''        then  w_k += u s'
    sliding joint   a_k  += 2 w_k x u s' + u s''      s' = rate (1 + gear) q'

The root stands still. When a variable moves the frame by the twist (p, t), linear and angular along
the root's axes (`kinematics.PoseDerivatives`), then with the root seen from the frame through R^T

    d a = R^T p'' - R^T t x a,      d w = R^T t',      d dw = R^T t'' - w x R^T t'

and t', t'', p'' follow by differences of the twist along the motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import FIXED, REVOLUTE
from bodyschema.model.kinematics import path_between, relative_pose, relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables

Array = NDArray[np.float64]

STEP = 1e-4
"""s; differences of twists along the motion are good to seven digits there, up to some rad/s."""


@dataclass(frozen=True)
class Motion:
    """Joint readings and their derivatives at many moments."""

    q: Array
    """(n, n_joints) rad or m."""
    dq: Array
    """(n, n_joints) per s."""
    ddq: Array
    """(n, n_joints) per s^2."""

    @classmethod
    def rest(cls, q: Array) -> Motion:
        """No motion."""
        return cls(q, np.zeros_like(q), np.zeros_like(q))


@dataclass(frozen=True)
class FrameMotion:
    """Of one frame against the root, along its own axes."""

    a: Array
    """(n, 3) m/s^2, of the origin."""
    w: Array
    """(n, 3) rad/s."""
    dw: Array
    """(n, 3) rad/s^2."""


@dataclass(frozen=True)
class MotionDerivatives:
    """Of a, w and dw stacked."""

    by_joint: Array
    """(n, 9, n_joints), at fixed speeds and accelerations of the readings."""
    by_parameter: Array
    """(n, 9, n_parameters)."""


def frame_motion(body: Body, motion: Motion, frame: str) -> FrameMotion:
    """Accelerations and angular velocity of a frame.

    Args:
        body: the model.
        motion: of its joints.
        frame: whose motion it is.
    """
    return frame_motions(body, motion, [frame])[frame]


def frame_motions(body: Body, motion: Motion, frames: Sequence[str]) -> dict[str, FrameMotion]:
    """The same of several frames, by name; what lies on the way to them is walked once."""
    root, still = body.frames[0], np.zeros((len(motion.q), 3))
    known = {root: FrameMotion(still, still, still)}
    for frame in frames:
        for k in path_between(body, root, frame)[0]:
            if body.frames[k] not in known:
                parent = body.frames[body.parent[k]]
                known[body.frames[k]] = _carried(body, motion, known[parent], parent, int(k))
    return {frame: known[frame] for frame in frames}


def _carried(body: Body, motion: Motion, before: FrameMotion, parent: str, k: int) -> FrameMotion:
    """The motion of frame k from that of its parent."""
    T = relative_pose(body, motion.q, parent, body.frames[k])
    R, r, w = T[:, :3, :3], T[:, :3, 3], before.w
    a = own(R, before.a + np.cross(before.dw, r) + np.cross(w, np.cross(w, r)))
    w, dw = own(R, w), own(R, before.dw)
    if body.kind[k] == FIXED:
        return FrameMotion(a, w, dw)
    joint = body.driver[k]
    scale = body.rate[k] * (1 + body.gear[joint]) * body.axis[k]
    speed, rise = motion.dq[:, joint, None] * scale, motion.ddq[:, joint, None] * scale
    if body.kind[k] == REVOLUTE:
        return FrameMotion(a, w + speed, dw + np.cross(w, speed) + rise)
    return FrameMotion(a + 2 * np.cross(w, speed) + rise, w, dw)


def motion_derivatives(
    reference: Body, variables: Variables, x: Array, motion: Motion, frame: str
) -> MotionDerivatives:
    """Derivatives of `frame_motion` of the body that deviates from the reference by x."""
    root, h = reference.frames[0], STEP
    now = frame_motion(reference.with_variables(variables, x), motion, frame)
    before, here, after = (
        relative_pose_derivatives(reference, variables, x, q, root, frame)
        for q in (motion.q + s * h * (motion.dq + s * h / 2 * motion.ddq) for s in (-1, 0, 1))
    )
    R = here.pose[:, :3, :3]

    def stacked(first: Array, middle: Array, last: Array) -> Array:
        rate, bend = (last - first) / (2 * h), (last - 2 * middle + first) / h**2
        turn, turning = own(R, middle[:, 3:]), own(R, rate[:, 3:])
        d_a = own(R, bend[:, :3]) - _cross(turn, now.a)
        d_dw = own(R, bend[:, 3:]) + _cross(turning, now.w)
        return np.concatenate([d_a, turning, d_dw], axis=1)

    return MotionDerivatives(
        stacked(before.by_joint, here.by_joint, after.by_joint),
        stacked(before.by_parameter, here.by_parameter, after.by_parameter),
    )


def own(R: Array, v: Array) -> Array:
    """R^T v: rotations (n, 3, 3), vectors (n, 3) or many of them (n, 3, m)."""
    return np.asarray(np.einsum("nji,nj...->ni...", R, v))


def _cross(turns: Array, v: Array) -> Array:
    """t x v: (n, 3, m), (n, 3) -> (n, 3, m)."""
    return np.asarray(np.cross(turns, v[:, :, None], axis=1))
