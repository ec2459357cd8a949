"""The recursive learner as a monitor sees it: slopes, forgetting, evidence, certificate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.estimation.certificate import Tolerance
from bodyschema.estimation.stream_noise import StreamNoise
from bodyschema.learners.filter import Filter
from bodyschema.learners.learner import moments
from bodyschema.learners.watched_body import WatchedBelief, WatchedBody
from simulated import drawn, free_all, points, poses, postures, seen_arm


def learned(seed: int, sense: str = "points", n: int = 150) -> tuple[WatchedBody, WatchedBelief]:
    """A learner and its belief after n samples."""
    rng = np.random.default_rng(seed)
    nominal = seen_arm(4, rng)
    variables = free_all(nominal, turns=sense == "poses")
    truth = nominal.with_variables(variables, drawn(variables, rng, 0.3))
    see = {"points": points, "poses": poses}[sense]
    learner = WatchedBody(nominal, variables, Filter(burn_in=40))
    state = learner.start()
    for moment in moments([see(truth, postures(n, truth, rng), rng)]):
        state, _ = learner.step(state, moment)
    return learner, state


@pytest.mark.parametrize("sense", ["points", "poses"])
def test_the_slope_of_an_innovation_is_its_derivative(sense: str) -> None:
    learner, state = learned(0, sense)
    # Slopes belong to the anchor, so they are compared there.
    state = replace(state, filter=replace(state.filter, x=state.filter.anchor))
    rng = np.random.default_rng(1)
    body = state.filter.reference.with_variables(learner.variables, state.filter.x)
    see = {"points": points, "poses": poses}[sense]
    (moment,) = moments([see(body, postures(1, body, rng), rng)])
    J, h = learner.innovation(state, moment).J, 1e-6
    for k in range(len(learner.variables)):
        step = h * (np.arange(len(learner.variables)) == k)
        # A belief that is less by d than the truth: the truth differs from it by d.
        ahead = replace(state, filter=replace(state.filter, x=state.filter.x - step))
        back = replace(state, filter=replace(state.filter, x=state.filter.x + step))
        slope = (learner.innovation(ahead, moment).e - learner.innovation(back, moment).e) / (2 * h)
        assert slope == pytest.approx(J[:, k], rel=1e-4, abs=1e-3 * np.abs(J).max())


def test_blocks_are_joint_zeros_and_frames() -> None:
    learner, _ = learned(0)
    names = learner.variables.names
    assert {n for rows in learner.blocks.values() for n in (names[i] for i in rows)} == set(names)
    assert set(learner.blocks) == {*learner.body.joints, "tracker", "tool"}


def test_forgetting_a_block_keeps_what_is_known_of_the_rest() -> None:
    learner, state = learned(2)
    rows = learner.blocks["tracker"]
    rest = np.setdiff1d(np.arange(len(learner.variables)), rows)
    before = np.linalg.inv(state.filter.information)
    after = np.linalg.inv(learner.forget(state, "tracker").filter.information)
    tau = max(state.noise.long_run, 1.0)
    expected = tau * before[np.ix_(rest, rest)]
    assert after[np.ix_(rest, rest)] == pytest.approx(expected, rel=1e-6)
    assert np.diag(after)[rows] == pytest.approx(learner.variables.prior_std[rows] ** 2)
    assert after[np.ix_(rest, rows)] == pytest.approx(0, abs=1e-12)


def test_evidence_of_an_unchanged_body_is_one_a_row() -> None:
    learner, state = learned(3, n=250)
    fresh = learner.forget(state, "")
    rng = np.random.default_rng(9)
    body = state.filter.estimate.body
    for moment in moments([points(body, postures(200, body, rng), rng)]):
        fresh, _ = learner.step(fresh, moment)
    belief = learner.belief(fresh)
    assert belief.cost == pytest.approx(belief.rows, rel=0.25)
    assert belief.explains


def test_the_certificate_waits_for_the_tolerance() -> None:
    learner, state = learned(4)
    bound = learner.certificate(state).bounds["position"]
    loose = replace(learner, tolerance=Tolerance({"position": 1.1 * bound}))
    tight = replace(learner, tolerance=Tolerance({"position": 0.9 * bound}))
    assert loose.certificate(state).holds
    assert not tight.certificate(state).holds
    assert "position is known to" in tight.certificate(state).missing[0]
    assert not learner.certificate(learner.start()).holds


def test_outliers_are_counted_and_left_out() -> None:
    rng = np.random.default_rng(0)
    noise = StreamNoise()
    for _ in range(500):
        e = 2 * rng.normal(size=3)
        noise = noise.learn(e, None, float(e @ e))
    spoiled = noise.learn(np.full(3, 100.0), None, 3e4)
    assert noise.level == pytest.approx(4, rel=0.15)
    assert spoiled.level == noise.level
    assert spoiled.outliers == noise.outliers + 1
    assert spoiled.recent > noise.recent
