"""Online learners as fits: what each can learn from one pass, and what it says of itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.answers.calibrate import calibrate
from bodyschema.judging.one_pass import fit_at, fitting
from bodyschema.errors import InputError
from bodyschema.estimation.problem import Problem
from bodyschema.model.variables import free_joints
from simulated import drawn, forgotten, points, postures, seen_arm

UNKNOWN = {"tracker": "no", "tool": "no"}
ONE_PASS = ("gauss-newton", "smoother", "online-gradient")


def problem_of(groups, n=120, seed=0):
    """A problem whose arm is wrong in some groups, and the true body."""
    rng = np.random.default_rng(seed)
    nominal = seen_arm(4, rng)
    wrong = free_joints(nominal, groups)
    truth = nominal.with_variables(wrong, drawn(wrong, rng, 0.5))
    seen = points(truth, postures(n, truth, rng), rng)
    body = forgotten(nominal, UNKNOWN)
    return Problem(body, (seen,), UNKNOWN, body.joints), truth


def error(body, problem):
    """rms of what is seen, m."""
    [sense] = problem.senses
    return float(np.sqrt(np.mean(np.sum(sense.residual(body) ** 2, axis=1))))


@pytest.mark.parametrize("learner", ["gauss-newton", "smoother"])
def test_one_pass_comes_close_to_the_batch(learner):
    problem, _ = problem_of(["offsets"])
    variables = problem.variables(("offsets",))
    batch = problem.fit(variables, problem.senses)
    online = fitting(problem, learner)(variables, problem.senses)
    assert error(online.body, problem) < 1.03 * error(batch.body, problem)
    away = np.abs(online.body.offset - batch.body.offset)
    std = np.sqrt(np.diag(batch.covariance)[:4])
    assert (away < 3 * std).all()
    [(level,)] = online.levels
    [(batch_level,)] = batch.levels
    assert level == pytest.approx(batch_level, rel=0.25)


def test_the_gradient_improves_axes_and_links_and_says_that_it_has_not_arrived():
    problem, _ = problem_of(["axes", "links"])
    begun = problem.fit(problem.variables(()), [problem.senses[0].take(range(12))])
    variables = problem.variables(("axes", "links"))
    found = fitting(problem, "online-gradient")(variables, problem.senses)
    assert error(found.body, problem) < 0.7 * error(begun.body, problem)
    assert not found.converged


def test_the_gradient_refuses_what_it_cannot_learn():
    problem, _ = problem_of(["offsets"], n=30)
    with pytest.raises(InputError, match="no joint axis and no link vector"):
        calibrate(problem.body, problem.senses, UNKNOWN, ["offsets"], learner="online-gradient")


@pytest.fixture(scope="module")
def judged():
    """A problem with wrong axes and links, and how the batch does on it."""
    problem, _ = problem_of(["axes", "links"], n=60)
    free = ["axes", "links"]
    return problem, free, calibrate(problem.body, problem.senses, UNKNOWN, free, folds=3)


@pytest.mark.parametrize("learner", ONE_PASS)
def test_every_learner_is_judged_by_the_same_test(learner, judged):
    problem, free, batch = judged
    online = calibrate(problem.body, problem.senses, UNKNOWN, free, folds=3, learner=learner)
    assert (batch.learner, online.learner) == ("batch", learner)
    # What stands before is the robot as modelled, whoever learns.
    assert online.nominal.position.rms == pytest.approx(batch.nominal.position.rms, rel=0.05)
    assert len(online.residuals[0]) == 60
    # A learner that does not help is refused, not written.
    helps = online.held_out.position.rms <= min(
        online.nominal.position.rms, online.candidates[0].accuracy.position.rms
    )
    assert (online.verdict == "calibrated") == helps


def test_one_pass_is_repeatable():
    problem, _ = problem_of(["offsets"], n=40)
    variables = problem.variables(("offsets",))
    for learner in ("gauss-newton", "smoother"):
        first, second = (fitting(problem, learner)(variables, problem.senses) for _ in range(2))
        assert np.array_equal(first.x, second.x)


def test_a_fit_at_the_optimum_has_arrived_and_states_the_noise():
    problem, _ = problem_of(["offsets"])
    variables = problem.variables(("offsets",))
    batch = problem.fit(variables, problem.senses)
    best = batch
    there = fit_at(problem, best.reference, best.body, variables, problem.senses)
    assert there.converged
    assert there.x == pytest.approx(best.x, abs=1e-12)
    # Median against expectation-maximisation: other statistics of the same noise.
    assert there.levels[0][0] == pytest.approx(batch.levels[0][0], rel=0.25)
    x = best.x.copy()
    x[0] += 20 * best.std[0]
    away = best.reference.with_variables(variables, x)
    assert not fit_at(problem, best.reference, away, variables, problem.senses).converged


def test_samples_that_come_late_in_a_sense_of_their_own_are_learned():
    """A sense that a fold has lost keeps its place in the fit."""
    problem, _ = problem_of(["offsets"], n=40)
    [sense] = problem.senses
    other = replace(sense, seen="tip").take([])
    found = fitting(problem, "gauss-newton")(problem.variables(("offsets",)), [sense, other])
    assert len(found.levels) == len(found.weights) == 2
    assert len(found.weights[1]) == 0
