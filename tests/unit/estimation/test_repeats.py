"""Repeated postures: the correlation that they show, and beliefs that stay honest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.estimation.descent import begin
from bodyschema.estimation.objective import Objective
from bodyschema.estimation.prediction import degrees_of_freedom, predict_error
from bodyschema.estimation.repeats import worth
from bodyschema.estimation.solver import Solver
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_joints
from bodyschema.senses.points import Points
from simulated import drawn, free_all, points, postures, seen_arm

Array = NDArray[np.float64]


def repeated(
    body: Body, n: int, m: int, by_posture: float, by_sample: float, rng: np.random.Generator
) -> Points:
    """m samples in each of n postures, with an error (m) of each posture and of each sample."""
    q = np.repeat(postures(n, body, rng), m, axis=0)
    seen = points(body, q, rng, by_sample)
    shift = np.repeat(by_posture * rng.normal(size=(n, 3)), m, axis=0)
    return replace(seen, observed=seen.observed + shift)


@pytest.mark.parametrize(
    ("by_posture", "rho"), [(0.0, 0.0), (0.5e-3, 0.2), (1e-3, 0.5), (4e-3, 0.94)]
)
def test_a_sample_is_worth_what_its_correlation_leaves(by_posture: float, rho: float) -> None:
    rng = np.random.default_rng(0)
    body = seen_arm(4, rng)
    seen = repeated(body, 200, 5, by_posture, 1e-3, rng)
    objective = Objective(body, free_joints(body, ()), (seen,), (np.ones(1000),), (np.inf,))
    theta = np.log([np.hypot(by_posture, 1e-3) / 1e-3])
    (u,) = worth(objective, begin(objective, np.zeros(0), theta), 1e-4)
    assert u == pytest.approx(np.full(1000, 1 / (1 + 4 * rho)), rel=0.12)


def test_markers_of_one_picture_are_counted_together() -> None:
    rng = np.random.default_rng(0)
    body = seen_arm(4, rng).attach("other", "tool")
    seen = repeated(body, 100, 1, 3e-3, 1e-6, rng)
    twin = replace(seen, seen="other")
    alone = replace(seen, seen_from="base", seen="link_1", q=seen.q + 1)
    senses = (seen, twin, alone)
    ones = tuple(np.ones(100) for _ in senses)
    objective = Objective(body, free_joints(body, ()), senses, ones, (np.inf,) * 3)
    theta = np.log([3.0, 3.0, 300.0])
    found = worth(objective, begin(objective, np.zeros(0), theta), 1e-4)
    assert found[0] == pytest.approx(0.5 * np.ones(100), abs=0.05)
    assert (found[1] == found[0]).all()
    assert (found[2] == 1).all()


def test_a_posture_that_the_variables_explain_says_nothing_of_it() -> None:
    """Six frames of one posture: whatever error they share goes into the tracker's place."""
    rng = np.random.default_rng(0)
    body = seen_arm(4, rng)
    variables = free_all(body, (), turns=False)
    fit = Solver().fit(body, variables, [repeated(body, 1, 6, 3e-3, 1e-3, rng)])
    assert fit.converged
    assert (fit.weights[0] > 0.3).all()


@pytest.mark.parametrize(("n", "m"), [(15, 7), (20, 30)])
def test_beliefs_of_repeated_postures_are_honest(n: int, m: int) -> None:
    within, in_full = [], []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        nominal = seen_arm(5, rng)
        variables = free_all(nominal, turns=False)
        truth = nominal.with_variables(variables, drawn(variables, rng, 0.3))
        seen = repeated(truth, n, m, 1e-3, 0.5e-3, rng)
        apart = replace(seen, q=seen.q + 1e-9 * rng.normal(size=seen.q.shape))
        for found, solver, sense in (
            (within, Solver(), seen),
            (in_full, Solver(same_posture=1e-13), apart),
        ):
            fit = solver.fit(nominal, variables, [sense])
            fresh = postures(40, truth, rng)
            said = predict_error(fit, fresh, "tracker", "tool", degrees_of_freedom(fit, [sense]))
            there, true = (
                relative_pose(b, fresh, "tracker", "tool")[:, :3, 3] for b in (fit.body, truth)
            )
            found.append(np.mean(np.linalg.norm(there - true, axis=1) < said.position))
    assert 0.88 < np.mean(within) <= 1.0
    assert np.mean(in_full) < 0.6
