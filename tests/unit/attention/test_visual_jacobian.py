"""The closed forms against plain Gaussian algebra."""

from __future__ import annotations

import numpy as np
from scipy.stats import multivariate_normal

from bodyschema.attention.visual_jacobian import (
    MotionSums,
    empty,
    explained,
    faded,
    furthest,
    jacobians,
    joined,
    joint_evidence,
)

J, N, PRECISION = 3, 2, 0.5
ALL = np.arange(J)


def recorded(rng: np.random.Generator, frames: int) -> tuple[np.ndarray, np.ndarray]:
    """Joints' motion (n, J) and flow (n, N, 2) that follows it, with unit noise."""
    x = rng.normal(size=(frames, J))
    K = rng.normal(size=(N, 2, J))
    return x, np.einsum("tj,ncj->tnc", x, K) + rng.normal(size=(frames, N, 2))


def summed(x: np.ndarray, y: np.ndarray) -> MotionSums:
    sums = empty(1, J, N)
    for turn, flow in zip(x, y, strict=True):
        sums = sums.add(turn[None], flow)
    return sums


def log_likelihood(x: np.ndarray, y: np.ndarray) -> float:
    """Of one cell's flow with K integrated out; frames are correlated through K."""
    cov = np.eye(len(x)) + x @ x.T / PRECISION
    return sum(multivariate_normal(cov=cov).logpdf(y[:, axis]) for axis in range(2))


def test_explained_energy_and_price_are_those_of_the_evidence():
    """What a motion adds to the evidence, given the motions before it, in closed form."""
    x, y = recorded(np.random.default_rng(0), 12)
    before, motion = summed(x[:7], y[:7]), summed(x[7:], y[7:])
    found = explained(before, joined(before, motion), 0, ALL, PRECISION)
    for n in range(N):
        added = log_likelihood(x, y[:, n]) - log_likelihood(x[:7], y[:7, n])
        noise_alone = multivariate_normal(cov=np.eye(5))
        still = sum(noise_alone.logpdf(y[7:, n, axis]) for axis in range(2))
        assert np.isclose(added - still, found.energy[n] / 2 - found.price)


def test_foretold_is_the_energy_of_the_earlier_answer():
    x, y = recorded(np.random.default_rng(1), 9)
    before, motion = summed(x[:6], y[:6]), summed(x[6:], y[6:])
    K, _ = jacobians(before, 0, PRECISION)
    expected = np.sum(np.einsum("tj,ncj->tnc", x[6:], K) ** 2, axis=(0, 2))
    found = explained(before, joined(before, motion), 0, ALL, PRECISION)
    np.testing.assert_allclose(found.foretold, expected)


def test_some_joints_alone_are_the_regression_on_them():
    x, y = recorded(np.random.default_rng(2), 9)
    sums, two = summed(x, y), np.array([0, 2])
    A = x[:, two].T @ x[:, two] + PRECISION * np.eye(2)
    b = x[:, two].T @ y.reshape(9, -1)
    expected = np.sum(b * np.linalg.solve(A, b), axis=0).reshape(N, 2).sum(axis=1)
    nothing = empty(1, J, N)
    np.testing.assert_allclose(explained(nothing, sums, 0, two, PRECISION).energy, expected)
    none = explained(nothing, sums, 0, np.array([], dtype=int), PRECISION)
    assert none.price == 0
    assert not none.energy.any()


def test_the_jacobian_is_the_ridge_answer_and_fades_towards_nothing():
    x, y = recorded(np.random.default_rng(3), 200)
    sums = summed(x, y)
    K, V = jacobians(sums, 0, PRECISION)
    A = x.T @ x + PRECISION * np.eye(J)
    np.testing.assert_allclose(K[0], np.linalg.solve(A, x.T @ y[:, 0]).T)
    np.testing.assert_allclose(V @ A, np.eye(J), atol=1e-9)
    later, _ = jacobians(faded(sums, 0.01), 0, 100.0)
    assert np.abs(later).max() < 0.1 * np.abs(K).max()


def test_a_joint_that_moves_a_cell_has_evidence_and_the_furthest_is_named():
    rng = np.random.default_rng(4)
    x = rng.normal(size=(100, J))
    K = np.array([[[3.0, 0.0, 0.5], [0.0, 0.0, 0.5]], [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0]]])
    y = np.einsum("tj,ncj->tnc", x, K) + rng.normal(size=(100, N, 2))
    sums = summed(x, y)
    found, V = jacobians(sums, 0, PRECISION)
    evidence = joint_evidence(sums, 0, found, V)
    assert evidence[0, 0] > 30
    assert evidence[1, 0] < 3
    assert furthest(found, evidence).tolist() == [0, 1]
