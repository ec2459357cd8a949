"""The closed forms: exact without noise, near the optimum with it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from bodyschema import lie
from bodyschema.seeds import closed_forms as hand_eye
from simulated import angle, random_pose, random_poses

Array = NDArray[np.float64]

NOISE_T, NOISE_R = 2e-3, 5e-3
"""m and rad."""

seeds = st.integers(0, 2**32 - 1)


def shaken(T: Array, rng: np.random.Generator) -> Array:
    """(n, 4, 4) poses with noise in translation and rotation."""
    out = T.copy()
    out[:, :3, 3] += NOISE_T * rng.normal(size=(len(T), 3))
    out[:, :3, :3] = lie.exp_so3(NOISE_R * rng.normal(size=(len(T), 3))) @ out[:, :3, :3]
    return out


def mismatch(left: Array, right: Array) -> Array:
    """Difference of two sets of poses in units of the noise, as one long vector."""
    turned = lie.log_so3(left[:, :3, :3] @ np.swapaxes(right[:, :3, :3], 1, 2)) / NOISE_R
    shifted = (left[:, :3, 3] - right[:, :3, 3]) / NOISE_T
    return np.concatenate([turned, shifted], axis=1).ravel()


def moved(T: Array, d: Array) -> Array:
    """T after a small motion d = (shift, rotation vector)."""
    return lie.transform(lie.exp_so3(d[3:]) @ T[:3, :3], T[:3, 3] + d[:3])


@given(seeds)
def test_nearest_rotation_is_a_rotation_and_keeps_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    R = hand_eye.nearest_rotation(rng.normal(size=(3, 3)))
    assert pytest.approx(np.eye(3), abs=1e-12) == R @ R.T
    assert np.linalg.det(R) == pytest.approx(1)
    assert hand_eye.nearest_rotation(3.0 * R) == pytest.approx(R, abs=1e-12)


@given(seeds, st.integers(3, 20))
def test_align_points_is_exact_without_noise(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    T, source = random_pose(rng), rng.normal(size=(n, 3))
    found = hand_eye.align_points(source, source @ T[:3, :3].T + T[:3, 3], rng.uniform(0.1, 1, n))
    assert found == pytest.approx(T, abs=1e-7)


@given(seeds)
def test_align_points_agrees_with_scipy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    source, target, w = rng.normal(size=(9, 3)), rng.normal(size=(9, 3)), rng.uniform(0.1, 1, 9)
    found = hand_eye.align_points(source, target, w)
    s, t = (w @ points / w.sum() for points in (source, target))
    R = Rotation.align_vectors(target - t, source - s, weights=w)[0].as_matrix()
    assert found[:3, :3] == pytest.approx(R, abs=1e-6)
    assert found[:3, 3] == pytest.approx(t - R @ s, abs=1e-6)


@given(seeds)
def test_align_points_never_mirrors(seed: int) -> None:
    rng = np.random.default_rng(seed)
    source = rng.normal(size=(6, 3))
    found = hand_eye.align_points(source, source * [1, 1, -1], np.ones(6))
    assert np.linalg.det(found[:3, :3]) == pytest.approx(1)


@given(seeds, st.integers(1, 9))
def test_the_mean_of_equal_transforms_is_that_transform(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    T = random_pose(rng)
    found = hand_eye.mean_transform(np.tile(T, (n, 1, 1)), rng.uniform(0.1, 1, n))
    assert found == pytest.approx(T, abs=1e-12)


@given(seeds)
def test_the_mean_of_symmetric_deviations_is_their_centre(seed: int) -> None:
    rng = np.random.default_rng(seed)
    # Turns of more than a right angle to either side have their mean on the far side.
    T, d = random_pose(rng), rng.uniform(-0.8, 0.8, size=6)
    pair = np.array([moved(T, d), moved(T, -d)])
    assert hand_eye.mean_transform(pair, np.ones(2)) == pytest.approx(T, abs=1e-12)
    assert hand_eye.mean_transform(pair, np.array([1.0, 0.0])) == pytest.approx(pair[0], abs=1e-12)


@given(seeds, st.integers(3, 12))
def test_ax_xb_is_exact_without_noise(seed: int, n: int) -> None:
    rng = np.random.default_rng(seed)
    X, B = random_pose(rng), random_poses(n, rng)
    A = X @ B @ lie.inverse(X)
    assert hand_eye.solve_ax_xb(A, B, rng.uniform(0.1, 1, n)) == pytest.approx(X, abs=1e-5)


@pytest.mark.parametrize("seed", range(50))
def test_ky_xt_is_exact_without_noise_and_never_takes_the_wrong_sign(seed: int) -> None:
    rng = np.random.default_rng(seed)
    X, Y, K = random_pose(rng), random_pose(rng), random_poses(8, rng)
    found = hand_eye.solve_ky_xt(K, lie.inverse(X) @ K @ Y, rng.uniform(0.1, 1, 8))
    assert found[0] == pytest.approx(X, abs=1e-9)
    assert found[1] == pytest.approx(Y, abs=1e-9)


@pytest.mark.parametrize("seed", range(8))
def test_ax_xb_under_noise_is_near_the_optimum(seed: int) -> None:
    rng = np.random.default_rng(seed)
    X, B = random_pose(rng), random_poses(30, rng)
    A = shaken(X @ B @ lie.inverse(X), rng)

    def error(d: Array) -> Array:
        return mismatch(A, moved(X, d) @ B @ lie.inverse(moved(X, d)))

    best = least_squares(error, np.zeros(6)).cost
    found = hand_eye.solve_ax_xb(A, B, np.ones(30))
    cost = 0.5 * np.sum(mismatch(A, found @ B @ lie.inverse(found)) ** 2)
    assert best <= cost * (1 + 1e-9)
    assert cost < 1.5 * best
    assert angle(found, X) < 4e-3
    assert np.linalg.norm(found[:3, 3] - X[:3, 3]) < 4e-3


@pytest.mark.parametrize("seed", range(8))
def test_ky_xt_under_noise_is_near_the_optimum(seed: int) -> None:
    rng = np.random.default_rng(seed)
    X, Y, K = random_pose(rng), random_pose(rng), random_poses(30, rng)
    T = shaken(lie.inverse(X) @ K @ Y, rng)

    def error(d: Array) -> Array:
        return mismatch(T, lie.inverse(moved(X, d[:6])) @ K @ moved(Y, d[6:]))

    best = least_squares(error, np.zeros(12)).cost
    found = hand_eye.solve_ky_xt(K, T, np.ones(30))
    cost = 0.5 * np.sum(mismatch(T, lie.inverse(found[0]) @ K @ found[1]) ** 2)
    assert best <= cost * (1 + 1e-9)
    assert cost < 1.25 * best
    for pose, truth in zip(found, (X, Y), strict=True):
        assert angle(pose, truth) < 4e-3
        assert np.linalg.norm(pose[:3, 3] - truth[:3, 3]) < 4e-3


def test_a_sample_without_weight_has_no_say() -> None:
    rng = np.random.default_rng(0)
    X, Y, K = random_pose(rng), random_pose(rng), random_poses(9, rng)
    T = lie.inverse(X) @ K @ Y
    T[4] = random_pose(rng)
    weights = np.where(np.arange(9) == 4, 0.0, 1.0)
    assert hand_eye.solve_ky_xt(K, T, weights)[0] == pytest.approx(X, abs=1e-9)
    A, B = lie.inverse(K[:1]) @ K[1:], lie.inverse(T[:1]) @ T[1:]
    assert hand_eye.solve_ax_xb(A, B, weights[1:]) == pytest.approx(Y, abs=1e-9)
