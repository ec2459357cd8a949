"""The gain of a posture is what recomputing the covariance says it is."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.acting.information_gain import (
    FREEDOM,
    believed_information,
    covariance_of,
    expected_jacobians,
    gains,
    greedy,
    noise_levels,
    tool_jacobians,
)
from bodyschema.estimation.loss import fisher_share
from bodyschema.model.kinematics import relative_pose


@pytest.fixture
def problem() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A belief F, Jacobians J of 30 postures, and the weight W of the tool."""
    rng = np.random.default_rng(1)
    root = rng.normal(size=(12, 7))
    F = np.eye(7) + root.T @ (root * 10.0 ** rng.uniform(-2, 3, (12, 1)))
    J = rng.normal(size=(30, 3, 7)) * 10.0 ** rng.uniform(-1, 2, (30, 1, 1))
    E = rng.normal(size=(20, 3, 7))
    return F, J, np.einsum("kai,kaj->ij", E, E) / len(E)


def test_tool_gain_is_the_fall_of_the_tool_variance(problem) -> None:  # type: ignore[no-untyped-def]
    F, J, W = problem
    before = np.trace(W @ np.linalg.inv(F))
    brute = [before - np.trace(W @ np.linalg.inv(F + j.T @ j)) for j in J]
    np.testing.assert_allclose(gains(J, covariance_of(F), W), brute, rtol=1e-8)


def test_overall_gain_is_the_growth_of_the_log_determinant(problem) -> None:  # type: ignore[no-untyped-def]
    F, J, _ = problem
    before = np.linalg.slogdet(F)[1]
    brute = [np.linalg.slogdet(F + j.T @ j)[1] - before for j in J]
    np.testing.assert_allclose(gains(J, covariance_of(F), None), brute, rtol=1e-9)


def test_greedy_takes_the_best_each_time(problem) -> None:  # type: ignore[no-untyped-def]
    F, J, W = problem
    left = list(range(len(J)))
    for chosen in greedy(F, J, W, 6):
        scores = [np.trace(W @ np.linalg.inv(F + J[i].T @ J[i])) for i in left]
        assert chosen == left[int(np.argmin(scores))]
        left.remove(int(chosen))
        F = F + J[chosen].T @ J[chosen]


def test_greedy_ends_when_nothing_is_left(problem) -> None:  # type: ignore[no-untyped-def]
    F, J, W = problem
    assert sorted(greedy(F, J[:4], W, 9)) == [0, 1, 2, 3]


def test_forecast_is_what_samples_of_typical_size_give(calibrated) -> None:  # type: ignore[no-untyped-def]
    """J^T J / s^2 times the Fisher share, s the learned noise, in units of the prior."""
    world = calibrated()
    estimate, sense = world.estimate, world.sense
    J = expected_jacobians(estimate, [sense], sense.q, np.ones((len(sense), 1), dtype=bool))
    level = next(iter(estimate.noise.values()))
    linear = sense.linearize(estimate.reference, estimate.variables, estimate.x)
    raw = linear.by_parameter * estimate.variables.scale / level
    np.testing.assert_allclose(
        np.einsum("nai,naj->ij", J, J),
        fisher_share(FREEDOM, 3) * np.einsum("nai,naj->ij", raw, raw),
        rtol=1e-9, atol=1e-6,
    )  # fmt: skip


def test_what_is_not_visible_tells_nothing(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    visible = np.zeros((len(world.sense), 1), dtype=bool)
    assert not expected_jacobians(world.estimate, [world.sense], world.sense.q, visible).any()


def test_noise_is_the_learned_one_or_else_the_believed(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    estimate = world.estimate
    assert noise_levels(estimate, world.sense)[0] == pytest.approx(
        estimate.noise["tool seen from tracker: position (m)"] / 1e-3
    )
    estimate.noise.clear()
    assert noise_levels(estimate, world.sense) == (1.0,)
    estimate.noise["tool seen from tracker: position (m)"] = 1e-3


def test_tool_jacobian_is_the_slope_of_the_tool(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    estimate = world.estimate
    q = world.sense.q[:2]
    E = tool_jacobians(estimate, [("tracker", "tool")], q)
    step = 1e-6
    for i in (0, 4, len(estimate.x) - 1):
        moved = estimate.x + step * estimate.variables.scale[i] * np.eye(len(estimate.x))[i]
        there = estimate.reference.with_variables(estimate.variables, moved)
        slope = relative_pose(there, q, "tracker", "tool") - relative_pose(
            estimate.body, q, "tracker", "tool"
        )
        np.testing.assert_allclose(E[:, :, i], slope[:, :3, 3] / step, atol=1e-5)


def test_belief_is_the_estimate_in_units_of_its_prior(calibrated) -> None:  # type: ignore[no-untyped-def]
    estimate = calibrated().estimate
    D = estimate.variables.scale
    C = covariance_of(believed_information(estimate)) * np.outer(D, D)
    np.testing.assert_allclose(C, estimate.covariance, rtol=1e-6, atol=1e-12)
