"""Compiled kinematics: the only loops over joints, written as the mathematics reads.

A path from frame a to frame b of the tree goes up by inverse transforms to the node where both
branches meet and down by direct ones (Hersch et al. 2008, Fig. 6). Node k hangs on its parent by

    T_parent_k(theta) = P_k M_k(theta),   P_k the placement of the joint frame,
    M_k = rotation by theta about axis a_k (revolute), shift by theta a_k (prismatic), or 1 (fixed).

Every derivative of T_a_b is a twist (v, w), linear before angular, expressed in frame a and acting
at the origin of b: d p_b = v, d R_a_b = [w]x R_a_b. A change at a node that is climbed moves a, not
b, so its twist has the opposite sign.

Transforms, vectors and twists are tuples on the way: the compiler keeps them in registers, where
small arrays would be allocated anew at every node of every row.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.compiled import inlined, step
from bodyschema.model.compiled import kernel as kernel
from bodyschema.model.rigid import (
    IDENTITY,
    Rigid,
    Twist,
    Vector,
    product,
    quotient,
    read,
    rotated,
    shifting,
    turning,
    vector,
    write,
)

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

FIXED, REVOLUTE, PRISMATIC = 0, 1, 2
OFFSET, GEAR, AXIS, LINK, TURN = 0, 1, 2, 3, 4
PART = 5
"""Codes from here on belong to parts of the model that move no frame: kernels leave zeros."""


@step
def motion(kind: int, axis: Vector, theta: float, sine: float, cosine: float) -> Rigid:
    """M(theta) of one joint. Rodrigues: R = c 1 + s [a]x + (1 - c) a a^T."""
    x, y, z = axis
    s, c, u = sine, cosine, 1.0 - cosine
    shift = theta if kind == PRISMATIC else 0.0
    return (
        c + u * x * x, u * x * y - s * z, u * x * z + s * y, shift * x,
        u * y * x + s * z, c + u * y * y, u * y * z - s * x, shift * y,
        u * z * x - s * y, u * z * y + s * x, c + u * z * z, shift * z,
    )  # fmt: skip


@step
def angle(kind: int, theta: float) -> tuple[float, float]:
    """Sine and cosine of the turn of a joint; only revolute joints turn."""
    return (np.sin(theta), np.cos(theta)) if kind == REVOLUTE else (0.0, 1.0)


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
    for n in range(theta.shape[0]):
        for k in range(parent.shape[0]):
            sine, cosine = angle(kind[k], theta[n, k])
            moved = motion(kind[k], vector(axis[k]), theta[n, k], sine, cosine)
            joint = product(read(placement[k]), moved)
            if parent[k] >= 0:
                joint = product(read(out[n, parent[k]]), joint)
            write(joint, out[n, k])


@step
def walk(
    path: Ints,
    climbed: int,
    kind: Ints,
    axis: Array,
    placement: Array,
    theta: Array,
    turn: Array,
    joint: Array,
    before: Array,
    out: Array,
) -> None:
    """Go from a to b: out = T_a_b; for path node i, turn[i] is the sine and cosine of its angle,
    joint[i] and before[i] are the joint frame and the parent frame, seen from a. The first
    `climbed` nodes go up, the others down."""
    here = IDENTITY
    for i in range(path.shape[0]):
        k = path[i]
        sine, cosine = angle(kind[k], theta[k])
        turn[i, 0], turn[i, 1] = sine, cosine
        moved = motion(kind[k], vector(axis[k]), theta[k], sine, cosine)
        placed = read(placement[k])
        if i < climbed:
            there = quotient(here, moved)
            here = quotient(there, placed)
            write(here, before[i])
        else:
            write(here, before[i])
            there = product(here, placed)
            here = product(there, moved)
        write(there, joint[i])
    write(here, out)


@kernel
def relative_poses(
    path: Ints, climbed: int, kind: Ints, axis: Array, placement: Array, theta: Array, out: Array
) -> None:
    """T_a_b along one path: theta (n, n_frames) -> out (n, 4, 4)."""
    steps = path.shape[0]
    turn, joint, before = np.empty((steps, 2)), np.empty((steps, 4, 4)), np.empty((steps, 4, 4))
    for n in range(theta.shape[0]):
        walk(path, climbed, kind, axis, placement, theta[n], turn, joint, before, out[n])


@step
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
    for i in range(path.shape[0]):
        k = path[i]
        if driver[k] < 0:
            continue
        there = read(joint[i])
        z = rotated(there, vector(axis[k]))
        twist = turning(z, there, read(tip)) if kind[k] == REVOLUTE else shifting(z)
        sign = -rate[k] if i < climbed else rate[k]
        for r in range(6):
            out[r, driver[k]] += sign * twist[r]


@inlined
def parameter_twist(
    code: int,
    direction: Vector,
    kind: int,
    axis: Vector,
    theta: float,
    sine: float,
    cosine: float,
    joint: Rigid,
    before: Rigid,
    tip: Rigid,
) -> Twist:
    """Twist of one geometric parameter of a node that lies on a downward path.

    AXIS: exp(theta [a + d]x) exp(-theta [a]x) turns by s d + (1 - c) a x d when d is normal to a.
    """
    x, y, z = direction
    if code == LINK:
        return shifting(rotated(before, direction))
    if code == TURN:
        return turning(rotated(joint, direction), joint, tip)
    if kind == PRISMATIC:
        v = rotated(joint, direction)
        return shifting((theta * v[0], theta * v[1], theta * v[2]))
    s, u = sine, 1.0 - cosine
    a, b, c = axis
    local = s * x + u * (b * z - c * y), s * y + u * (c * x - a * z), s * z + u * (a * y - b * x)
    return turning(rotated(joint, local), joint, tip)


@step
def parameter_twists(
    climbed: int,
    place: Ints,
    kind: Ints,
    axis: Array,
    theta: Array,
    turn: Array,
    joint: Array,
    before: Array,
    tip: Array,
    q: Array,
    code: Ints,
    index: Ints,
    direction: Array,
    by_joint: Array,
    out: Array,
) -> None:
    """d T_a_b / d x of one configuration, out (6, n_parameters); place[k] is where node k stands
    on the path, -1 when it does not."""
    for p in range(code.shape[0]):
        if code[p] >= PART:
            continue
        k = index[p]
        if code[p] == OFFSET or code[p] == GEAR:
            scale = 1.0 if code[p] == OFFSET else q[k]
            for r in range(6):
                out[r, p] = scale * by_joint[r, k]
            continue
        i = place[k]
        if i < 0:
            continue
        twist = parameter_twist(
            code[p], vector(direction[p]), kind[k], vector(axis[k]), theta[k],
            turn[i, 0], turn[i, 1], read(joint[i]), read(before[i]), read(tip),
        )  # fmt: skip
        sign = -1.0 if i < climbed else 1.0
        for r in range(6):
            out[r, p] = sign * twist[r]


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
    turn, joint, before = np.empty((steps, 2)), np.empty((steps, 4, 4)), np.empty((steps, 4, 4))
    place = np.full(kind.shape[0], -1)
    for i in range(steps):
        place[path[i]] = i
    for n in range(theta.shape[0]):
        walk(path, climbed, kind, axis, placement, theta[n], turn, joint, before, pose[n])
        joint_twists(path, climbed, kind, axis, joint, pose[n], driver, rate, by_joint[n])
        parameter_twists(
            climbed, place, kind, axis, theta[n], turn, joint, before, pose[n],
            q[n], code, index, direction, by_joint[n], by_parameter[n],
        )  # fmt: skip
