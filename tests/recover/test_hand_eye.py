"""Hand-eye calibration finds a known truth, inside its own bounds, and says when it cannot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.learners.hand_eye import pose_pairs
from bodyschema.learners.hand_eye.full_poses import Mount, solve_hand_eye
from bodyschema.learners.hand_eye.pose_pairs import PairFit, jacobian, residual
from bodyschema.learners.hand_eye.pose_streams import interpolate, join_streams
from simulated import random_pose, random_poses

Array = np.ndarray


def seen_pairs(
    rng: np.random.Generator, hand: Array, eye_on: Mount = "hand", noise: float = 1e-3
) -> tuple[Array, Array, Array]:
    """X and the poses T_eye_target that an eye with noise sees."""
    X, Y = random_pose(rng, 0.1), random_pose(rng, 1.0)
    B = lie.inverse(Y) @ hand @ X
    T = lie.inverse(B) if eye_on == "hand" else B
    turn = lie.exp_so3(2 * noise * rng.normal(size=(len(T), 3)))
    shift = T[:, :3, 3] + noise * rng.normal(size=(len(T), 3))
    return X, Y, lie.transform(turn @ T[:, :3, :3], shift)


@pytest.mark.parametrize("inverted", [False, True])
def test_derivative_against_finite_differences(inverted: bool) -> None:
    rng = np.random.default_rng(0)
    A, X, Y = random_poses(6, rng), random_pose(rng), random_pose(rng)
    B = lie.inverse(Y) @ A @ X
    exact = PairFit(X, Y, 1.2, inverted, np.eye(6), 0.1, np.ones(6), np.zeros((13, 13)), 0.0)
    _, P = residual(A, B, exact)
    expected = jacobian(P, exact, free_scale=True)
    for k in range(13):
        step = np.zeros(13)
        step[k] = 1e-6
        ahead = residual(A, B, pose_pairs._moved(exact, step))[0]
        behind = residual(A, B, pose_pairs._moved(exact, -step))[0]
        np.testing.assert_allclose(expected[:, :, k], (ahead - behind) / 2e-6, atol=1e-8)


@pytest.mark.parametrize("eye_on", ["hand", "base"])
def test_errors_stay_within_the_stated_covariance(eye_on: Mount) -> None:
    squared = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        A = random_poses(30, rng)
        X, Y, T = seen_pairs(rng, A, eye_on)
        answer = solve_hand_eye(A, T, eye_on)
        assert answer.scale == 1
        twist = np.concatenate([_twist(answer.X, X), _twist(answer.Y, Y)])
        squared.append(twist @ np.linalg.solve(answer.covariance, twist))
    # 12 runs of 12 degrees of freedom: mean 12, standard deviation of the mean 1.41.
    assert 12 - 3 * 1.41 < np.mean(squared) < 12 + 4 * 1.41


def _twist(found: Array, true: Array) -> Array:
    E = lie.inverse(found) @ true
    return np.concatenate([E[:3, 3], lie.log_so3(E[:3, :3])])


def test_half_of_the_pairs_may_be_wrong() -> None:
    rng = np.random.default_rng(1)
    A = random_poses(40, rng)
    X, _, T = seen_pairs(rng, A)
    T[:20] = random_poses(20, rng)
    answer = solve_hand_eye(A, T)
    assert np.linalg.norm(answer.X[:3, 3] - X[:3, 3]) < 2e-3
    assert np.all(answer.weights[:20] < 0.5)
    assert np.mean(answer.weights[20:] > 0.5) > 0.8


def test_one_axis_of_motion_is_named() -> None:
    rng = np.random.default_rng(2)
    axis = np.array([0.0, 0.6, 0.8])
    turns = lie.exp_so3(rng.uniform(-1.5, 1.5, (30, 1)) * axis)
    A = lie.transform(turns, rng.normal(size=(30, 3)))
    _, _, T = seen_pairs(rng, A)
    answer = solve_hand_eye(A, T)
    assert not answer.determined
    assert abs(answer.uncertain_axis @ axis) > 0.99
    assert "+0.60, +0.80" in answer.verdict


def test_scale_of_a_single_moving_camera() -> None:
    rng = np.random.default_rng(3)
    A = random_poses(40, rng)
    X, _, T = seen_pairs(rng, A, noise=5e-4)
    T[:, :3, 3] *= 2.5
    answer = solve_hand_eye(A, T)
    assert "2.5" in answer.verdict
    assert answer.scale == pytest.approx(2.5, rel=5e-3)
    assert np.linalg.norm(answer.X[:3, 3] - X[:3, 3]) < 3e-3


def test_bad_input_is_refused() -> None:
    rng = np.random.default_rng(4)
    A = random_poses(10, rng)
    with pytest.raises(InputError, match="9 target poses"):
        solve_hand_eye(A, A[:9])
    with pytest.raises(InputError, match="record at least 10"):
        solve_hand_eye(A[:2], A[:2])
    still = lie.transform(np.tile(np.eye(3), (10, 1, 1)), rng.normal(size=(10, 3)))
    with pytest.raises(InputError, match="without turning"):
        solve_hand_eye(still, A)
    broken = A.copy()
    broken[3, 0, 0] = np.nan
    with pytest.raises(InputError, match="row 3"):
        solve_hand_eye(broken, A)


def test_streams_with_clocks_of_their_own() -> None:
    rng = np.random.default_rng(5)
    knots = np.arange(0.0, 31.0)
    way = lie.transform(lie.exp_so3(0.5 * rng.normal(size=(31, 3))), rng.normal(size=(31, 3)) * 0.2)
    fine = np.arange(0.0, 30.0, 0.01)
    hand = interpolate(knots, way, fine)
    seen_at = np.arange(0.5, 29.0, 0.04)
    X, _, T = seen_pairs(rng, interpolate(fine, hand, seen_at), noise=1e-3)
    found = join_streams(fine, hand, seen_at - 0.137 + 1000.0, T)
    assert found.lag == pytest.approx(0.137 - 1000.0, abs=4 * found.lag_std)
    assert found.lag_std < 1e-3
    assert np.linalg.norm(found.hand_eye.X[:3, 3] - X[:3, 3]) < 1e-3
    with pytest.raises(InputError, match="do not increase"):
        join_streams(fine[::-1], hand, seen_at, T)


def test_a_changed_noise_level_is_found() -> None:
    rng = np.random.default_rng(6)
    A = random_poses(200, rng)
    _, _, T = seen_pairs(rng, A, "base", noise=2e-3)
    answer = solve_hand_eye(A, T, "base")
    assert np.sqrt(np.diag(answer.noise)[:3]) == pytest.approx(2e-3 * np.ones(3), rel=0.3)
    again = replace(answer, accepted_std=1e-6)
    assert not again.determined
