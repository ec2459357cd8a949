"""The batch learner against independent mathematics: differences, scipy, known noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import approx_fprime, least_squares

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.estimation.loss import Loss
from bodyschema.estimation.normal_equations import (
    information,
    level_rows,
    whiten,
    whitened_residual,
)
from bodyschema.estimation.solver import Solver
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints
from bodyschema.senses.poses import Poses
from bodyschema.senses.sense import Sense
from simulated import drawn, free_all, points, poses, postures, seen_arm, spoiled

Array = NDArray[np.float64]
GAUSSIAN = Solver(Loss(np.inf), learn_levels=False)


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)


@pytest.fixture
def nominal(rng: np.random.Generator) -> Body:
    return seen_arm(4, rng)


@pytest.fixture
def variables(nominal: Body) -> Variables:
    return free_all(nominal, ("offsets", "axes"))


@pytest.fixture
def truth(nominal: Body, variables: Variables, rng: np.random.Generator) -> Body:
    return nominal.with_variables(variables, drawn(variables, rng, 0.3))


@pytest.fixture
def senses(truth: Body, rng: np.random.Generator) -> list[Sense]:
    """Points and poses of one tool, at different moments."""
    q = postures(60, truth, rng)
    return [points(truth, q[:25], rng), poses(truth, q[25:], rng)]


def cost(
    senses: Sequence[Sense], body: Body, levels: Sequence[Array], weights: Sequence[Array]
) -> float:
    """1/2 sum w |r|^2 / s^2, written anew."""
    total = 0.0
    for sense, level, weight in zip(senses, levels, weights, strict=True):
        r = np.linalg.solve(np.linalg.cholesky(sense.covariance), sense.residual(body).T).T
        total += 0.5 * float(np.sum(weight[:, None] * (r / level_rows(sense, level)) ** 2))
    return total


def test_the_gradient_is_that_of_the_cost(
    nominal: Body, variables: Variables, senses: list[Sense], rng: np.random.Generator
) -> None:
    x = drawn(variables, rng, 0.2)
    levels = [np.array([2.0]), np.array([0.7, 3.0])]
    weights = [rng.uniform(0, 2, len(sense)) for sense in senses]
    parts = [whiten(sense, nominal, variables, x) for sense in senses]
    _, g = information(parts, levels, weights)

    def at(v: Array) -> float:
        return cost(senses, nominal.with_variables(variables, v), levels, weights)

    differences = [(at(x + d) - at(x - d)) / 2e-6 for d in 1e-6 * np.eye(len(x))]
    assert g == pytest.approx(np.array(differences), rel=1e-5, abs=1e-6 * np.abs(g).max())


def test_the_hessian_is_that_of_the_cost_where_residuals_vanish(
    nominal: Body, variables: Variables, truth: Body, rng: np.random.Generator
) -> None:
    q, x = postures(9, truth, rng), drawn(variables, rng, 0.2)
    body = nominal.with_variables(variables, x)
    exact = [points(body, q, rng).imagined(body, q), poses(body, q, rng).imagined(body, q)]
    levels, weights = [np.array([2.0]), np.array([0.7, 3.0])], [rng.uniform(0, 2, 9)] * 2

    def gradient(v: Array) -> Array:
        return information([whiten(s, nominal, variables, v) for s in exact], levels, weights)[1]

    H, g = information([whiten(s, nominal, variables, x) for s in exact], levels, weights)
    columns = [(gradient(x + d) - gradient(x - d)) / 2e-6 for d in 1e-6 * np.eye(len(x))]
    assert np.abs(g).max() < 1e-6
    assert pytest.approx(np.column_stack(columns), abs=1e-5 * H.max()) == H


def test_gaussian_fit_is_the_map_of_scipy(
    nominal: Body, variables: Variables, senses: list[Sense]
) -> None:
    def stacked(x: Array) -> Array:
        body = nominal.with_variables(variables, x)
        rows = [whitened_residual(sense, body).ravel() for sense in senses]
        return np.concatenate([*rows, x / variables.prior_std])

    def slopes(x: Array) -> Array:
        return np.asarray(approx_fprime(x, stacked, 1e-8))

    zero = np.zeros(len(variables))
    found = least_squares(
        stacked, zero, slopes, x_scale=variables.prior_std, xtol=1e-15, ftol=1e-15, gtol=1e-15
    )
    fit = GAUSSIAN.fit(nominal, variables, senses)
    assert fit.converged
    assert fit.levels == ((1.0,), (1.0, 1.0))
    assert all((weight == 1).all() for weight in fit.weights)
    assert fit.x == pytest.approx(found.x, abs=1e-6)
    covariance = np.linalg.inv(slopes(found.x).T @ slopes(found.x))
    assert fit.std == pytest.approx(np.sqrt(np.diag(covariance)), rel=1e-3)


@pytest.mark.parametrize("freedom", [np.inf, 4.0])
def test_levels_converge_to_the_true_noise(
    freedom: float, nominal: Body, variables: Variables, truth: Body
) -> None:
    """Noise of the assumed family, 2.5 (m) and 0.4 (rad) times what was believed."""
    rng = np.random.default_rng(3)
    q = postures(300, truth, rng)
    stretch = np.sqrt(freedom / rng.chisquare(freedom, 300)) if freedom < np.inf else np.ones(300)
    noise = stretch[:, None] * rng.normal(size=(300, 6)) * np.repeat([2.5e-3, 2e-3], 3)
    pose = relative_pose(truth, q, "tracker", "tool")
    pose[:, :3, 3] += noise[:, :3]
    pose[:, :3, :3] = lie.exp_so3(noise[:, 3:]) @ pose[:, :3, :3]
    seen = Poses.make(q, pose, "tracker", "tool", (1e-3, 5e-3))
    fit = Solver(Loss(freedom)).fit(nominal, variables, [seen])
    assert fit.converged
    assert fit.levels[0] == pytest.approx((2.5, 0.4), rel=0.1)
    assert fit.noise == {
        "pose of tool seen from tracker: position (m)": pytest.approx(2.5e-3, rel=0.1),
        "pose of tool seen from tracker: rotation (rad)": pytest.approx(2e-3, rel=0.1),
    }


def test_levels_are_right_with_few_samples(nominal: Body, variables: Variables) -> None:
    """Variables absorb noise; the trace in the update of the levels gives it back."""
    found = []
    for seed in range(20):
        rng = np.random.default_rng(seed)
        truth = nominal.with_variables(variables, drawn(variables, rng, 0.3))
        seen = points(truth, postures(12, truth, rng), rng)
        found.append(Solver(Loss(np.inf)).fit(nominal, variables, [seen]).levels[0][0])
    # 36 numbers for 18 directions that they can tell: without the trace, about 0.7.
    assert np.median(found) == pytest.approx(1.0, abs=0.15)


def test_the_order_of_samples_and_senses_does_not_matter(
    nominal: Body, variables: Variables, senses: list[Sense], rng: np.random.Generator
) -> None:
    fit = Solver().fit(nominal, variables, senses)
    shuffled = [sense.take(rng.permutation(len(sense))) for sense in reversed(senses)]
    other = Solver().fit(nominal, variables, shuffled)
    assert (np.abs(other.x - fit.x) < 1e-6 * fit.std).all()
    assert other.levels[::-1] == tuple(pytest.approx(level, rel=1e-6) for level in fit.levels)


def test_outliers_lose_their_weight(
    nominal: Body, variables: Variables, senses: list[Sense], rng: np.random.Generator
) -> None:
    clean = Solver().fit(nominal, variables, senses)
    mixed = [spoiled(sense, 0.15, 0.2, rng) for sense in senses]
    fit = Solver().fit(nominal, variables, [sense for sense, _ in mixed])
    assert fit.converged
    for weight, (_, bad) in zip(fit.weights, mixed, strict=True):
        assert weight[bad].max() < 0.002
        assert weight[~bad].min() > 0.2
        assert weight[~bad].mean() == pytest.approx(1.15, abs=0.15)
    assert (np.abs(fit.x - clean.x) < 1.5 * clean.std).all()


def test_bounds_are_kept(nominal: Body, rng: np.random.Generator) -> None:
    variables = free_joints(nominal, ["offsets"])
    far = nominal.with_variables(variables, np.array([0.3, -0.3, 0.05, 0.0]))
    seen = points(far, postures(30, far, rng), rng)
    tight = replace(variables, bound=np.full(4, 0.1))
    fit = Solver().fit(nominal, tight, [seen])
    assert (np.abs(fit.x) <= 0.1).all()
    assert np.abs(fit.x).max() == 0.1
    free = Solver().fit(nominal, variables, [seen])
    assert free.x == pytest.approx([0.3, -0.3, 0.05, 0.0], abs=5e-3)


def test_a_large_deviation_is_found_from_zero(nominal: Body, rng: np.random.Generator) -> None:
    variables = free_joints(nominal, ["offsets"]).with_prior(np.full(4, np.inf))
    x = np.array([0.6, -0.5, 0.4, -0.3])
    far = nominal.with_variables(variables, x)
    fit = Solver().fit(nominal, variables, [poses(far, postures(30, far, rng), rng)])
    assert fit.converged
    assert fit.x == pytest.approx(x, abs=2e-3)


def test_exact_samples_are_fitted_exactly(
    nominal: Body, variables: Variables, truth: Body, rng: np.random.Generator
) -> None:
    q = postures(40, truth, rng)
    seen = poses(truth, q, rng).imagined(truth, q)
    body = Solver().fit(nominal, variables, [seen]).body
    assert np.abs(seen.residual(body)).max() < 1e-6


def test_without_parameters_the_levels_are_still_learned(
    nominal: Body, rng: np.random.Generator
) -> None:
    seen = points(nominal, postures(200, nominal, rng), rng, 2e-3)
    fit = Solver(Loss(np.inf)).fit(nominal, free_joints(nominal, ()), [seen])
    assert fit.converged
    assert fit.x.shape == (0,)
    assert fit.covariance.shape == (0, 0)
    assert fit.levels[0] == pytest.approx((1.0,), rel=0.1)


def test_no_samples_are_refused(nominal: Body, senses: list[Sense]) -> None:
    with pytest.raises(InputError, match="not a single sample"):
        Solver().fit(nominal, free_joints(nominal), [])
    with pytest.raises(InputError, match="not a single sample"):
        Solver().fit(nominal, free_joints(nominal), [senses[0].take([])])


def test_an_empty_sense_beside_another_changes_nothing(
    nominal: Body, variables: Variables, senses: list[Sense]
) -> None:
    alone = Solver().fit(nominal, variables, senses[:1])
    beside = Solver().fit(nominal, variables, [senses[0], senses[1].take([])])
    assert beside.levels == (pytest.approx(alone.levels[0], rel=1e-6), (1.0, 1.0))
    assert beside.x == pytest.approx(alone.x, abs=1e-9)


def test_parameters_that_nothing_touches_keep_their_prior(
    nominal: Body, rng: np.random.Generator
) -> None:
    body = nominal.attach("lamp", "base")
    variables = free_frame(body, "lamp", 0.3, 0.7)
    fit = Solver().fit(body, variables, [points(body, postures(9, body, rng), rng)])
    assert (fit.x == 0).all()
    assert fit.std == pytest.approx([0.3] * 3 + [0.7] * 3)
