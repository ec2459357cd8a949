"""Frames of many hypotheses at once: true ones are found, scales too; outliers do not count."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.seeds.frame_fits import Batch, FrameFits, angle, median, rough_score
from simulated import random_pose, random_poses

Array = NDArray[np.float64]


def seen(
    rng: np.random.Generator, n: int = 40, noise: tuple[float, float] = (1e-3, 3e-3)
) -> tuple[Array, Array, Array]:
    """K (n, 4, 4), T (n, 4, 4) = X^-1 K Y with noise, and X."""
    K, X, Y = random_poses(n, rng), random_pose(rng, 1.0), random_pose(rng, 0.1)
    T = lie.inverse(X) @ K @ Y
    T[:, :3, 3] += noise[0] * rng.normal(size=(n, 3))
    T[:, :3, :3] = lie.exp_so3(noise[1] * rng.normal(size=(n, 3))) @ T[:, :3, :3]
    return K, T, X


def batch(K: Array, T: Array, posed: bool, scaled: bool = False) -> Batch:
    Q = T[None, :, :3, :3] if posed else None
    free = np.array([True]) if scaled else None
    return Batch(K[None].copy(), T[None, :, :3, 3], Q, None, free)


@pytest.mark.parametrize("posed", [False, True])
def test_true_frames_leave_the_noise(posed: bool) -> None:
    rng = np.random.default_rng(0)
    K, T, X = seen(rng)
    found = FrameFits.of(batch(K, T, posed))
    assert angle(found.R_X[0], X[:3, :3]) < 0.01
    assert found.metres[0] == pytest.approx(1.538e-3, rel=0.3)
    assert found.position[0] < 0.02
    if posed:
        assert found.radians[0] == pytest.approx(1.538 * 3e-3, rel=0.3)


@pytest.mark.parametrize("posed", [False, True])
def test_outliers_do_not_move_the_frames(posed: bool) -> None:
    rng = np.random.default_rng(1)
    K, T, X = seen(rng)
    bad = np.arange(len(T)) % 3 == 0
    T[bad] = random_poses(int(bad.sum()), rng)
    found = FrameFits.of(batch(K, T, posed))
    assert angle(found.R_X[0], X[:3, :3]) < 0.02
    assert found.position[0] < 0.05


@pytest.mark.parametrize("posed", [False, True])
@pytest.mark.parametrize("size", [0.001, 0.7, 1.3, 1000.0])
def test_a_scale_is_found(posed: bool, size: float) -> None:
    rng = np.random.default_rng(2)
    K, T, _ = seen(rng)
    T[:, :3, 3] /= size
    found = FrameFits.of(batch(K, T, posed, scaled=True))
    assert found.scale[0] == pytest.approx(size, rel=0.02)
    assert FrameFits.of(batch(K, T, posed)).position[0] > 4 * found.position[0]


def test_rotations_that_are_turned_against_the_positions_are_not_explained() -> None:
    """Each alone would fit: what is wrong is that they need different frames."""
    rng = np.random.default_rng(3)
    K, T, _ = seen(rng)
    T[:, :3, :3] = lie.exp_so3(np.array([0.0, 0.0, 1.5])) @ T[:, :3, :3]
    assert FrameFits.of(batch(K, T, True)).worst[0] > 0.2
    assert FrameFits.of(batch(K, T, False)).worst[0] < 0.02


def test_mirrored_positions_show_in_the_axes() -> None:
    rng = np.random.default_rng(4)
    K, T, _ = seen(rng)
    T[:, :3, 3] *= [1, -1, 1]
    points, poses = (FrameFits.of(batch(K, T, posed)) for posed in (False, True))
    assert (np.diag(points.axes[0]) == -1).all()
    axes = poses.axes[0] / np.cbrt(abs(np.linalg.det(poses.axes[0])))
    assert axes == pytest.approx(np.diag([1, -1, 1]), abs=0.2)


def test_samples_that_a_hypothesis_has_not_do_not_count() -> None:
    rng = np.random.default_rng(5)
    K, T, _ = seen(rng)
    use = np.ones((1, len(T)), dtype=bool)
    use[0, :25] = False
    T[:25] = random_poses(25, rng)
    all_of_it = Batch(K[None], T[None, :, :3, 3], T[None, :, :3, :3])
    some = Batch(K[None], T[None, :, :3, 3], T[None, :, :3, :3], use)
    assert FrameFits.of(some).worst[0] < 0.03 < FrameFits.of(all_of_it).worst[0]


@pytest.mark.parametrize("posed", [False, True])
def test_a_rough_score_prefers_the_truth(posed: bool) -> None:
    rng = np.random.default_rng(6)
    K, T, _ = seen(rng)
    both = np.stack([random_poses(len(K), rng), K])
    seen_twice = np.stack([T, T])
    Q = seen_twice[:, :, :3, :3] if posed else None
    scores = rough_score(Batch(both, seen_twice[:, :, :3, 3], Q))
    assert scores[1] < scores[0] - 1


def test_the_median_is_of_the_samples_that_count() -> None:
    values, weights = np.array([[3.0, 1.0, 2.0, 9.0]]), np.array([[1.0, 1.0, 1.0, 0.0]])
    assert median(values, weights) == pytest.approx(2.0)
