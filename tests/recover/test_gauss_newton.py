"""The recursive learner: as good as the batch, honest, forgetful where told to, hard to upset."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.estimation.loss import Loss
from bodyschema.estimation.problem import Problem
from bodyschema.estimation.solver import Solver
from bodyschema.learners.filter import Belief, Filter
from bodyschema.learners.learner import run
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_joints
from bodyschema.senses.sense import Sense
from simulated import drawn, forgotten, free_all, points, poses, postures, seen_arm, spoiled

Array = NDArray[np.float64]
SENSES = {"points": points, "poses": poses}
SEEDS = 12
ENDS = ("tracker", "tool")


def learned(learner: Filter, state: Belief, senses: Sequence[Sense]) -> Belief:
    """The belief after all samples."""
    for after, _ in run(learner, state, senses):
        state = after
    return state


def tool_error(body: Body, truth: Body, rng: np.random.Generator) -> float:
    """rms distance (m) of the tool as predicted, at 100 fresh postures."""
    q = postures(100, truth, rng)
    gap = (relative_pose(body, q, *ENDS) - relative_pose(truth, q, *ENDS))[:, :3, 3]
    return float(np.sqrt(np.mean(np.sum(gap**2, axis=1))))


ENDS = ("tracker", "tool")


def started(body: Body, variables: Variables, sense: Sense) -> Belief:
    """A belief that needs no burn-in and keeps its noise levels."""
    levels = {sense.label: ((1.0,) * len(sense.components), 1e12)}
    return replace(Filter().start(body, variables), levels=levels, started=True)


@pytest.mark.parametrize("sense", SENSES)
def test_one_pass_from_unknown_frames_is_as_good_as_the_batch(sense: str) -> None:
    recursive, batch = [], []
    for seed in range(SEEDS):
        rng = np.random.default_rng(seed)
        nominal = seen_arm(5 + seed % 2, rng)
        offsets = free_joints(nominal, ["offsets"])
        truth = nominal.with_variables(offsets, drawn(offsets, rng, 0.5))
        seen = SENSES[sense](truth, postures(100, truth, rng), rng)
        blind = forgotten(nominal, ENDS)
        same = Solver(Loss(adapt=False))
        problem = Problem(blind, (seen,), dict.fromkeys(ENDS, "no"), blind.joints, same)
        variables = problem.variables(["offsets"])
        learner = Filter(unknown=problem.unknown)
        state = learned(learner, learner.start(blind, variables), [seen])
        recursive.append(tool_error(state.estimate.body, truth, rng))
        batch.append(tool_error(problem.fit(variables, [seen]).body, truth, rng))
    assert np.sqrt(np.mean(np.square(recursive))) < 1.1 * np.sqrt(np.mean(np.square(batch)))
    assert np.max(np.array(recursive) / batch) < 1.5


@pytest.mark.parametrize("sense", SENSES)
def test_gaussian_steps_equal_the_gaussian_batch_where_the_body_is_nearly_linear(
    sense: str,
) -> None:
    rng = np.random.default_rng(1)
    nominal = seen_arm(5, rng)
    variables = free_all(nominal, turns=sense == "poses")
    variables = variables.with_prior(0.02 * variables.prior_std)
    truth = nominal.with_variables(variables, drawn(variables, rng))
    seen = SENSES[sense](truth, postures(60, truth, rng), rng)
    batch = Solver(Loss(np.inf), learn_levels=False).fit(nominal, variables, [seen])
    learner = Filter(freedom=np.inf)
    state = learned(learner, started(nominal, variables, seen), [seen])
    std = batch.std
    assert (np.abs(state.x - batch.x) < 0.03 * std).all()
    assert state.estimate.std == pytest.approx(std, rel=0.02)
    assert state.levels[seen.label][0] == pytest.approx(batch.levels[0], rel=1e-6)


@pytest.mark.parametrize("sense", SENSES)
def test_a_moving_estimate_does_not_make_the_learner_sure_of_what_it_cannot_see(
    sense: str,
) -> None:
    """An offset of joint 1 and the tracker's turn go together for ever: std as in the batch."""
    squares = []
    for seed in range(SEEDS):
        rng = np.random.default_rng(seed)
        nominal = seen_arm(5, rng)
        variables = free_all(nominal, turns=sense == "poses")
        x = drawn(variables, rng)
        truth = nominal.with_variables(variables, x)
        seen = SENSES[sense](truth, postures(100, truth, rng), rng)
        learner = Filter()
        estimate = learned(learner, learner.start(nominal, variables), [seen]).estimate
        batch = Solver().fit(nominal, variables, [seen])
        assert (estimate.std > 0.8 * batch.std).all()
        squares.append(np.mean(((estimate.x - x) / estimate.std) ** 2))
    assert np.mean(squares) < 1.5


