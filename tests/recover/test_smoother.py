"""The smoother: as good as the batch, honest, hard to upset, and able to forget one part."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from bodyschema.estimation import huber
from bodyschema.estimation.loss import Loss
from bodyschema.estimation.solver import Solver
from bodyschema.learners import smoother
from bodyschema.learners.learner import run
from bodyschema.learners.smoother import Smoothed, Smoother, foresee
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.sense import Sense
from bodyschema.studies.held_tool import TIP, Scene, Setting, arm, freed
from simulated import drawn, free_all, points, poses, postures, seen_arm, spoiled

CLEAN = Setting(noise=0.05, outliers=0.0, motion="independent", arm_error=1.0)
ROUGH = replace(CLEAN, outliers=0.05)


def learned(learner: Smoother, state: Smoothed, *senses: Sense) -> Smoothed:
    for after, _ in run(learner, state, senses):
        state = after
    return state


def tip_error(scene: Scene, state: Smoothed) -> float:
    return scene.miss(state.body, scene.places(0, TIP), TIP)


@pytest.mark.parametrize("n", [5, 16, 120])
def test_with_normal_noise_it_is_the_batch(n: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Both senses of one arm; no sample counts as an outlier, and each solution is exact."""
    monkeypatch.setattr(huber, "CLIPPED", 1e-12)
    monkeypatch.setattr(huber, "GROSS", 1e-14)
    monkeypatch.setattr(smoother, "SETTLED", 1e-6)
    rng = np.random.default_rng(0)
    nominal = seen_arm(4, rng)
    variables = free_all(nominal)
    variables = variables.with_prior(0.05 * variables.prior_std)
    truth = nominal.with_variables(variables, drawn(variables, rng))
    seen = [points(truth, postures(n, truth, rng), rng, seen="tip")]
    seen.append(poses(truth, postures(n, truth, rng), rng))
    learner = Smoother()
    state = learned(learner, learner.start(nominal, variables), *seen)
    batch = Solver(Loss(np.inf), learn_levels=False).fit(nominal, variables, seen)
    assert (np.abs(state.x - batch.x) < 0.05 * batch.std).all()
    assert state.estimate.std == pytest.approx(batch.std, rel=0.02)
    assert len(state.window) == min(2 * n, 32) == sum(map(len, state.window.batches))


@pytest.mark.parametrize("setting", [CLEAN, ROUGH], ids=["clean", "outliers"])
def test_its_error_bars_are_right_and_its_error_is_near_the_least_possible(
    setting: Setting,
) -> None:
    """NEES over runs is chi-square with as many degrees as parameters in all."""
    nees, tips, bounds, runs = [], [], [], 8
    for seed in range(runs):
        scene = setting.scene(np.random.default_rng(seed), 250)
        state = learned(Smoother(), Smoother().start(arm(), freed(True)), scene.seen)
        gap = state.x - scene.before
        # The stick is no draw from the prior of the tip; 0.34 m is too near its mean length.
        nees.append(gap @ state.total @ gap)
        tips.append(tip_error(scene, state))
        bounds.append(scene.bound(True, 250))
    low, high = chi2.ppf([0.005, 0.995], runs * len(freed(True)))
    assert low < sum(nees) < high * (1 if setting is CLEAN else 1.1)
    assert np.sqrt(np.mean(np.square(tips))) < 1.25 * np.sqrt(np.mean(np.square(bounds)))


@pytest.mark.parametrize("size", [0.3, 3.0])
def test_a_first_sample_that_is_an_outlier_is_overruled(size: float) -> None:
    rng = np.random.default_rng(3)
    scene = CLEAN.scene(rng, 40)
    first, _ = spoiled(scene.seen.take([0]), 1.0, size, rng)
    learner = Smoother()
    start = learner.start(arm(), freed(False))
    spoilt = learned(learner, start, first)
    assert tip_error(scene, spoilt) > 0.2
    spoilt = learned(learner, spoilt, scene.seen.take(range(1, 12)))
    clean = learned(learner, start, scene.seen.take(range(1, 12)))
    assert np.linalg.norm(spoilt.x - clean.x) < 0.02
    # Once it has left the window it has taught nothing.
    spoilt = learned(learner, spoilt, scene.seen.take(range(12, 40)))
    clean = learned(learner, clean, scene.seen.take(range(12, 40)))
    assert np.linalg.norm(spoilt.x - clean.x) < 1e-3
    assert spoilt.total == pytest.approx(clean.total, rel=0.02, abs=1.0)


def test_it_does_not_grow_sure_of_what_no_motion_tells() -> None:
    """The zero of joint 1 and the tracker's turn go together for ever: std as in the batch."""
    for seed in range(3):
        rng = np.random.default_rng(seed)
        nominal = seen_arm(4, rng)
        variables = free_all(nominal)
        x = drawn(variables, rng, 0.3)
        truth = nominal.with_variables(variables, x)
        seen = poses(truth, postures(100, truth, rng), rng)
        learner = Smoother()
        estimate = learned(learner, learner.start(nominal, variables), seen).estimate
        batch = Solver(Loss(np.inf), learn_levels=False).fit(nominal, variables, [seen])
        assert (estimate.std > 0.9 * batch.std).all()
        assert np.abs((estimate.x - x) / estimate.std).max() < 4.5


def test_a_sample_is_foreseen_with_its_variance() -> None:
    """Innovations are white: mean square 3, whatever was known."""
    squares = []
    for seed in range(8):
        scene = CLEAN.scene(np.random.default_rng(seed), 100)
        state = Smoother().start(arm(), freed(True))
        for _, (seen,) in run(Smoother(), state, [scene.seen]):
            squares.append(seen.surprise)
    assert np.mean(squares) == pytest.approx(3, abs=0.3)


@pytest.mark.parametrize("n", [10, 60])
def test_forgetting_keeps_what_is_known_of_the_rest(n: int) -> None:
    scene = ROUGH.scene(np.random.default_rng(1), n)
    learner = Smoother()
    state = learner.absorbing(learned(learner, learner.start(arm(), freed(True)), scene.seen))
    rows = np.array([20, 21, 22])
    after = learner.forgetting(state, rows, 0.3, tau=2.0)
    rest = np.setdiff1d(np.arange(len(state.x)), rows)
    expected = 2.0 * state.estimate.covariance[np.ix_(rest, rest)]
    found = after.estimate.covariance
    np.testing.assert_allclose(found[np.ix_(rest, rest)], expected, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(found[np.ix_(rows, rows)], 0.09 * np.eye(3), rtol=1e-6, atol=1e-12)
    assert (after.x == state.x).all()
    # The mean is where the information says it is: a sample as predicted moves nothing.
    ideal = scene.seen.imagined(state.body, scene.fresh[:1])
    moved, _ = learner.step(after, (ideal,))
    assert np.abs((moved.x - state.x) / state.estimate.std).max() < 1e-6


def test_prediction_of_a_known_body_is_that_of_the_body() -> None:
    scene = CLEAN.scene(np.random.default_rng(0), 1)
    seen = foresee(Smoother().start(arm(), freed(True)), scene.seen)
    hand = relative_pose(arm(), scene.seen.q, "camera", "r_hand")[0, :3, 3]
    np.testing.assert_allclose(seen.residual, scene.seen.position[0] - hand, atol=1e-12)
