"""Levels: names, units, what is stated, and the step towards the likeliest."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.estimation.descent import begin
from bodyschema.estimation.loss import Loss
from bodyschema.estimation.noise import KAPPA, SMALLEST_LEVEL, first_levels, newton_step
from bodyschema.estimation.objective import Objective
from bodyschema.estimation.solver import Solver
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_joints
from bodyschema.senses.sense import Sense
from simulated import drawn, free_all, points, poses, postures, seen_arm

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Wires(Sense):
    """Lengths of a draw wire and the height that it hangs at: one number each, other units."""

    measures = (("length", "m", 1), ("height", "mm", 1))

    def predict(self, body: Body) -> Array:
        p = relative_pose(body, self.q, self.seen_from, self.seen)[:, :3, 3]
        return np.stack([np.linalg.norm(p, axis=1), 1e3 * p[:, 2]], axis=1)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)


@pytest.fixture
def body(rng: np.random.Generator) -> Body:
    return seen_arm(4, rng)


@pytest.fixture
def variables(body: Body) -> Variables:
    return free_all(body, ("offsets", "axes"))


def test_the_step_is_newtons_on_the_marginal_likelihood(
    body: Body, variables: Variables, rng: np.random.Generator
) -> None:
    truth = body.with_variables(variables, drawn(variables, rng, 0.02))
    senses = (
        points(truth, postures(20, body, rng), rng),
        poses(truth, postures(15, body, rng), rng),
    )
    nu = 4.0
    objective = Objective(body, variables, senses, tuple(np.ones(len(s)) for s in senses), (nu, nu))
    theta = np.array([0.3, -0.2, 0.4])
    state = begin(objective, np.zeros(len(variables)), theta)
    weights, squares = objective.weights(state.place.squares, theta), state.place.squares
    scale = np.exp(-2 * theta)
    H = np.tensordot(scale, state.shares, 1) + np.diag(objective.precision)
    C = np.linalg.inv(H)

    def negative_log(t: Array) -> float:
        total = 0.5 * KAPPA * float(t @ t) + float(objective.counts @ t)
        total += objective.cost(np.zeros(len(variables)), squares, t)
        told = np.tensordot(np.exp(-2 * t), state.shares, 1) + np.diag(objective.precision)
        return total + 0.5 * float(np.linalg.slogdet(told)[1])

    e = 1e-4 * np.eye(3)
    g = np.array([(negative_log(theta + d) - negative_log(theta - d)) / 2e-4 for d in e])
    A = np.array([
        [
            (negative_log(theta + a + b) - negative_log(theta + a - b)
             - negative_log(theta - a + b) + negative_log(theta - a - b)) / 4e-8
            for a in e
        ]
        for b in e
    ])  # fmt: skip
    sums = np.concatenate([w @ q for w, q in zip(weights, squares, strict=True)]) * scale
    coupled = objective.coupled(squares, weights, theta)
    found = newton_step(
        theta, objective.counts, sums, coupled, state.shares * scale[:, None, None], C
    )
    assert found == pytest.approx(np.clip(-np.linalg.solve(A, g), -0.5, 1.0), rel=1e-3, abs=1e-4)


def test_senses_of_one_number_and_of_any_unit(body: Body, rng: np.random.Generator) -> None:
    offsets = free_joints(body, ["offsets"])
    truth = body.with_variables(offsets, np.array([0.03, -0.02, 0.05, -0.04]))
    q = postures(300, body, rng)
    clean = Wires.make(q, np.zeros((300, 2)), "tracker", "tool", (1e-3, 1.0))
    noise = rng.normal(size=(300, 2)) * [3e-3, 0.5]
    seen = replace(clean, observed=clean.predict(truth) + noise)
    fit = Solver().fit(body, offsets, [seen])
    assert fit.converged
    assert (np.abs(fit.x - [0.03, -0.02, 0.05, -0.04]) < 4 * fit.std).all()
    label = seen.label
    assert fit.noise == {
        f"{label}: length (m)": pytest.approx(3e-3, rel=0.12),
        f"{label}: height (mm)": pytest.approx(0.5, rel=0.12),
    }


def test_a_sense_with_a_row_or_two_keeps_a_level_near_what_is_believed(
    body: Body, variables: Variables, rng: np.random.Generator
) -> None:
    many = points(body, postures(60, body, rng), rng)
    one = poses(body, postures(1, body, rng), rng)
    fit = Solver().fit(body, variables, [many, one])
    assert fit.converged
    assert all(0.03 < level < 30 for level in fit.levels[1])


def test_exact_samples_stop_at_the_smallest_level(
    body: Body, variables: Variables, rng: np.random.Generator
) -> None:
    seen = poses(body, postures(40, body, rng), rng)
    exact = seen.imagined(body, seen.q)
    fit = Solver().fit(body, variables, [exact])
    assert fit.levels[0] == pytest.approx((SMALLEST_LEVEL, SMALLEST_LEVEL))


def test_first_levels_are_those_of_the_noise(body: Body, rng: np.random.Generator) -> None:
    q = postures(2000, body, rng)
    assert first_levels(points(body, q, rng), body) == pytest.approx((1.0,), rel=0.05)
    assert first_levels(poses(body, q, rng), body) == pytest.approx((1.0, 1.0), rel=0.05)
    wires = Wires.make(q, np.zeros((2000, 2)), "tracker", "tool", (1e-3, 1.0))
    noise = rng.normal(size=(2000, 2)) * [1e-3, 1.0]
    seen = replace(wires, observed=wires.predict(body) + noise)
    assert first_levels(seen, body) == pytest.approx((1.0, 1.0), rel=0.05)


@pytest.mark.parametrize(
    ("true", "excess"), [(0.5e-3, 0.0), (1e-3, 0.0), (3e-3, np.sqrt(8) * 1e-3)]
)
def test_what_exceeds_stated_noise_is_error_of_the_model(
    true: float, excess: float, body: Body, variables: Variables
) -> None:
    rng = np.random.default_rng(1)
    truth = body.with_variables(variables, drawn(variables, rng, 0.3))
    seen = points(truth, postures(200, body, rng), rng, true)
    stated = replace(seen, covariance=1e-6 * np.eye(3), stated=True)
    fit = Solver().fit(body, variables, [stated])
    (name,) = fit.noise or {}
    assert (fit.noise or {})[name] == 1e-3
    assert fit.levels[0][0] >= 1.0
    assert (fit.model_error or {})[name] == pytest.approx(excess, rel=0.1)
    learnt = Solver().fit(body, variables, [replace(stated, stated=False)])
    assert learnt.model_error == {}
    # A small error of the model makes the belief no surer than the noise that was stated.
    assert (fit.std >= 0.95 * learnt.std).all()


def test_without_learning_the_covariances_are_taken_as_they_are(
    body: Body, variables: Variables, rng: np.random.Generator
) -> None:
    seen = points(body, postures(50, body, rng), rng, 5e-3)
    fit = Solver(Loss(np.inf), learn_levels=False).fit(body, variables, [seen])
    assert fit.levels == ((1.0,),)