def test_the_order_of_samples_matters_little() -> None:
    """Measured: rms 0.1, at most 0.6 posterior standard deviations of a parameter (poses)."""
    rms, largest = [], []
    for seed in range(SEEDS):
        rng = np.random.default_rng(seed)
        nominal = seen_arm(5, rng)
        variables = free_all(nominal)
        truth = nominal.with_variables(variables, drawn(variables, rng, 0.5))
        seen = poses(truth, postures(150, truth, rng), rng)
        shuffled = replace(seen.take(rng.permutation(150)), time=seen.time)
        learner = Filter()
        one, other = (
            learned(learner, learner.start(nominal, variables), [sense])
            for sense in (seen, shuffled)
        )
        change = (one.x - other.x) / one.estimate.std
        rms.append(np.sqrt(np.mean(change**2)))
        largest.append(np.abs(change).max())
    assert np.median(rms) < 0.15
    assert np.max(largest) < 0.8


@pytest.fixture
def arm() -> tuple[Body, Variables]:
    """Five joints with offsets; the tracker and the tool are known."""
    nominal = seen_arm(5, np.random.default_rng(0))
    return nominal, free_joints(nominal, ["offsets"])


def test_forgetting_leaves_the_prior_in_what_is_not_seen(arm: tuple[Body, Variables]) -> None:
    """Only the last joint moves and is looked at from its own link, for 3000 samples."""
    nominal, variables = arm
    rng = np.random.default_rng(0)
    q = np.zeros((3000, 5))
    q[:, 4] = rng.uniform(-1, 1, 3000)
    seen = points(nominal, q, rng, seen_from="link_4")
    learner = Filter(forgetting=0.98)
    start = learner.start(nominal, variables)
    for after, _ in run(learner, start, [seen]):
        assert (after.estimate.std <= variables.prior_std * (1 + 1e-9)).all()
    std = after.estimate.std
    assert std[:4] == pytest.approx(variables.prior_std[:4], rel=1e-6)
    # About 1 / (1 - 0.98) samples stay: neither frozen nor wound up.
    fresh = learned(Filter(), start, [seen.take(range(50))])
    assert std[4] == pytest.approx(fresh.estimate.std[4], rel=0.4)


@pytest.mark.parametrize("freedom", [4.0, np.inf])
def test_forgetting_follows_an_offset_that_changes(
    freedom: float, arm: tuple[Body, Variables]
) -> None:
    nominal, variables = arm
    rng = np.random.default_rng(2)
    slip = np.array([0, 0, 0.05, 0, 0])
    q = postures(600, nominal, rng)
    before = points(nominal, q[:200], rng)
    after = points(nominal.with_variables(variables, slip), q[200:], rng)
    errors = {}
    for forgetting in (1.0, 0.97):
        learner = Filter(freedom=freedom, forgetting=forgetting)
        state = learned(learner, learner.start(nominal, variables), [before])
        assert (np.abs(state.x) < 4 * state.estimate.std).all()
        state = learned(learner, state, [after])
        errors[forgetting] = np.abs(state.x - slip)
    assert (errors[0.97] < 4 * state.estimate.std).all()
    assert errors[0.97].max() < 4e-3
    assert errors[1.0].max() > 3 * errors[0.97].max()


@pytest.mark.parametrize("size", [0.05, 0.2, 5.0])
@pytest.mark.parametrize("sense", SENSES)
def test_one_outlier_barely_moves_the_state(
    sense: str, size: float, arm: tuple[Body, Variables]
) -> None:
    nominal, variables = arm
    rng = np.random.default_rng(3)
    seen = SENSES[sense](nominal, postures(61, nominal, rng), rng)
    learner = Filter()
    state = learned(learner, learner.start(nominal, variables), [seen.take(range(60))])
    outlier, _ = spoiled(seen.take([60]), 1.0, size, rng)
    after, (info,) = learner.step(state, (outlier,))
    assert info.weight < 0.01
    assert info.surprise > 100
    assert (np.abs(after.x - state.x) < 0.1 * state.estimate.std).all()
    assert after.levels[seen.label][0] == pytest.approx(state.levels[seen.label][0], rel=0.1)
    trusting, _ = replace(learner, freedom=np.inf).step(state, (outlier,))
    moved = np.linalg.norm(after.x - state.x) / np.linalg.norm(trusting.x - state.x)
    assert moved < 0.02


def test_a_good_sample_says_what_it_was_worth(arm: tuple[Body, Variables]) -> None:
    nominal, variables = arm
    rng = np.random.default_rng(4)
    seen = poses(nominal, postures(400, nominal, rng), rng)
    learner = Filter(freedom=np.inf)
    infos = [info for _, (info,) in run(learner, learner.start(nominal, variables), [seen])]
    assert all(np.isnan(info.surprise) and info.weight == 0 for info in infos[:12])
    assert np.mean([info.surprise for info in infos[12:]]) == pytest.approx(6, rel=0.1)
    assert all(info.weight == 1 for info in infos[12:])
    assert infos[-1].residual.shape == (6,)
