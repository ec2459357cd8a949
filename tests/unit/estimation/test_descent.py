"""Slope, curvature and corrected steps against differences."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.estimation.descent import begin, covariance, iterate, slope
from bodyschema.estimation.objective import MOST_BENT, Objective
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense
from simulated import drawn, free_all, points, poses, postures, seen_arm

Array = NDArray[np.float64]
THETA = np.array([0.3, -0.2, 0.4])


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)


@pytest.fixture
def body(rng: np.random.Generator) -> Body:
    return seen_arm(4, rng)


@pytest.fixture
def variables(body: Body) -> Variables:
    return free_all(body, ("offsets", "axes"))


@pytest.fixture
def objective(body: Body, variables: Variables, rng: np.random.Generator) -> Objective:
    """Two senses of different tails, samples of different worth, a body that is nearly right."""
    truth = body.with_variables(variables, drawn(variables, rng, 0.01))
    q = postures(35, body, rng)
    senses: tuple[Sense, ...] = (points(truth, q[:20], rng), poses(truth, q[20:], rng))
    worth = (rng.uniform(0.2, 1, 20), rng.uniform(0.2, 1, 15))
    return Objective(body, variables, senses, worth, (4.0, 30.0))


def cost(objective: Objective, x: Array) -> float:
    """C at the levels THETA."""
    return objective.cost(x, objective.squares(objective.residuals(x)), THETA)


def test_the_slope_is_that_of_the_cost(objective: Objective, rng: np.random.Generator) -> None:
    x = drawn(objective.variables, rng, 0.02)
    g = slope(objective, begin(objective, x, THETA))
    steps = 1e-6 * np.eye(len(x))
    differences = [(cost(objective, x + d) - cost(objective, x - d)) / 2e-6 for d in steps]
    assert g == pytest.approx(np.array(differences), rel=1e-5, abs=1e-6 * np.abs(g).max())


def test_the_bend_is_what_falling_weights_take_from_the_curvature(objective: Objective) -> None:
    """With residuals that are straight in x the curvature of the cost is H less the bend."""
    x, theta = np.zeros(len(objective.variables)), THETA + 1.5
    state = begin(objective, x, theta)
    place, weights = state.place, objective.weights(state.place.squares, theta)
    lengths = objective.lengths(place.squares, theta)
    assert max(2 * Q.max() / (4 + Q.max()) for Q in lengths) < MOST_BENT

    def straight(v: Array) -> float:
        there = [part.residual + part.jacobian @ v for part in place.parts]
        return objective.cost(v, objective.squares(there), theta)

    H = np.tensordot(np.exp(-2 * theta), state.shares, 1) + np.diag(objective.precision)
    observed = H - objective.bend(place, weights, theta)
    for v in np.random.default_rng(1).normal(size=(5, len(x))) * objective.variables.scale:
        e = 1e-4 * v
        second = (straight(e) - 2 * straight(0 * e) + straight(-e)) / 1e-8
        assert v @ observed @ v == pytest.approx(second, rel=1e-3)


def test_an_outlier_bends_no_more_than_its_share(
    body: Body, variables: Variables, rng: np.random.Generator
) -> None:
    far = body.with_variables(variables, drawn(variables, rng, 2.0))
    seen = points(far, postures(9, body, rng), rng)
    objective = Objective(body, variables, (seen,), (np.ones(9),), (4.0,))
    state = begin(objective, np.zeros(len(variables)), np.zeros(1))
    weights = objective.weights(state.place.squares, np.zeros(1))
    left = state.shares[0] - objective.bend(state.place, weights, np.zeros(1))
    D = variables.scale
    assert np.linalg.eigvalsh(left * np.outer(D, D)).min() > -1e-6


def test_a_corrected_step_stays_in_a_curved_valley(
    body: Body, variables: Variables, rng: np.random.Generator
) -> None:
    """From far off, one iteration comes nearer than a straight Gauss-Newton step."""
    nearer = 0
    for seed in range(10):
        x = drawn(variables, np.random.default_rng(seed), 1.0)
        truth = body.with_variables(variables, x)
        seen = points(truth, postures(60, body, rng, 0.5), rng, 1e-5)
        objective = Objective(body, variables, (seen,), (np.ones(60),), (np.inf,))
        state = begin(objective, np.zeros(len(x)), np.zeros(1))
        C = covariance(objective, state.shares, np.zeros(1))
        straight = -C @ slope(objective, state)
        corrected = iterate(objective, state, False).place.x
        left = [
            sum(float(np.sum(r**2)) for r in objective.residuals(v)) for v in (straight, corrected)
        ]
        nearer += left[1] < left[0]
    assert nearer >= 8


def test_an_iteration_never_raises_the_cost(
    body: Body, variables: Variables, rng: np.random.Generator
) -> None:
    truth = body.with_variables(variables, drawn(variables, rng, 1.0))
    seen = points(truth, postures(30, body, rng), rng)
    objective = Objective(body, variables, (seen,), (np.ones(30),), (4.0,))
    state = begin(objective, np.zeros(len(variables)), np.zeros(1))
    costs = []
    for _ in range(15):
        costs.append(objective.cost(state.place.x, state.place.squares, state.theta))
        state = iterate(objective, state, False)
    assert (np.diff(costs) <= 1e-9 * (1 + np.abs(costs[1:]))).all()
    assert state.moved < 1e-4
