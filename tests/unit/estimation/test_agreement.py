"""Held-out errors lie within their 95 % bounds in 95 of 100 cases, when the model is right."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.estimation.agreement import within_prediction
from bodyschema.estimation.loss import Loss
from bodyschema.estimation.solver import Solver
from simulated import POSE_STD, drawn, free_all, poses, postures, seen_arm


def test_the_share_within_is_the_probability() -> None:
    rng = np.random.default_rng(4)
    arm = seen_arm(4, rng)
    variables = free_all(arm)
    truth = arm.with_variables(variables, drawn(variables, rng, 0.5))
    training = poses(truth, postures(60, arm, rng), rng)
    test = poses(truth, postures(800, arm, rng), rng)
    learner = Solver(Loss(np.inf))
    fit = learner.fit(arm, variables, [training])
    residual = test.residual(fit.body)
    found = within_prediction(fit, test, fit.levels[0], residual, np.inf)
    assert set(found) == {"position", "rotation"}
    for inside in found.values():
        assert np.mean(inside) == pytest.approx(0.95, abs=0.03)
    narrow = within_prediction(fit, test, fit.levels[0], residual, np.inf, 0.5)
    assert np.mean(narrow["position"]) == pytest.approx(0.5, abs=0.06)


def test_errors_that_the_model_lacks_fall_outside() -> None:
    rng = np.random.default_rng(5)
    arm = seen_arm(3, rng)
    variables = free_all(arm)
    seen = poses(arm, postures(40, arm, rng), rng)
    fit = Solver().fit(arm, variables, [seen])
    residual = seen.residual(fit.body) + 10 * POSE_STD[0]
    inside = within_prediction(fit, seen, fit.levels[0], residual, 4.0)
    assert np.mean(inside["position"]) < 0.05
