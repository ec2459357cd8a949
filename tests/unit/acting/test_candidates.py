"""Candidates keep to limits and view, and leave other joints alone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.acting.candidates import View, find_candidates, joint_ranges, travel_order
from bodyschema.errors import InputError
from bodyschema.model.kinematics import relative_pose


@pytest.fixture
def limited(calibrated):  # type: ignore[no-untyped-def]
    """A calibrated world whose joints have limits."""
    world = calibrated()
    return world, replace(
        world.estimate.body, lower=np.full(5, -1.0), upper=np.array([1.0, 1.5, 2.0, 2.5, 3.0])
    )


def test_limits_are_kept(limited) -> None:  # type: ignore[no-untyped-def]
    world, body = limited
    found = find_candidates(body, [world.sense], 500, np.random.default_rng(0), anywhere=True)
    for q in (found.q, found.work):
        assert (q > body.lower).all()
        assert (q < body.upper).all()
    assert len(found.q) == 500
    assert np.ptp(found.q, axis=0) == pytest.approx(body.upper - body.lower, rel=0.1)


def test_without_limits_the_recorded_range_and_a_little_more(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    low, high = joint_ranges(world.estimate.body, world.sense.q)
    np.testing.assert_allclose(low, world.sense.q.min(axis=0) - 0.5)
    np.testing.assert_allclose(high, world.sense.q.max(axis=0) + 0.5)
    low, high = joint_ranges(world.estimate.body, world.sense.q[:0])
    np.testing.assert_allclose([low, high], [np.full(5, -np.pi), np.full(5, np.pi)])


def test_candidates_stay_in_the_recorded_view(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    body = world.estimate.body
    near = world.sense.take(np.arange(4))
    found = find_candidates(body, [near], 300, np.random.default_rng(0))
    far = find_candidates(body, [near], 300, np.random.default_rng(0), anywhere=True)
    view = View.of(body, near)
    assert view is not None
    assert view.holds(body, near.q).all(), "what was recorded is in view"
    assert view.holds(body, found.q).all()
    assert view.holds(body, far.q).mean() < 0.9

    def places(q: np.ndarray) -> np.ndarray:
        return relative_pose(body, q, "tracker", "tool")[:, :3, 3]

    spread, wide = places(found.q).std(axis=0), places(far.q).std(axis=0)
    assert np.prod(spread) < np.prod(wide)


def test_nothing_recorded_sets_no_view(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    blank = world.sense.take(np.arange(0))
    assert View.of(world.estimate.body, blank) is None
    found = find_candidates(world.estimate.body, [blank], 50, np.random.default_rng(0))
    assert len(found.q) == 50


def test_each_sense_has_a_view_of_its_own(calibrated) -> None:  # type: ignore[no-untyped-def]
    """A posture that one of two cameras sees is a candidate, and the other tells nothing of it."""
    world = calibrated()
    first, second = world.sense.take(np.arange(3)), world.sense.take(np.arange(3, 6))
    found = find_candidates(world.estimate.body, [first, second], 400, np.random.default_rng(0))
    assert found.visible.any(axis=1).all()
    assert not found.visible.all()


def test_joints_elsewhere_stand_still(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    short = replace(world.sense, seen="link_3")
    found = find_candidates(world.estimate.body, [short], 50, np.random.default_rng(0))
    assert found.joints == ("joint_1", "joint_2", "joint_3")
    np.testing.assert_allclose(np.ptp(found.q[:, 3:], axis=0), 0.0, atol=1e-15)


def test_postures_that_collide_are_left_out(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    found = find_candidates(
        world.estimate.body, [world.sense], 200, np.random.default_rng(0), True,
        lambda q: q[:, 1] > 0,
    )  # fmt: skip
    assert (found.q[:, 1] > 0).all()
    assert (found.work[:, 1] > 0).all()


def test_nothing_found_is_said(calibrated) -> None:  # type: ignore[no-untyped-def]
    world = calibrated()
    with pytest.raises(InputError, match="no posture was found"):
        find_candidates(
            world.estimate.body, [world.sense], 20, np.random.default_rng(0), False,
            lambda q: np.zeros(len(q), dtype=bool),
        )  # fmt: skip


def test_travel_goes_to_the_nearest_next() -> None:
    q = np.array([[3.0, 0.0], [1.0, 0.1], [-2.0, 0.0], [2.0, 0.0]])
    assert travel_order(q, np.array([0.5, 0.0])).tolist() == [1, 3, 0, 2]


def test_limits_that_were_left_do_not_bind(calibrated) -> None:
    """lower = upper = 0, as exporters write it, of joints that were recorded elsewhere."""
    world = calibrated()
    body = world.estimate.body
    none = replace(body, lower=np.zeros_like(body.lower), upper=np.zeros_like(body.upper))
    free = replace(body, lower=np.full_like(body.lower, -np.inf), upper=body.upper + np.inf)
    np.testing.assert_array_equal(
        joint_ranges(none, world.sense.q), joint_ranges(free, world.sense.q)
    )
    low, high = joint_ranges(none, np.zeros((1, len(body.joints))))
    assert (low == high).all(), "where nothing speaks against them they lock"
