"""Compiled kinematics: the only loops over joints, written as the mathematics reads.

A path from frame a to frame b of the tree goes up by inverse transforms to the node where both
branches meet and down by direct ones (Hersch et al. 2008, Fig. 6). Node k hangs on its parent by

    T_parent_k(theta) = P_k M_k(theta),   P_k the placement of the joint frame,
    M_k = rotation by theta about axis a_k (revolute), shift by theta a_k (prismatic), or 1 (fixed).

Every derivative of T_a_b is a twist (v, w), linear before angular, expressed in frame a and acting
at the origin of b: d p_b = v, d R_a_b = [w]x R_a_b. A change at a node that is climbed moves a, not
b, so its twist has the opposite sign.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

FIXED, REVOLUTE, PRISMATIC = 0, 1, 2
OFFSET, GEAR, AXIS, LINK, TURN = 0, 1, 2, 3, 4
PART = 5
"""Codes from here on belong to parts of the model that move no frame: kernels leave zeros."""


def kernel(function: Any) -> Any:
    """Compile once, cache on disk, and let other Python threads run meanwhile."""
    return njit(cache=True, nogil=True, error_model="numpy")(function)


@kernel
def multiply(A: Array, B: Array, out: Array) -> None:
    """out = A B for rigid 4x4 transforms (last row 0 0 0 1)."""
    for i in range(3):
        for j in range(4):
            out[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]
        out[i, 3] += A[i, 3]
    out[3, 0] = out[3, 1] = out[3, 2] = 0.0
    out[3, 3] = 1.0


@kernel
def multiply_inverse(A: Array, B: Array, out: Array) -> None:
    """out = A B^-1 for rigid 4x4 transforms."""
    for i in range(3):
        for j in range(3):
            out[i, j] = A[i, 0] * B[j, 0] + A[i, 1] * B[j, 1] + A[i, 2] * B[j, 2]
        out[i, 3] = A[i, 3] - out[i, 0] * B[0, 3] - out[i, 1] * B[1, 3] - out[i, 2] * B[2, 3]
    out[3, 0] = out[3, 1] = out[3, 2] = 0.0
    out[3, 3] = 1.0


@kernel
def motion(kind: int, axis: Array, theta: float, out: Array) -> None:
    """M(theta) of one joint. Rodrigues: R = c 1 + s [a]x + (1 - c) a a^T."""
    x, y, z = axis[0], axis[1], axis[2]
    c, s, shift = 1.0, 0.0, 0.0
    if kind == REVOLUTE:
        c, s = np.cos(theta), np.sin(theta)
    elif kind == PRISMATIC:
        shift = theta
    u = 1.0 - c
    out[0, 0], out[0, 1], out[0, 2] = c + u * x * x, u * x * y - s * z, u * x * z + s * y
    out[1, 0], out[1, 1], out[1, 2] = u * y * x + s * z, c + u * y * y, u * y * z - s * x
    out[2, 0], out[2, 1], out[2, 2] = u * z * x - s * y, u * z * y + s * x, c + u * z * z
    out[0, 3], out[1, 3], out[2, 3] = shift * x, shift * y, shift * z
    out[3, 0] = out[3, 1] = out[3, 2] = 0.0
    out[3, 3] = 1.0


@kernel
def joint_values(
    q: Array, gear: Array, offset: Array, driver: Ints, rate: Array, shift: Array, theta: Array
) -> None:
    """theta_k = rate_k ((1 + gear_j) q_j + offset_j) + shift_k: q (n, n_joints) -> theta."""
    for n in range(q.shape[0]):
        for k in range(driver.shape[0]):
            j = driver[k]
            if j >= 0:
                theta[n, k] = rate[k] * ((1.0 + gear[j]) * q[n, j] + offset[j]) + shift[k]


@kernel
def tree_poses(
    parent: Ints, kind: Ints, axis: Array, placement: Array, theta: Array, out: Array
) -> None:
    """Pose of every frame in the root: theta (n, n_frames) -> out (n, n_frames, 4, 4)."""
    joint, moved = np.empty((4, 4)), np.empty((4, 4))
    for n in range(theta.shape[0]):
        for k in range(parent.shape[0]):
            motion(kind[k], axis[k], theta[n, k], moved)
            multiply(placement[k], moved, joint)
            if parent[k] < 0:
                out[n, k] = joint
            else:
                multiply(out[n, parent[k]], joint, out[n, k])


@kernel
def walk(
    path: Ints,
    climbed: int,
    kind: Ints,
    axis: Array,
    placement: Array,
    theta: Array,
    joint: Array,
    before: Array,
    out: Array,
) -> None:
    """Go from a to b: out = T_a_b; joint[i] and before[i] are the joint frame and the parent
    frame of path node i, seen from a. The first `climbed` nodes go up, the others down."""
    moved = np.empty((4, 4))
    here, there = np.eye(4), np.empty((4, 4))
    for i in range(path.shape[0]):
        k = path[i]
        motion(kind[k], axis[k], theta[k], moved)
        if i < climbed:
            multiply_inverse(here, moved, joint[i])
            multiply_inverse(joint[i], placement[k], before[i])
            here[:] = before[i]
        else:
            before[i] = here
            multiply(here, placement[k], joint[i])
            multiply(joint[i], moved, there)
            here[:] = there
    out[:] = here


@kernel
def rotate(R: Array, v: Array, out: Array) -> None:
    """out = R v with the rotation part of a transform."""
    for i in range(3):
        out[i] = R[i, 0] * v[0] + R[i, 1] * v[1] + R[i, 2] * v[2]


@kernel
def add_turn(w: Array, origin: Array, tip: Array, scale: float, twist: Array) -> None:
    """twist += scale * (w x (tip - origin), w): a rotation about a line through the origin."""
    x, y, z = tip[0, 3] - origin[0, 3], tip[1, 3] - origin[1, 3], tip[2, 3] - origin[2, 3]
    twist[0] += scale * (w[1] * z - w[2] * y)
    twist[1] += scale * (w[2] * x - w[0] * z)
    twist[2] += scale * (w[0] * y - w[1] * x)
    for i in range(3):
        twist[3 + i] += scale * w[i]


@kernel
def relative_poses(
    path: Ints, climbed: int, kind: Ints, axis: Array, placement: Array, theta: Array, out: Array
) -> None:
    """T_a_b along one path: theta (n, n_frames) -> out (n, 4, 4)."""
    joint, before = np.empty((path.shape[0], 4, 4)), np.empty((path.shape[0], 4, 4))
    for n in range(theta.shape[0]):
        walk(path, climbed, kind, axis, placement, theta[n], joint, before, out[n])


@kernel
def joint_twists(
    path: Ints,
    climbed: int,
    kind: Ints,
    axis: Array,
    joint: Array,
    tip: Array,
    driver: Ints,
    rate: Array,
    out: Array,
) -> None:
    """Add d T_a_b / d (joint angle) to out (6, n_joints); mimicking nodes share one column."""
    z, twist = np.empty(3), np.empty(6)
    for i in range(path.shape[0]):
        k = path[i]
        if driver[k] < 0:
            continue
        twist[:] = 0.0
        rotate(joint[i], axis[k], z)
        if kind[k] == REVOLUTE:
            add_turn(z, joint[i], tip, 1.0, twist)
        else:
            twist[:3] = z
        sign = -rate[k] if i < climbed else rate[k]
        for row in range(6):
            out[row, driver[k]] += sign * twist[row]


@kernel
def parameter_twist(
    code: int,
    direction: Array,
    kind: int,
    axis: Array,
    theta: float,
    joint: Array,
    before: Array,
    tip: Array,
    twist: Array,
) -> None:
    """Twist of one geometric parameter of a node that lies on a downward path.

    AXIS: exp(theta [a + d]x) exp(-theta [a]x) turns by s d + (1 - c) a x d when d is normal to a.
    """
    w = np.empty(3)
    if code == LINK:
        rotate(before, direction, w)
        twist[:3] = w
    elif code == TURN:
        rotate(joint, direction, w)
        add_turn(w, joint, tip, 1.0, twist)
    elif kind == PRISMATIC:
        rotate(joint, direction, w)
        twist[:3] = theta * w
    else:
        d, s, u = direction, np.sin(theta), 1.0 - np.cos(theta)
        local = np.empty(3)
        local[0] = s * d[0] + u * (axis[1] * d[2] - axis[2] * d[1])
        local[1] = s * d[1] + u * (axis[2] * d[0] - axis[0] * d[2])
        local[2] = s * d[2] + u * (axis[0] * d[1] - axis[1] * d[0])
        rotate(joint, local, w)
        add_turn(w, joint, tip, 1.0, twist)


@kernel
def relative_pose_derivatives(
    path: Ints,
    climbed: int,
    kind: Ints,
    axis: Array,
    placement: Array,
    driver: Ints,
    rate: Array,
    theta: Array,
    q: Array,
    code: Ints,
    index: Ints,
    direction: Array,
    pose: Array,
    by_joint: Array,
    by_parameter: Array,
) -> None:
    """T_a_b with its derivatives for n configurations.

    theta (n, n_frames) are the joint values at the nodes, q (n, n_joints) the encoder readings;
    pose (n, 4, 4); by_joint (n, 6, n_joints), with respect to the true joint values;
    by_parameter (n, 6, n_parameters). `code`, `index` and `direction` describe the parameters:
    `index` is a joint for OFFSET and GEAR, else a node; codes from PART on are left out. The
    outputs must come in as zeros.
    """
    steps = path.shape[0]
    joint, before = np.empty((steps, 4, 4)), np.empty((steps, 4, 4))
    place = np.full(kind.shape[0], -1)
    for i in range(steps):
        place[path[i]] = i
    twist = np.empty(6)
    for n in range(theta.shape[0]):
        walk(path, climbed, kind, axis, placement, theta[n], joint, before, pose[n])
        joint_twists(path, climbed, kind, axis, joint, pose[n], driver, rate, by_joint[n])
        for p in range(code.shape[0]):
            if code[p] >= PART:
                continue
            k = index[p]
            if code[p] == OFFSET or code[p] == GEAR:
                scale = 1.0 if code[p] == OFFSET else q[n, k]
                for row in range(6):
                    by_parameter[n, row, p] = scale * by_joint[n, row, k]
                continue
            i = place[k]
            if i < 0:
                continue
            twist[:] = 0.0
            parameter_twist(
                code[p], direction[p], kind[k], axis[k], theta[n, k],
                joint[i], before[i], pose[n], twist,
            )  # fmt: skip
            sign = -1.0 if i < climbed else 1.0
            for row in range(6):
                by_parameter[n, row, p] = sign * twist[row]
