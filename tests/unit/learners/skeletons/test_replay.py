"""Replay: which samples stay, and that few of them teach what many do in one pass."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.learners.learner import run
from bodyschema.learners.published.online_gradient import OnlineGradient, from_nothing
from bodyschema.learners.replay import Replay, most_crowded, well_spread
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_frame, free_joints, join
from bodyschema.senses.points import Points


def seen_at(q: np.ndarray, seen: str = "tip") -> Points:
    return Points.make(q, np.zeros((len(q), 3)), "base", seen)


def test_of_the_nearest_two_the_one_that_is_nearer_to_a_third_leaves() -> None:
    assert most_crowded(np.array([[0.0], [1.0], [2.0], [2.4], [3.1]])) == 3
    assert most_crowded(np.array([[0.0], [5.0], [5.5], [20.0]])) == 1
    assert most_crowded(np.array([[0.0], [0.0]])) == 0


def test_a_robot_that_dwells_keeps_the_postures_of_its_journey() -> None:
    rng = np.random.default_rng(0)
    journey, dwelling = np.linspace(-1, 1, 9)[:, None], 1e-3 * rng.normal(size=(50, 1))
    kept = well_spread(seen_at(np.concatenate([journey, dwelling])), 9)
    assert np.sort(kept.q[:, 0]) == pytest.approx(journey[:, 0], abs=5e-3)
    few = seen_at(journey)
    assert well_spread(few, 9) is few


def test_each_sense_has_a_memory_of_its_own_and_none_grows() -> None:
    rng = np.random.default_rng(1)
    body = Body.random_chain(3, rng)
    learner = Replay(size=5, passes=1)
    state = learner.start(body, free_joints(body, ("axes", "links")))
    for i in range(12):
        sample = seen_at(rng.normal(size=(1, 3)), ("link_2", "tip")[i % 2])
        state, _ = learner.step(state, (sample,))
    assert [len(samples) for samples in state.kept.values()] == [5, 5]


def test_few_samples_teach_from_nothing() -> None:
    """Three joints, from nothing: the paper's single pass needs over a thousand samples."""
    rng = np.random.default_rng(2)
    truth = Body.random_chain(3, rng)
    variables = join(free_joints(truth, ("axes", "links")), free_frame(truth, "tip", 1.0, None))
    q = rng.uniform(-np.pi / 2, np.pi / 2, (540, 3))
    seen = Points.make(q, relative_pose(truth, q, "base", "tip")[:, :3, 3], "base", "tip")
    shown, fresh = seen.take(range(60)), seen.take(range(60, 540))
    errors = []
    for learner in (Replay(OnlineGradient(1.0, "normalised", length=0.2)),
                    OnlineGradient(1.0, "normalised", length=0.2)):  # fmt: skip
        start = from_nothing(truth, variables, 0.2, np.random.default_rng(3))
        *_, (state, _) = run(learner, learner.start(start, variables), [shown])
        errors.append(np.linalg.norm(fresh.residual(state.body), axis=1).max())
    chain = np.linalg.norm(truth.placement[:, :3, 3], axis=1).sum()
    assert errors[0] < 0.01 * chain < errors[1]
