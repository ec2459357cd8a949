"""The gate: outliers that hide one another, and the noise of those that are left."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.estimation.gate import Residuals
from bodyschema.estimation.loss import Loss
from bodyschema.estimation.solver import Solver
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from simulated import drawn, free_all, points, postures, seen_arm, spoiled

Array = NDArray[np.float64]


@pytest.fixture
def body() -> Body:
    return seen_arm(4, np.random.default_rng(0))


@pytest.fixture
def variables(body: Body) -> Variables:
    return free_all(body, ("offsets",), turns=False)


def stretched(nu: float, n: int, rng: np.random.Generator) -> Array:
    """Lengths that noise of the family is stretched by, (n,)."""
    return np.sqrt(nu / rng.chisquare(nu, n)) if np.isfinite(nu) else np.ones(n)


@pytest.mark.parametrize(
    ("nu", "low", "high"), [(2.5, 1.7, 4.0), (6.0, 3.9, 11.0), (np.inf, 40, 1e3)]
)
def test_the_tails_of_a_sense_are_found(nu: float, low: float, high: float) -> None:
    rng = np.random.default_rng(1)
    z = rng.normal(size=(600, 6)) * [2, 2, 2, 0.3, 0.3, 0.3] * stretched(nu, 600, rng)[:, None]
    squared = np.stack([np.sum(z[:, :3] ** 2, axis=1), np.sum(z[:, 3:] ** 2, axis=1)], axis=1)
    left = Residuals(squared, 6, np.ones(600), np.full(2, 1800.0), np.full(2, -7.0))
    found, theta = left.asked(np.zeros(2))
    assert low <= found <= high
    assert np.exp(theta) == pytest.approx([2.0, 0.3], rel=0.08)


@pytest.mark.parametrize("share", [0.15, 0.3])
def test_many_outliers_do_not_hide_one_another(
    share: float, body: Body, variables: Variables
) -> None:
    for seed in range(4):
        rng = np.random.default_rng(seed)
        truth = body.with_variables(variables, drawn(variables, rng, 0.3))
        seen, bad = spoiled(points(truth, postures(100, body, rng), rng), share, 0.06, rng)
        fit = Solver().fit(body, variables, [seen])
        assert (fit.outliers[0] == bad).all()
        assert (fit.weights[0][bad] == 0).all()
        assert fit.levels[0][0] == pytest.approx(1.0, rel=0.2)


def test_a_loss_that_does_not_adapt_names_them_and_takes_nothing_out(
    body: Body, variables: Variables
) -> None:
    rng = np.random.default_rng(2)
    seen, bad = spoiled(points(body, postures(60, body, rng), rng), 0.1, 0.1, rng)
    fit = Solver(Loss(adapt=False)).fit(body, variables, [seen])
    assert (fit.outliers[0] == bad).all()
    assert (fit.weights[0] > 0).all()
    assert fit.freedom == (4.0,)
    normal = Solver(Loss(np.inf)).fit(body, variables, [seen])
    assert normal.freedom == (np.inf,)
    assert (normal.weights[0] == 1).all()


def test_each_sense_has_tails_of_its_own(body: Body, variables: Variables) -> None:
    rng = np.random.default_rng(3)
    body = body.attach("elbow", "link_2")
    q = postures(300, body, rng)
    calm, wild = points(body, q, rng), points(body, q + 1.0, rng, 1e-9, "tracker", "elbow")
    noise = 1e-3 * rng.normal(size=(300, 3)) * stretched(2.5, 300, rng)[:, None]
    wild = replace(wild, observed=wild.observed + noise, covariance=1e-6 * np.eye(3))
    fit = Solver().fit(body, variables, [calm, wild])
    assert fit.freedom[0] > 20
    assert fit.freedom[1] < 5


def test_of_a_few_samples_nothing_is_said(body: Body, variables: Variables) -> None:
    rng = np.random.default_rng(4)
    fit = Solver().fit(body, variables, [points(body, postures(4, body, rng), rng)])
    assert fit.freedom == (4.0,)
