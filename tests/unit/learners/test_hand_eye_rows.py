"""Rows over forty monomials: derivatives, white noise, the noise matrix."""

from __future__ import annotations

import numpy as np

from bodyschema.learners.hand_eye.chart import innovations, lift, predict
from bodyschema.learners.hand_eye.point_memory import PointMemory
from bodyschema.learners.hand_eye.points import HandEyePoints
from bodyschema.learners.hand_eye.stereo_points import depth_row, monomial_rows
from bodyschema.simulation.katana import project_points, stereo
from watched import learned, seen, truth

STEP = 1e-6


def lifted(theta, k=0):
    x, J = np.empty(40), np.empty((40, 9))
    lift(theta.M, theta.u, theta.points[k], x, J)
    return x, J


def test_slopes_of_monomials_and_pixels_against_finite_differences():
    scene, stream = seen(1, 1, points=2)
    theta, eyes = truth(scene), stereo()
    T, pixels = stream.T_world_hand[5:6], stream.pixels[5:6]
    _, J, _ = predict(theta, T, pixels, eyes.numbers)
    for j in range(12):
        d = np.zeros(12)
        d[j] = STEP
        after, before = theta.move(d), theta.move(-d)
        ahead, _, _ = predict(after, T, pixels, eyes.numbers)
        behind, _, _ = predict(before, T, pixels, eyes.numbers)
        slope = (behind - ahead)[0] / (2 * STEP)
        for k in range(2):
            own = j if j < 6 else j - 3 * k
            expected = J[0, k, :, own] if 0 <= own < 9 and (j < 6 or own >= 6) else np.zeros(3)
            assert np.allclose(slope[k], expected, rtol=1e-5, atol=1e-3)
    _, slope = lifted(theta)
    for j in range(9):
        d = np.zeros(12)
        d[j] = STEP
        change = (lifted(theta.move(d))[0] - lifted(theta.move(-d))[0]) / (2 * STEP)
        assert np.allclose(change, slope[:, j], atol=1e-8)


def test_rows_are_white_pixel_residuals_and_noise_adds_the_noise_matrix():
    scene, stream = seen(2, 1)
    theta, eyes = truth(scene), stereo(0.5)
    T = stream.T_world_hand[:1]
    clean = project_points(scene, T, eyes)[0]
    e, J, depth = np.empty((1, 1, 3)), np.empty((1, 1, 3, 9)), np.empty((1, 1))
    x, _ = lifted(theta)
    rng = np.random.default_rng(0)
    A, exact, k_Z = np.empty((3, 40)), np.empty((3, 40)), np.empty(40)
    innovations(theta.M, theta.u, theta.points, T, clean[None], eyes.numbers, e, J, depth)
    monomial_rows(T[0], clean[0], depth[0, 0], eyes.numbers, exact)
    assert np.abs(exact @ x).max() < 1e-9
    depth_row(T[0], k_Z)
    assert np.isclose(k_Z @ x, depth[0, 0])
    total, residuals = np.zeros((40, 40)), []
    for _ in range(20_000):
        noisy = clean[0] + 0.5 * rng.normal(size=3)
        monomial_rows(T[0], noisy, depth[0, 0], eyes.numbers, A)
        total += (A.T @ A - exact.T @ exact) / 20_000
        residuals.append(A @ x)
    noise = 3 * np.outer(k_Z, k_Z) / depth[0, 0] ** 2
    # The cross terms average out like 1 / sqrt(n): judge them by the spread of a row.
    assert np.abs(x @ total @ x - x @ noise @ x) < 0.1
    assert np.allclose(total[6:9, 6:9], noise[6:9, 6:9], atol=0.03 * np.abs(exact).max())
    assert np.allclose(np.cov(np.array(residuals).T), np.eye(3), atol=0.05)


def test_the_noise_matrix_takes_the_bias_out():
    """With noise of 4 px the sums without N pull the answer many sigma away; with N they do not."""
    scene, stream = seen(4, 120, noise=4.0)
    theta, eyes = truth(scene), stereo(4.0)
    clean = project_points(scene, stream.T_world_hand, eyes)
    depth = eyes.depth(clean)
    memory = PointMemory.empty(1).add(
        stream.T_world_hand, stream.pixels, depth, np.ones(depth.shape, bool), eyes.numbers
    )
    x, J = lifted(theta)
    information = np.linalg.inv(J.T @ memory.C[0] @ J)
    size = []
    for Q in (memory.C[0] - memory.N[0], memory.C[0]):
        pull = J.T @ Q @ x
        size.append(float(pull @ information @ pull))
    assert size[0] < 28  # 99.9 % of chi-square with nine degrees of freedom
    assert size[1] > size[0]


def test_sums_merge_fade_and_do_not_change_what_they_came_from():
    _, stream = seen(5, 4)
    eyes = stereo()
    depth = eyes.depth(stream.pixels)
    keep = np.ones(depth.shape, bool)

    def of(rows):
        return PointMemory.empty(1).add(
            stream.T_world_hand[rows], stream.pixels[rows], depth[rows], keep[rows], eyes.numbers
        )

    whole, first, second = of(slice(None)), of(slice(60)), of(slice(60, None))
    before = first.C.copy()
    both = first.merge(second)
    assert np.allclose(both.C, whole.C, rtol=1e-12)
    assert np.allclose(both.N, whole.N, rtol=1e-12)
    assert both.count == whole.count == 120
    assert np.allclose(whole.fade(0.5).C, whole.C / 2)
    assert np.array_equal(first.C, before)


def test_same_samples_same_bytes():
    _, stream = seen(6, 8)
    a, b = (learned(HandEyePoints(stereo()), stream) for _ in range(2))
    assert a.theta.M.tobytes() == b.theta.M.tobytes()
    assert a.covariance.tobytes() == b.covariance.tobytes()
