"""What every learner must keep: a new one joins by one line in LEARNERS."""

from __future__ import annotations

import pickle
from dataclasses import FrozenInstanceError, fields, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.learners.filter import Filter
from bodyschema.learners.learner import Learner, in_time_order, run
from bodyschema.learners.published.online_gradient import OnlineGradient
from bodyschema.learners.skeletons.pool import Pool
from bodyschema.learners.skeletons.replay import Replay
from bodyschema.learners.smoother import Smoother
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, join
from bodyschema.monitoring.innovations import Candidate
from bodyschema.monitoring.link_change import LinkMonitor
from bodyschema.senses.sense import Sense
from simulated import drawn, free_all, points, poses, postures, seen_arm

Array = NDArray[np.float64]

LEARNERS: dict[str, Learner[Any, Any]] = {
    "gauss_newton": Filter(),
    "gauss_newton_forgetting": Filter(forgetting=0.99),
    "smoother": Smoother(),
    "link_monitor": LinkMonitor((Candidate("tool", ("tool.link_x", "tool.link_y"), 0.1),)),
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
def learner(name: str) -> Learner[Any, Any]:
    return LEARNERS[name]


@pytest.fixture(scope="module")
def nominal() -> Body:
    return seen_arm(4, np.random.default_rng(0))


@pytest.fixture(scope="module")
def variables(learner: Learner[Any, Any], nominal: Body) -> Variables:
    if isinstance(learner, SKELETON_ONLY):
        tool = free_frame(nominal, "tool", turn_std=None)
        return join(free_joints(nominal, ("axes", "links")), tool)
    return free_all(nominal)


@pytest.fixture(scope="module")
def truth(nominal: Body, variables: Variables) -> Body:
    return nominal.with_variables(variables, drawn(variables, np.random.default_rng(1), 0.5))


@pytest.fixture(scope="module")
def senses(learner: Learner[Any, Any], truth: Body) -> list[Sense]:
    """The tip every 0.7 s, the tool's pose every 0.5 s: moments interleave, and some coincide."""
    rng = np.random.default_rng(2)
    seen = points(truth, postures(POINTS, truth, rng), rng, seen="tip")
    look = points if isinstance(learner, SKELETON_ONLY) else poses
    return [_timed(seen, 0.7), _timed(look(truth, postures(POSES, truth, rng), rng), 0.5)]


def _timed(sense: Sense, step: float) -> Sense:
    return replace(sense, time=np.round(step * np.arange(len(sense)), 1))


def test_settings_are_frozen(learner: Learner[Any, Any]) -> None:
    for field in fields(learner):  # type: ignore[arg-type]
        with pytest.raises(FrozenInstanceError):
            setattr(learner, field.name, None)


def test_run_gives_one_state_a_sample_in_time_order(
    learner: Learner[Any, Any], nominal: Body, variables: Variables, senses: list[Sense]
) -> None:
    steps = list(run(learner, learner.start(nominal, variables), senses))
    assert len(steps) == POINTS + POSES
    fed = list(in_time_order(senses))
    times = [float(sample.time[0]) for sample in fed]
    assert times == sorted(np.concatenate([sense.time for sense in senses]).tolist())
    # Within a moment, senses come in the order in which they were given.
    assert [sample.seen for sample in fed if sample.time[0] == 3.5] == ["tip", "tool"]
    state = learner.start(nominal, variables)
    for sample, (expected, _) in zip(fed, steps, strict=True):
        state, _ = learner.step(state, sample)
        assert _same(state, expected)


def test_start_and_step_are_pure(
    learner: Learner[Any, Any], nominal: Body, variables: Variables, senses: list[Sense]
) -> None:
    """An old state still steps to the same result; nothing that was passed in has changed."""
    start = learner.start(nominal, variables)
    assert _same(start, learner.start(nominal, variables))
    states, infos = [start], []
    for state, info in run(learner, start, senses):
        states.append(state)
        infos.append(info)
    kept = pickle.dumps((states, senses))
    for before, after, info, sample in zip(
        states[:-1], states[1:], infos, in_time_order(senses), strict=True
    ):
        again, info_again = learner.step(before, sample)
        assert _same(again, after)
        assert _same(info_again, info)
    assert pickle.dumps((states, senses)) == kept


def test_a_state_that_was_saved_steps_on_as_before(
    learner: Learner[Any, Any], nominal: Body, variables: Variables, senses: list[Sense]
) -> None:
    samples = list(in_time_order(senses))
    state = learner.start(nominal, variables)
    for k, sample in enumerate(samples):
        if k in (5, 40):
            state = pickle.loads(pickle.dumps(state))
        state, _ = learner.step(state, sample)
    *_, (straight, _) = run(learner, learner.start(nominal, variables), senses)
    assert _same(state, straight)


def test_it_learns(
    name: str,
    learner: Learner[Any, Any],
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
    learner: Learner[Any, Any], nominal: Body, variables: Variables, senses: list[Sense]
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
    learner: Learner[Any, Any], nominal: Body, variables: Variables, senses: list[Sense]
) -> None:
    start = learner.start(nominal, variables)
    assert list(run(learner, start, [])) == []
    assert list(run(learner, start, [sense.take([]) for sense in senses])) == []


def _same(one: Any, other: Any) -> bool:
    """Equal to the last bit, through dataclasses, tuples, mappings and arrays."""
    if isinstance(one, np.ndarray):
        return bool(np.array_equal(one, other, equal_nan=one.dtype.kind == "f"))
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(_same, one, other))
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(_same(one[k], other[k]) for k in one)
    if hasattr(one, "__dataclass_fields__"):
        return all(_same(getattr(one, f), getattr(other, f)) for f in one.__dataclass_fields__)
    return bool(one == other) or (one != one and other != other)
