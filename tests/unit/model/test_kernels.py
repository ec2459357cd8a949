"""The compiled kinematics against the same mathematics written with matrices."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.kernels import AXIS, FIXED, GEAR, LINK, OFFSET, PRISMATIC, REVOLUTE, TURN
from bodyschema.model.kinematics import path_between, relative_pose, relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, join

Array = NDArray[np.float64]


def tree(rng: np.random.Generator) -> Body:
    """Two branches with every kind of joint, and one joint that follows another."""
    parent = [-1, 0, 1, 2, 1, 4, 5, 6, 7]
    kind = [FIXED, REVOLUTE, PRISMATIC, FIXED, REVOLUTE, REVOLUTE, PRISMATIC, REVOLUTE, FIXED]
    n = len(parent)
    axis = rng.normal(size=(n, 3))
    placement = lie.transform(lie.exp_so3(rng.normal(size=(n, 3))), rng.normal(size=(n, 3)))
    return Body.build(
        name="tree",
        frames=["base", *(f"f{k}" for k in range(1, n))],
        carriers=["", *(f"j{k}" for k in range(1, n))],
        parent=parent,
        kind=kind,
        axis=axis / np.linalg.norm(axis, axis=1, keepdims=True),
        placement=placement,
        mimics={"j7": ("j5", -0.7, 0.2)},
    )


def motion(body: Body, k: int, theta: float) -> Array:
    """M_k(theta)."""
    if body.kind[k] == REVOLUTE:
        return lie.transform(lie.exp_so3(theta * body.axis[k]), np.zeros(3))
    shift = theta if body.kind[k] == PRISMATIC else 0.0
    return lie.transform(np.eye(3), shift * body.axis[k])


def twist(w: Array, joint: Array, tip: Array) -> Array:
    """Of a turn by w about a line through the joint."""
    return np.concatenate([np.cross(w, tip[:3, 3] - joint[:3, 3]), w])


def derivatives(
    body: Body, direction: Array, free: Variables, q: Array, a: str, b: str
) -> tuple[Array, Array, Array]:
    """T_a_b, its twists by the joint values (6, n_joints) and by the parameters, of one posture."""
    value = (1 + body.gear) * q + body.offset
    path, climbed = path_between(body, a, b)
    theta = {k: body.rate[k] * value[body.driver[k]] + body.shift[k] for k in path.tolist()}
    here, joint, before = np.eye(4), {}, {}
    for i, k in enumerate(path.tolist()):
        moved = motion(body, k, theta[k] if body.driver[k] >= 0 else 0.0)
        if i < climbed:
            joint[k] = here @ lie.inverse(moved)
            here = before[k] = joint[k] @ lie.inverse(body.placement[k])
        else:
            before[k] = here
            joint[k] = here @ body.placement[k]
            here = joint[k] @ moved
    sign = {k: -1.0 if i < climbed else 1.0 for i, k in enumerate(path.tolist())}
    by_joint, by_parameter = np.zeros((6, len(q))), np.zeros((6, len(free)))
    for k in path.tolist():
        if body.driver[k] >= 0:
            z = joint[k][:3, :3] @ body.axis[k]
            turns = body.kind[k] == REVOLUTE
            along = twist(z, joint[k], here) if turns else np.concatenate([z, np.zeros(3)])
            by_joint[:, body.driver[k]] += sign[k] * body.rate[k] * along
    for p in range(len(free)):
        k, d = int(free.index[p]), direction[p]
        if free.code[p] in (OFFSET, GEAR):
            by_parameter[:, p] = by_joint[:, k] * (q[k] if free.code[p] == GEAR else 1.0)
        elif k in joint and free.code[p] == LINK:
            by_parameter[:3, p] = sign[k] * before[k][:3, :3] @ d
        elif k in joint and free.code[p] == TURN:
            by_parameter[:, p] = sign[k] * twist(joint[k][:3, :3] @ d, joint[k], here)
        elif k in joint and body.kind[k] == PRISMATIC:
            by_parameter[:3, p] = sign[k] * theta[k] * joint[k][:3, :3] @ d
        elif k in joint and free.code[p] == AXIS:
            s, u = np.sin(theta[k]), 1 - np.cos(theta[k])
            w = joint[k][:3, :3] @ (s * d + u * np.cross(body.axis[k], d))
            by_parameter[:, p] = sign[k] * twist(w, joint[k], here)
    return here, by_joint, by_parameter


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("a", "b"), [("base", "f8"), ("f8", "base"), ("f3", "f8"), ("f7", "f3")])
def test_equal_to_matrices(seed: int, a: str, b: str) -> None:
    rng = np.random.default_rng(seed)
    body = tree(rng)
    free = join(free_joints(body), free_frame(body, "f3"), free_frame(body, "f8"))
    x, q = rng.uniform(-0.4, 0.4, len(free)), rng.uniform(-2, 2, (4, len(body.joints)))
    worn, direction = body.deviate(free, x)
    D = relative_pose_derivatives(body, free, x, q, a, b)
    assert (relative_pose(worn, q, a, b) == D.pose).all()
    for n in range(len(q)):
        pose, by_joint, by_parameter = derivatives(worn, direction, free, q[n], a, b)
        assert np.abs(D.pose[n] - pose).max() < 1e-13
        assert np.abs(D.by_joint[n] - by_joint * (1 + worn.gear)).max() < 1e-13
        assert np.abs(D.by_parameter[n] - by_parameter).max() < 1e-13
