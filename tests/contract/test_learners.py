"""What every learner of a body must keep: a new one joins by one line in LEARNERS.

What holds for all that steps, learners of images and loads too, is in `test_steppers`.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.learners.filter import Filter
from bodyschema.learners.learner import BodyLearner, moments, run
from bodyschema.learners.published.online_gradient import OnlineGradient
from bodyschema.learners.replay import Replay
from bodyschema.learners.skeletons.pool import Pool
from bodyschema.learners.smoother import Smoother
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, join
from bodyschema.senses.sense import Sense
from same import same
from simulated import drawn, free_all, points, poses, postures, seen_arm

Array = NDArray[np.float64]

LEARNERS: dict[str, BodyLearner[Any, Any]] = {
    "gauss_newton": Filter(),
    "gauss_newton_forgetting": Filter(forgetting=0.99),
    "smoother": Smoother(),
    "online_gradient": OnlineGradient(1.0, "normalised"),
    "replay": Replay(size=15),
    "pool": Pool(),
}
"""Name -> settings."""

SKELETON_ONLY = (OnlineGradient, Replay, Pool)
"""Learners of axes and links, from points alone."""

WITHOUT_COVARIANCE = (OnlineGradient, Replay)
"""Learners that state no uncertainty."""

LEFT = {"online_gradient": 0.25}
"""Share of the error that may be left, where it is more than 0.05: one pass is too few for some."""

POINTS, POSES = 25, 35


@pytest.fixture(scope="module", params=LEARNERS)
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def learner(name: str) -> BodyLearner[Any, Any]:
    return LEARNERS[name]


@pytest.fixture(scope="module")
def nominal() -> Body:
    return seen_arm(4, np.random.default_rng(0))


@pytest.fixture(scope="module")
def variables(learner: BodyLearner[Any, Any], nominal: Body) -> Variables:
    if isinstance(learner, SKELETON_ONLY):
        tool = free_frame(nominal, "tool", turn_std=None)
        return join(free_joints(nominal, ("axes", "links")), tool)
    return free_all(nominal)


@pytest.fixture(scope="module")
def truth(nominal: Body, variables: Variables) -> Body:
    return nominal.with_variables(variables, drawn(variables, np.random.default_rng(1), 0.5))


@pytest.fixture(scope="module")
def senses(learner: BodyLearner[Any, Any], truth: Body) -> list[Sense]:
    """The tip every 0.7 s, the tool's pose every 0.5 s: moments interleave, and some coincide."""
    rng = np.random.default_rng(2)
    seen = points(truth, postures(POINTS, truth, rng), rng, seen="tip")
    look = points if isinstance(learner, SKELETON_ONLY) else poses
    return [_timed(seen, 0.7), _timed(look(truth, postures(POSES, truth, rng), rng), 0.5)]


def _timed(sense: Sense, step: float) -> Sense:
    return replace(sense, time=np.round(step * np.arange(len(sense)), 1))


def test_run_gives_one_state_a_moment_in_time_order(
    learner: BodyLearner[Any, Any], nominal: Body, variables: Variables, senses: list[Sense]
) -> None:
    steps = list(run(learner, learner.start(nominal, variables), senses))
    fed = moments(senses)
    times = [float(moment[0].time[0]) for moment in fed]
    assert times == sorted(set(np.concatenate([sense.time for sense in senses]).tolist()))
    assert len(steps) == len(fed)
    assert [len(info) for _, info in steps] == [len(moment) for moment in fed]
    # Within a moment, senses come in the order in which they were given.
    (both,) = [moment for moment in fed if moment[0].time[0] == 3.5]
    assert [sample.seen for sample in both] == ["tip", "tool"]
    state = learner.start(nominal, variables)
    for moment, (expected, _) in zip(fed, steps, strict=True):
        state, _ = learner.step(state, moment)
        assert same(state, expected)


def test_it_learns(
    name: str,
    learner: BodyLearner[Any, Any],
    nominal: Body,
    variables: Variables,
    senses: list[Sense],
    truth: Body,
) -> None:
    *_, (state, _) = run(learner, learner.start(nominal, variables), senses)
    taught = state.body if isinstance(learner, SKELETON_ONLY) else state.estimate.body
    q = postures(100, truth, np.random.default_rng(3))
    true, before, after = (
        relative_pose(body, q, "tracker", "tool")[:, :3, 3] for body in (truth, nominal, taught)
    )
    left = np.linalg.norm(after - true) / np.linalg.norm(before - true)
    assert left < LEFT.get(name, 0.05)


def test_it_knows_that_it_did(
    learner: BodyLearner[Any, Any], nominal: Body, variables: Variables, senses: list[Sense]
) -> None:
    if isinstance(learner, WITHOUT_COVARIANCE):
        pytest.skip("has no covariance")
    start = learner.start(nominal, variables)
    assert (start.estimate.x == 0).all()
    assert start.estimate.std == pytest.approx(variables.prior_std)
    *_, (state, _) = run(learner, start, senses)
    covariance = state.estimate.covariance
    assert (covariance == covariance.T).all()
    assert np.linalg.eigvalsh(covariance).min() > 0
    assert (state.estimate.std <= variables.prior_std * (1 + 1e-9)).all()


def test_an_empty_recording_teaches_nothing(
    learner: BodyLearner[Any, Any], nominal: Body, variables: Variables, senses: list[Sense]
) -> None:
    start = learner.start(nominal, variables)
    assert list(run(learner, start, [])) == []
    assert list(run(learner, start, [sense.take([]) for sense in senses])) == []
