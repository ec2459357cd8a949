"""Hand-eye calibration finds a known truth, inside its own bounds, and says when it cannot."""

from __future__ import annotations

from collections.abc import Callable
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
        ahead = residual(A, B, pose_pairs._moved(exact, step, True, False))[0]
        behind = residual(A, B, pose_pairs._moved(exact, -step, True, False))[0]
        np.testing.assert_allclose(expected[:, :, k], (ahead - behind) / 2e-6, atol=1e-8)


def test_derivative_of_the_lag_against_finite_differences() -> None:
    rng = np.random.default_rng(7)
    A, X, Y = random_poses(6, rng), random_pose(rng), random_pose(rng)
    twists = rng.normal(size=(6, 6))
    B = lie.inverse(Y) @ A @ X

    def later(lag: float) -> Array:
        return A @ lie.transform(lie.exp_so3(lag * twists[:, 3:]), lag * twists[:, :3])

    exact = PairFit(X, Y, 1.0, False, np.eye(6), 0.1, np.ones(6), np.zeros((13, 13)), 0.0)
    _, P = residual(A, B, exact)
    found = jacobian(P, exact, free_scale=False, twists=twists)[:, :, 12]
    ahead, behind = (residual(later(d), B, exact)[0] for d in (1e-6, -1e-6))
    np.testing.assert_allclose(found, (ahead - behind) / 2e-6, atol=1e-8)


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


def slow_way(rng: np.random.Generator, speed: float) -> Callable[[Array], Array]:
    """Poses of a hand at any time, (n, 4, 4): three waves, `speed` times 0.3 to 1 rad/s."""
    beat, phase = speed * rng.uniform(0.3, 1.0, (3, 6)), rng.uniform(0, 6.3, (3, 6))
    size = rng.normal(size=(3, 6)) / np.sqrt(3)

    def way(t: Array) -> Array:
        x = np.sum(size * np.sin(t[:, None, None] * beat + phase), axis=1)
        return lie.transform(lie.exp_so3(0.4 * x[:, :3]), 0.25 * x[:, 3:])

    return way


@pytest.mark.parametrize("eye_on", ["hand", "base"])
@pytest.mark.parametrize("lag", [-1.2, -0.05, 0.9])
def test_lag_and_frames_of_slow_motion_within_their_joint_error(eye_on: Mount, lag: float) -> None:
    rng = np.random.default_rng(11)
    way, t_hand, t_eye = slow_way(rng, 0.4), np.arange(0, 30, 0.02), np.arange(2, 28, 0.05)
    X, Y, T = seen_pairs(rng, way(t_eye + lag), eye_on)
    bad = rng.random(len(T)) < 0.15
    T[bad] = random_poses(int(bad.sum()), rng)
    found = join_streams(t_hand, way(t_hand), t_eye, T, eye_on)
    assert abs(found.lag - lag) < 3 * found.lag_std
    assert found.lag_std < 2e-3
    eye, true = (found.hand_eye.X, X) if eye_on == "hand" else (found.hand_eye.Y, Y)
    assert np.linalg.norm(eye[:3, 3] - true[:3, 3]) < 1.3 * found.hand_eye.predicted_95
    assert found.other_lags == ()
    assert not found.at_edge


def test_motion_that_repeats_itself_has_other_lags() -> None:
    rng = np.random.default_rng(12)
    t_hand, t_eye = np.arange(0, 40, 0.02), np.arange(4, 36, 0.05)

    def way(t: Array) -> Array:
        wave = np.stack([np.sin(np.pi * t), np.cos(np.pi * t), np.sin(2 * np.pi * t)], axis=1)
        return lie.transform(lie.exp_so3(0.4 * wave), 0.2 * wave)

    _, _, T = seen_pairs(rng, way(t_eye + 0.3))
    found = join_streams(t_hand, way(t_hand), t_eye, T, largest_lag=3.0)
    every = np.array([found.lag, *found.other_lags])
    # A second later it is the same motion, turned by half a turn.
    assert np.abs(every - 0.3).min() < 5e-3
    assert np.abs(every - found.lag).max() > 0.9


@pytest.mark.parametrize(("per_second", "unit"), [(1e9, "ns"), (1e6, "us"), (1e3, "ms")])
def test_stamps_in_other_units_are_recognised(per_second: float, unit: str) -> None:
    rng = np.random.default_rng(13)
    way, t = slow_way(rng, 1.0), np.arange(0, 10, 0.05)
    T = way(t)
    with pytest.raises(InputError, match=f"the hand's times .* are the times in {unit}"):
        join_streams(per_second * t, T, per_second * t, T)
    with pytest.raises(InputError, match=f"the eye's times .* are the times in {unit}"):
        join_streams(t, T, per_second * t, T)


def test_few_pairs_are_not_sure_of_themselves() -> None:
    """Three pairs once said 0.00 mm: one was taken for bad, and two explain themselves."""
    square = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        A = random_poses(3, rng)
        X, _, T = seen_pairs(rng, A)
        answer = solve_hand_eye(A, T)
        assert np.all(answer.weights == 1)
        assert answer.postures == 3
        square.append((np.linalg.norm(answer.X[:3, 3] - X[:3, 3]) / answer.predicted_95) ** 2)
    assert np.mean(np.array(square) < 1) >= 0.8
    assert np.max(square) < 4


def test_repeats_count_once() -> None:
    """Frames of one posture share what the eye gets wrong there, and copies tell nothing new."""
    inside, wider = [], []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        once = random_poses(12, rng)
        X, _, T = seen_pairs(rng, once)
        plain, hand = solve_hand_eye(once, T), np.repeat(once, 7, axis=0)
        seen = np.repeat(T, 7, axis=0)
        copied = solve_hand_eye(hand, seen)
        np.testing.assert_allclose(copied.covariance, plain.covariance)
        seen[:, :3, 3] += 1e-4 * rng.normal(size=(84, 3))
        again = solve_hand_eye(hand, seen)
        assert again.postures == 12
        inside.append(np.linalg.norm(again.X[:3, 3] - X[:3, 3]) / again.predicted_95)
        wider.append(again.largest_std / plain.largest_std)
    assert np.mean(np.array(inside) < 1) >= 0.9
    assert 0.7 < np.median(wider) < 1.4
    with pytest.raises(InputError, match="20 pose pairs show 2 postures"):
        solve_hand_eye(hand[[0] * 10 + [7] * 10], seen[:20])


def test_a_changed_noise_level_is_found() -> None:
    rng = np.random.default_rng(6)
    A = random_poses(200, rng)
    _, _, T = seen_pairs(rng, A, "base", noise=2e-3)
    answer = solve_hand_eye(A, T, "base")
    assert np.sqrt(np.diag(answer.noise)[:3]) == pytest.approx(2e-3 * np.ones(3), rel=0.3)
    again = replace(answer, accepted_std=1e-6)
    assert not again.determined
