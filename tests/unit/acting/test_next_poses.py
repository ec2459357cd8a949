"""Planned poses beat random ones, close open directions, and are the same for the same seed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.acting.candidates import find_candidates
from bodyschema.acting.next_poses import plan_poses
from bodyschema.errors import InputError
from bodyschema.estimation.prediction import predict_error
from bodyschema.model.variables import free_joints, join


def test_same_seed_same_plan(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    first = plan_poses(world.estimate, [world.sense], 4, seed=3)
    again = plan_poses(world.estimate, [world.sense], 4, seed=3)
    np.testing.assert_array_equal(first.q, again.q)
    np.testing.assert_array_equal(first.random_error, again.random_error)
    assert not np.array_equal(first.q, plan_poses(world.estimate, [world.sense], 4, seed=4).q)


def test_a_longer_plan_begins_with_the_shorter(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    long = plan_poses(world.estimate, [world.sense], 5)
    short = plan_poses(world.estimate, [world.sense], 2)
    np.testing.assert_array_equal(long.q[:2], short.q)
    np.testing.assert_allclose(long.error[:3], short.error)


def test_predicted_error_before_is_that_of_predict_error(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    found = find_candidates(world.estimate.body, [world.sense], 50, np.random.default_rng(0))
    plan = plan_poses(world.estimate, [world.sense], 1, candidates=found)
    freedom = 3 * len(world.sense) - plan.rank[0]
    expected = predict_error(world.estimate, found.work, "tracker", "tool", freedom)
    assert plan.error[0] == pytest.approx(expected.position_overall, rel=1e-6)


def test_planned_beats_random_predicted_and_real(calibrated) -> None:  # type: ignore[no-untyped-def]
    real = []
    for seed in (1, 2, 3):
        world = calibrated(seed, n=8)
        rng = np.random.default_rng(seed)
        found = find_candidates(world.estimate.body, [world.sense], 2000, rng, anywhere=True)
        plan = plan_poses(world.estimate, [world.sense], 6, candidates=found)
        assert (np.diff(plan.error) < 0).all()
        assert plan.error[-1] < plan.random_error[-1]
        draws = [found.q[rng.choice(len(found.q), 6, replace=False)] for _ in range(8)]
        drawn = [world.error_after(q) for q in draws]
        planned = np.sqrt(np.mean([world.error_after(plan.q) ** 2 for _ in range(8)]))
        real.append(planned / np.sqrt(np.mean(np.square(drawn))))
    assert max(real) < 1.0, real


def test_a_joint_that_never_moved_is_told_by_the_plan(calibrated) -> None:  # type: ignore[no-untyped-def]
    """joint_3 stood still: its gear goes with its offset until it moves."""
    world = calibrated(still=2, n=12)
    estimate = world.estimate
    gear = free_joints(estimate.reference, ("gears",), ["joint_3"])
    widened = replace(
        estimate, variables=join(estimate.variables, gear), x=np.append(estimate.x, 0.0)
    )
    linear = world.sense.linearize(widened.reference, widened.variables, widened.x)
    J = linear.by_parameter.reshape(-1, len(widened.x)) / 1e-3
    widened = replace(widened, data_information=J.T @ J)
    plan = plan_poses(widened, [world.sense], 3)
    assert plan.rank[1] > plan.rank[0]
    assert plan.rank[-1] <= plan.most <= plan.n_parameters
    assert "joint_3.gear" in plan.told
    column = widened.body.joint_index("joint_3")
    assert np.abs(plan.q[:, column] - 0.3).max() > 0.1


def test_the_plan_for_all_parameters_differs(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    tool = plan_poses(world.estimate, [world.sense], 5)
    overall = plan_poses(world.estimate, [world.sense], 5, criterion="all")
    assert not np.array_equal(tool.q, overall.q)
    assert tool.error[-1] <= overall.error[-1] * 1.02


def test_another_tool_may_count(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    plan = plan_poses(world.estimate, [world.sense], 2, pairs=[("base", "link_5")])
    assert plan.pairs == (("base", "link_5"),)


def test_senses_without_samples_do(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    plan = plan_poses(world.estimate, [world.sense.take(np.arange(0))], 2)
    assert np.isfinite(plan.error).all()


def test_bad_requests_are_refused(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    with pytest.raises(InputError, match="ask for at least 1"):
        plan_poses(world.estimate, [world.sense], 0)
    few = find_candidates(world.estimate.body, [world.sense], 3, np.random.default_rng(0))
    with pytest.raises(InputError, match="only 3 postures"):
        plan_poses(world.estimate, [world.sense], 4, candidates=few)
    nothing = replace(world.estimate, variables=world.estimate.variables.take([]), x=np.empty(0))
    with pytest.raises(InputError, match="no free parameters"):
        plan_poses(nothing, [world.sense], 2)


def test_no_posture_is_asked_for_twice(calibrated) -> None:
    """Candidates that are one posture, as those of joints without a range, count once."""
    world = calibrated()
    found = find_candidates(world.estimate.body, [world.sense], 3, np.random.default_rng(0))
    many = replace(found, q=np.repeat(found.q, 4, axis=0), visible=np.repeat(found.visible, 4, 0))
    plan = plan_poses(world.estimate, [world.sense], 3, candidates=many)
    assert len(np.unique(plan.q, axis=0)) == 3
    with pytest.raises(InputError, match="only 3 postures"):
        plan_poses(world.estimate, [world.sense], 4, candidates=many)
