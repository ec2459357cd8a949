"""Poses: the sign of the residual, its derivative far from zero, selection, and refusals."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, join
from bodyschema.senses.poses import Poses
from bodyschema.senses.sense import concatenate

Array = NDArray[np.float64]

properties = settings(derandomize=True, deadline=None, database=None, max_examples=40)


@pytest.fixture(scope="module")
def body() -> Body:
    return Body.random_chain(3, np.random.default_rng(0)).attach("camera", "base")


@pytest.fixture(scope="module")
def poses(body: Body) -> Poses:
    q = np.random.default_rng(1).uniform(-1, 1, (4, 3))
    return Poses.make(q, relative_pose(body, q, "camera", "tip"), "camera", "tip", (2e-3, 1e-2))


def test_the_residual_is_what_turns_and_shifts_the_prediction(body: Body, poses: Poses) -> None:
    shift, turn = np.array([0.01, 0.02, 0.03]), np.array([0.3, -0.2, 0.1])
    seen = poses.pose.copy()
    seen[:, :3, :3] = lie.exp_so3(turn) @ seen[:, :3, :3]
    seen[:, :3, 3] += shift
    moved = Poses.make(poses.q, seen, "camera", "tip")
    expected = np.tile([*shift, *turn], (4, 1))
    assert moved.residual(body) == pytest.approx(expected, abs=1e-14)


@pytest.fixture(scope="module")
def variables(body: Body) -> Variables:
    return join(free_joints(body), free_frame(body, "camera"), free_frame(body, "tip"))


@properties
@given(st.floats(0, 3.0), st.integers(0, 1000))
def test_derivative_at_large_rotation_errors(
    body: Body, poses: Poses, variables: Variables, angle: float, seed: int
) -> None:
    direction = np.random.default_rng(seed).normal(size=3)
    turn = lie.exp_so3(angle * direction / np.linalg.norm(direction))
    seen = poses.pose.copy()
    seen[:, :3, :3] = turn @ seen[:, :3, :3]
    wrong, x, step = Poses.make(poses.q, seen, "camera", "tip"), np.zeros(len(variables)), 1e-6
    by_parameter = wrong.linearize(body, variables, x).by_parameter
    for i in range(len(variables)):
        d = step * (np.arange(len(variables)) == i)
        forth = wrong.residual(body.with_variables(variables, x + d))
        back = wrong.residual(body.with_variables(variables, x - d))
        assert by_parameter[:, :, i] == pytest.approx((forth - back) / (2 * step), abs=1e-7)


def test_what_make_fills_in(poses: Poses) -> None:
    assert poses.time.tolist() == poses.rows.tolist() == [0, 1, 2, 3]
    assert np.diag(poses.covariance) == pytest.approx([4e-6] * 3 + [1e-4] * 3)
    one = Poses.make([0.1, 0.2, 0.3], np.eye(4), "base", "tip")
    assert (len(one), one.q.shape, one.pose.shape) == (1, (1, 3), (1, 4, 4))


def test_take_and_concatenate(body: Body, poses: Poses) -> None:
    both = concatenate([poses.take([3]), poses.take(np.arange(4) < 2)])
    assert isinstance(both, Poses)
    assert both.rows.tolist() == [3, 0, 1]
    assert (both.pose == poses.pose[[3, 0, 1]]).all()
    none = poses.take([])
    assert none.residual(body).shape == (0, 6)
    assert len(concatenate([none, poses])) == 4


def spoil(poses: Poses, row: int, change: Array) -> Array:
    seen = poses.pose.copy()
    seen[row] = change
    return seen


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        (np.diag([2.0, 1, 1, 1]), "rotation in row 12 is no rotation matrix .*orthonormal"),
        (np.diag([1.0, 1, -1, 1]), "rotation in row 12 is no rotation matrix .*right-handed"),
        (np.zeros((4, 4)), "rotation in row 12 is no rotation matrix"),
        (np.full((4, 4), np.nan), "seen is not a finite number in row 12; drop the 1 bad rows"),
        (np.eye(4) + np.eye(4, k=-3), "last row of the pose in row 12 is not 0 0 0 1; give T row"),
    ],
    ids=["scaled", "left-handed", "zero", "nan", "transposed"],
)
def test_what_is_no_pose_is_refused_with_its_row(poses: Poses, wrong: Array, message: str) -> None:
    with pytest.raises(InputError, match=f"tip seen from camera: .*{message}"):
        Poses.make(poses.q, spoil(poses, 2, wrong), "camera", "tip", rows=np.arange(10, 14))


def test_rounded_rotations_are_accepted(body: Body, poses: Poses) -> None:
    """Files with four decimals are rotations enough; the error stays as small as the rounding."""
    rounded = Poses.make(poses.q, poses.pose.round(4), "camera", "tip")
    assert np.abs(rounded.residual(body)).max() < 1e-4


def test_counts_must_agree(poses: Poses) -> None:
    with pytest.raises(InputError, match=r"seen should have shape \(4, 4, 4\), it has \(3, 4, 4\)"):
        Poses.make(poses.q, poses.pose[:3], "camera", "tip")
