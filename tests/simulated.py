"""Simulated arms that are looked at: what the tests of learning share.

An arm of `seen_arm` is a random chain with a frame "tool" on its tip and a frame "tracker" beside
its base; `points` and `poses` look at the tool from the tracker, with noise.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, join
from bodyschema.senses.points import Points
from bodyschema.senses.poses import Poses
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Seen = TypeVar("Seen", bound=Sense)

POINT_STD = 1e-3
"""m."""

POSE_STD = (1e-3, 3e-3)
"""m and rad."""


def random_pose(rng: np.random.Generator, reach: float = 0.3) -> Array:
    """Any rotation, and a translation within +-reach (m)."""
    return lie.transform(lie.exp_so3(rng.normal(size=3)), rng.uniform(-reach, reach, 3))


def random_poses(n: int, rng: np.random.Generator) -> Array:
    """(n, 4, 4)."""
    return np.array([random_pose(rng) for _ in range(n)])


def seen_arm(n_joints: int, rng: np.random.Generator) -> Body:
    """A random arm with "tool" on its tip and "tracker" beside its base."""
    arm = Body.random_chain(n_joints, rng)
    arm = arm.attach("tracker", "base", random_pose(rng, 1.0))
    return arm.attach("tool", "tip", random_pose(rng, 0.1))


def postures(n: int, body: Body, rng: np.random.Generator, reach: float = 2.0) -> Array:
    """(n, n_joints) rad, uniform within +-reach."""
    return rng.uniform(-reach, reach, (n, len(body.joints)))


def free_all(body: Body, groups: Iterable[str] = ("offsets",), turns: bool = True) -> Variables:
    """Joint groups, the tracker's frame and the tool's, the latter with or without its turn."""
    tool = free_frame(body, "tool", 0.1, 0.2 if turns else None)
    return join(free_joints(body, groups), free_frame(body, "tracker", 0.1, 0.2), tool)


def drawn(variables: Variables, rng: np.random.Generator, scale: float = 1.0) -> Array:
    """Deviations from the prior, or from a part of it, (n_parameters,)."""
    return scale * variables.prior_std * rng.normal(size=len(variables))


def forgotten(body: Body, frames: Iterable[str]) -> Body:
    """The body with these frames at their parents' origins, as if nobody had measured them."""
    for frame in frames:
        body = body.with_placement(frame, np.eye(4))
    return body


def points(
    body: Body,
    q: Array,
    rng: np.random.Generator,
    std: float = POINT_STD,
    seen_from: str = "tracker",
    seen: str = "tool",
) -> Points:
    """Noisy positions of one frame."""
    position = relative_pose(body, q, seen_from, seen)[:, :3, 3]
    noise = std * rng.normal(size=position.shape)
    return Points.make(q, position + noise, seen_from, seen, max(std, 1e-9))


def poses(
    body: Body,
    q: Array,
    rng: np.random.Generator,
    std: tuple[float, float] = POSE_STD,
    seen_from: str = "tracker",
    seen: str = "tool",
) -> Poses:
    """Noisy poses of one frame."""
    pose = relative_pose(body, q, seen_from, seen)
    pose[:, :3, 3] += std[0] * rng.normal(size=(len(q), 3))
    pose[:, :3, :3] = lie.exp_so3(std[1] * rng.normal(size=(len(q), 3))) @ pose[:, :3, :3]
    return Poses.make(q, pose, seen_from, seen, (max(std[0], 1e-9), max(std[1], 1e-9)))


def spoiled(
    sense: Seen, share: float, size: float, rng: np.random.Generator
) -> tuple[Seen, NDArray[np.bool_]]:
    """The samples with a share of them shifted by `size` (m) in random directions, and which."""
    n = len(sense)
    bad = np.zeros(n, dtype=bool)
    bad[rng.choice(n, round(share * n), replace=False)] = True
    shift = rng.normal(size=(n, 3))
    shift *= size * bad[:, None] / np.linalg.norm(shift, axis=1, keepdims=True)
    if isinstance(sense, Points):
        return replace(sense, observed=sense.position + shift), bad
    assert isinstance(sense, Poses)
    pose = sense.pose.copy()
    pose[:, :3, 3] += shift
    return replace(sense, observed=pose), bad


def angle(R: Array, other: Array) -> float:
    """rad between two rotations or two transforms."""
    return float(np.linalg.norm(lie.log_so3(R[:3, :3] @ other[:3, :3].T)))
