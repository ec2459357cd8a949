"""The zero-posture form against 4x4 kinematics, and its gradient against finite differences."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.model.kernels import FIXED, PRISMATIC, REVOLUTE
from bodyschema.model.kinematics import path_between, relative_pose
from bodyschema.model.skeleton import Skeleton, pull_back, walk_in, zero_rotations
from bodyschema.model.tree import Body


def random_tree(rng: np.random.Generator, n: int = 12) -> Body:
    """A tree with all kinds of joints and frames turned at zero posture."""
    kind = rng.choice([FIXED, REVOLUTE, REVOLUTE, PRISMATIC], size=n)
    kind[0] = FIXED
    parent = [-1, *(int(rng.integers(max(0, k - 3), k)) for k in range(1, n))]
    axis = rng.normal(size=(n, 3))
    placement = lie.transform(lie.exp_so3(rng.normal(size=(n, 3))), rng.normal(size=(n, 3)))
    placement[0] = np.eye(4)
    return Body.build(
        name="tree",
        frames=[f"f{k}" for k in range(n)],
        carriers=["", *(f"j{k}" for k in range(1, n))],
        parent=parent,
        kind=kind.tolist(),
        axis=axis / np.linalg.norm(axis, axis=1, keepdims=True),
        placement=placement,
    )


def node_values(body: Body, q: np.ndarray) -> np.ndarray:
    theta = np.zeros((len(q), len(body.frames)))
    moved = body.driver >= 0
    theta[:, moved] = q[:, body.driver[moved]]
    return theta


@pytest.mark.parametrize("seed", range(8))
def test_any_node_seen_from_any_node_as_in_4x4_kinematics(seed: int) -> None:
    rng = np.random.default_rng(seed)
    body = random_tree(rng)
    a, b = rng.choice(12, size=2, replace=False)
    q = rng.uniform(-2, 2, (5, len(body.joints)))
    v = rng.normal(size=(5, 3))
    T_a_b = relative_pose(body, q, f"f{a}", f"f{b}")
    expected = np.einsum("nij,nj->ni", T_a_b[:, :3, :3], v) + T_a_b[:, :3, 3]
    R0 = zero_rotations(body)
    path, climbed = path_between(body, f"f{a}", f"f{b}")
    seen = Skeleton.of(body).predict(path, climbed, node_values(body, q), v @ R0[b].T)
    np.testing.assert_allclose(seen @ R0[a], expected, atol=1e-13)


def test_a_skeleton_goes_back_into_its_body() -> None:
    body = random_tree(np.random.default_rng(3))
    again = Skeleton.of(body).into(body)
    np.testing.assert_allclose(again.axis, body.axis, atol=1e-14)
    np.testing.assert_allclose(again.placement, body.placement, atol=1e-14)


@pytest.mark.parametrize("seed", range(8))
def test_gradient_against_finite_differences(seed: int) -> None:
    rng = np.random.default_rng(seed)
    body = random_tree(rng)
    a, b = rng.choice(12, size=2, replace=False)
    path, climbed = path_between(body, f"f{a}", f"f{b}")
    skeleton = Skeleton.of(body)
    theta = node_values(body, rng.uniform(-2, 2, (1, len(body.joints))))[0]
    v, g = rng.normal(size=3), rng.normal(size=3)
    levers, seen = np.empty((len(path), 3)), np.empty(3)

    def value(axes: np.ndarray, links: np.ndarray) -> float:
        walk_in(path, climbed, body.kind, axes, links, theta, v, levers, seen)
        return float(g @ seen)

    axes, links = skeleton.axes, skeleton.links
    value(axes, links)
    by_axis, by_link = np.zeros((12, 3)), np.zeros((12, 3))
    pull_back(path, climbed, body.kind, axes, links, theta, levers, g.copy(), by_axis, by_link)
    h = 1e-6
    for k in path:
        for j in range(3):
            step = np.zeros((12, 3))
            step[k, j] = h
            turns = (value(axes + step, links) - value(axes - step, links)) / (2 * h)
            moves = (value(axes, links + step) - value(axes, links - step)) / (2 * h)
            if body.kind[k] != FIXED:
                assert by_axis[k, j] == pytest.approx(turns, abs=2e-8)
            assert by_link[k, j] == pytest.approx(moves, abs=2e-8)
