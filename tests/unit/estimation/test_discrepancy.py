"""The residual field: smooth errors are learned, white noise is left alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize

from bodyschema import lie
from bodyschema.estimation.discrepancy import (
    MOST_SAMPLES,
    distances,
    learn_discrepancy,
    matern,
    most_likely,
    unlikelihood,
)
from bodyschema.model.tree import Body
from bodyschema.senses.points import Points
from bodyschema.senses.poses import Poses
from simulated import points, poses, postures, seen_arm

Array = NDArray[np.float64]
REACH = 1.0
"""rad: the postures that the field is learned from and tested in."""


def field(q: Array) -> Array:
    """A bend of about 5 mm and 10 mrad that no geometry explains, (n, 6)."""
    a, b = np.sin(q[:, 0] + q[:, 1]), np.cos(q[:, 1] - q[:, 2])
    return np.column_stack([5e-3 * a, 5e-3 * b, 5e-3 * a * b, 0.01 * a, 0.01 * b, 0 * a])


def seen(kind: str, n: int, size: float, seed: int) -> tuple[Body, Points | Poses]:
    rng = np.random.default_rng(seed)
    body = seen_arm(3, np.random.default_rng(0))
    q = postures(n, body, rng, REACH)
    f = size * field(q)
    if kind == "points":
        sense = points(body, q, rng)
        return body, replace(sense, observed=sense.position + f[:, :3])
    posed = poses(body, q, rng)
    R = lie.exp_so3(f[:, 3:]) @ posed.pose[:, :3, :3]
    return body, replace(posed, observed=lie.transform(R, posed.pose[:, :3, 3] + f[:, :3]))


def rms(residual: Array) -> Array:
    """Of positions, and of rotations where there are some."""
    parts = [residual[:, :3], residual[:, 3:]][: residual.shape[1] // 3]
    return np.array([np.sqrt(np.mean(part**2)) for part in parts])


@pytest.mark.parametrize("kind", ["points", "poses"])
def test_a_smooth_field_is_learned_and_removed(kind: str) -> None:
    body, training = seen(kind, 100, 1.0, 1)
    _, test = seen(kind, 100, 1.0, 2)
    found = learn_discrepancy(body, training, np.ones(100, dtype=bool))
    before = test.residual(body)
    after = before - found.predict(test.q)
    assert (rms(after) < rms(before) / 2).all()
    assert found.gain > 50
    assert found.noise[0] == pytest.approx(1e-3, rel=0.25)
    assert found.amplitude[0] > 2 * found.noise[0]
    assert 0.3 < found.length < 12


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("kind", ["points", "poses"])
def test_white_noise_does_no_harm(kind: str, seed: int) -> None:
    body, training = seen(kind, 100, 0.0, 2 * seed)
    _, test = seen(kind, 200, 0.0, 2 * seed + 1)
    found = learn_discrepancy(body, training, np.ones(100, dtype=bool))
    before = test.residual(body)
    assert (rms(before - found.predict(test.q)) < 1.03 * rms(before)).all()
    assert found.gain < 8


def test_the_field_fades_far_from_what_was_seen() -> None:
    body, training = seen("points", 60, 1.0, 1)
    found = learn_discrepancy(body, training, np.ones(60, dtype=bool))
    assert np.abs(found.predict(np.full((1, 3), 1e3))).max() < 1e-12


def test_outliers_are_left_out() -> None:
    body, training = seen("points", 80, 1.0, 1)
    good = np.arange(80) % 5 > 0
    wild = replace(training, observed=training.position + np.where(good, 0, 0.3)[:, None])
    clean = learn_discrepancy(body, training.take(good), np.ones(64, dtype=bool))
    assert (learn_discrepancy(body, wild, good).coefficients == clean.coefficients).all()


def test_a_long_recording_is_thinned_evenly() -> None:
    body, training = seen("points", MOST_SAMPLES + 100, 1.0, 1)
    found = learn_discrepancy(body, training, np.ones(len(training), dtype=bool))
    assert found.q.shape == (MOST_SAMPLES, 3)
    assert (found.q[0] == training.q[0]).all()
    assert (found.q[-1] == training.q[-1]).all()


def test_exact_samples_need_no_field() -> None:
    body, training = seen("points", 30, 0.0, 1)
    exact = training.imagined(body, training.q)
    found = learn_discrepancy(body, exact, np.ones(30, dtype=bool))
    assert np.abs(found.predict(training.q)).max() < 1e-12


def white_and_smooth(seed: int, n: int) -> tuple[Array, list[Array]]:
    """Postures, and two parts of a residual that are about as smooth as they are noisy."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1.5, 1.5, (n, 3))
    smooth = np.sin(q[:, :1] + q[:, 1:2]) * [1, 0.5, -0.3]
    parts = [smooth + rng.normal(size=(n, 3)), 0.8 * smooth[:, :2] + rng.normal(size=(n, 2))]
    return q, [part / np.sqrt(np.mean(part**2)) for part in parts]


def negative_log_likelihood(theta: Array, q: Array, parts: list[Array]) -> float:
    """The objective as its definition reads."""
    total, kernel = 0.0, matern(q, q, float(np.exp(theta[0])))
    for r, a, n in zip(parts, theta[1::2], theta[2::2], strict=True):
        K = np.exp(2 * a) * kernel + np.exp(2 * n) * np.eye(len(q))
        explained = float(np.sum(r * np.linalg.solve(K, r)))
        total += 0.5 * (explained + r.shape[1] * np.linalg.slogdet(K)[1])
    return total


@pytest.mark.parametrize("seed", range(3))
def test_the_likelihood_and_its_slope(seed: int) -> None:
    q, parts = white_and_smooth(seed, 40)
    gap = distances(q, q)
    theta = np.random.default_rng(seed).uniform(-1, 1, 5)
    value, slope = unlikelihood(theta, gap, parts)
    assert value == pytest.approx(negative_log_likelihood(theta, q, parts), rel=1e-12)
    steps = 1e-5 * np.eye(5)
    forth = [unlikelihood(theta + d, gap, parts)[0] for d in steps]
    back = [unlikelihood(theta - d, gap, parts)[0] for d in steps]
    differences = (np.array(forth) - back) / 2e-5
    assert np.abs(slope - differences).max() < 1e-6


@pytest.mark.parametrize("seed", range(3))
def test_the_optimum_is_that_of_finite_differences(seed: int) -> None:
    q, parts = white_and_smooth(seed, 60)
    theta, gain = most_likely(q, parts)
    bounds = [(-3.0, 2.5), *[(-5.0, 2.0)] * 4]
    plain = minimize(negative_log_likelihood, theta + 0.3, (q, parts), "L-BFGS-B", bounds=bounds)
    assert np.abs(theta - plain.x).max() < 2e-3
    white = 0.5 * sum(np.sum(part**2) for part in parts)
    assert gain == pytest.approx(white - plain.fun, abs=1e-4)


def test_matern_is_its_formula() -> None:
    rng = np.random.default_rng(0)
    q, other, length = rng.normal(size=(4, 3)), rng.normal(size=(5, 3)), 0.7
    K = matern(q, other, length)
    for i in range(4):
        for j in range(5):
            s = np.sqrt(3) * np.linalg.norm(q[i] - other[j]) / length
            assert K[i, j] == pytest.approx((1 + s) * np.exp(-s))
    assert np.linalg.eigvalsh(matern(q, q, length)).min() > 0
    assert matern(q, q, length).diagonal() == pytest.approx(np.ones(4))
