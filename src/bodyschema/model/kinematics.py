"""Forward kinematics: poses and their derivatives, for one configuration or for batches.

All functions accept q of shape (*batch, n_joints): encoder readings in the order of `body.joints`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.model import kernels
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

NOTHING, NOWHERE = np.empty(0, np.int64), np.empty((0, 3))
"""Codes, indices and directions of no parameters."""


@dataclass(frozen=True)
class PoseDerivatives:
    """A relative pose with its derivatives.

    Derivatives are twists (linear, angular) in frame a at the origin of b, so that for a change d
    d p_a = D[:3] d and d R_a_b = [D[3:] d]x R_a_b.
    """

    pose: Array
    """(*batch, 4, 4) T_a_b."""
    by_joint: Array
    """(*batch, 6, n_joints), with respect to the encoder readings q."""
    by_parameter: Array
    """(*batch, 6, n_parameters)."""


def frame_poses(body: Body, q: ArrayLike) -> Array:
    """Pose of every frame in the root frame: (*batch, n_joints) -> (*batch, n_frames, 4, 4)."""
    theta, _, batch = _joint_values(body, q)
    out = np.empty((len(theta), len(body.frames), 4, 4))
    kernels.tree_poses(body.parent, body.kind, body.axis, body.placement, theta, out)
    return out.reshape(*batch, len(body.frames), 4, 4)


def relative_pose(body: Body, q: ArrayLike, a: str, b: str) -> Array:
    """T_a_b between any two frames of the tree: (*batch, n_joints) -> (*batch, 4, 4)."""
    theta, _, batch = _joint_values(body, q)
    path, climbed = path_between(body, a, b)
    out = np.empty((len(theta), 4, 4))
    kernels.relative_poses(path, climbed, body.kind, body.axis, body.placement, theta, out)
    return out.reshape(*batch, 4, 4)


def relative_pose_derivatives(
    reference: Body, variables: Variables, x: ArrayLike, q: ArrayLike, a: str, b: str
) -> PoseDerivatives:
    """T_a_b of the body that deviates from the reference by x, with its derivatives.

    Args:
        reference: the body round which the parameters are charted.
        variables: what may be wrong with it.
        x: (n_parameters,) deviations.
        q: (*batch, n_joints) encoder readings.
        a: the frame that looks.
        b: the frame that is looked at.
    """
    body, direction = reference.deviate(variables, x)
    return _derivatives(body, q, a, b, variables.code, variables.index, direction)


def frame_jacobian(body: Body, q: ArrayLike, a: str, b: str) -> Array:
    """Geometric Jacobian of T_a_b with respect to q, (*batch, 6, n_joints), in frame a at b."""
    return _derivatives(body, q, a, b, NOTHING, NOTHING, NOWHERE).by_joint


def _derivatives(
    body: Body, q: ArrayLike, a: str, b: str, code: Ints, index: Ints, direction: Array
) -> PoseDerivatives:
    """Of a body by the joints and by parameters that the arrays describe; see `kernels`."""
    theta, readings, batch = _joint_values(body, q)
    path, climbed = path_between(body, a, b)
    n = len(theta)
    pose = np.empty((n, 4, 4))
    by_joint = np.zeros((n, 6, len(body.joints)))
    by_parameter = np.zeros((n, 6, len(code)))
    kernels.relative_pose_derivatives(
        path, climbed, body.kind, body.axis, body.placement, body.driver, body.rate,
        theta, readings, code, index, direction, pose, by_joint, by_parameter,
    )  # fmt: skip
    by_joint *= 1 + body.gear
    return PoseDerivatives(
        pose.reshape(*batch, 4, 4),
        by_joint.reshape(*batch, 6, len(body.joints)),
        by_parameter.reshape(*batch, 6, len(code)),
    )


def path_between(body: Body, a: str, b: str) -> tuple[Ints, int]:
    """Nodes from a up to the meeting node (left out) and down to b, and how many go up."""
    return _path(body.parent.tobytes(), body.frame_index(a), body.frame_index(b))


@lru_cache(maxsize=1024)
def _path(parents: bytes, a: int, b: int) -> tuple[Ints, int]:
    parent = np.frombuffer(parents, dtype=np.int64).tolist()
    above_a, above_b = _line(parent, a), _line(parent, b)
    while above_a and above_b and above_a[-1] == above_b[-1]:
        above_a, above_b = above_a[:-1], above_b[:-1]
    path = np.array([*above_a, *reversed(above_b)], dtype=np.int64)
    path.setflags(write=False)
    return path, len(above_a)


def _line(parent: Sequence[int], node: int) -> list[int]:
    """The node and everything above it but the root, which has no joint."""
    line = []
    while parent[node] >= 0:
        line.append(node)
        node = parent[node]
    return line


def _joint_values(body: Body, q: ArrayLike) -> tuple[Array, Array, tuple[int, ...]]:
    """Joint values at the nodes (n, n_frames), the readings (n, n_joints), the batch shape."""
    readings = np.asarray(q, dtype=np.float64)
    if readings.shape[-1:] != (len(body.joints),):
        raise InputError(
            f"expected joint positions with {len(body.joints)} columns ({', '.join(body.joints)}), "
            f"got an array of shape {readings.shape}."
        )
    batch = readings.shape[:-1]
    flat = np.ascontiguousarray(readings.reshape(math.prod(batch), len(body.joints)))
    theta = np.zeros((len(flat), len(body.frames)))
    kernels.joint_values(flat, body.gear, body.offset, body.driver, body.rate, body.shift, theta)
    return theta, flat, batch
