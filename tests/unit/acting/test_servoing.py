"""Servoing: the error falls as the law says, within limits, slowly where it must be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.acting.inverse_kinematics import Aim
from bodyschema.acting.servoing import Servoing, pose_error
from bodyschema.errors import InputError
from bodyschema.model.kinematics import frame_jacobian, relative_pose
from bodyschema.model.tree import Body

FREE = Servoing(largest_step=1.0, slow_below=1e-9)


@pytest.fixture
def arm() -> Body:
    return Body.random_chain(7, np.random.default_rng(4))


def aim_at(body: Body, q: np.ndarray, seen: str = "tip") -> Aim:
    T = relative_pose(body, q, "base", seen)
    return Aim("base", seen, T[:3, 3], T[:3, :3])


def test_the_error_is_the_derivative_s_own(arm: Body) -> None:
    """A small motion J dq changes the error by J dq: error and Jacobian share frame and sign."""
    rng = np.random.default_rng(0)
    q, dq = rng.uniform(-1, 1, 7), 1e-6 * rng.normal(size=7)
    T, moved = (relative_pose(arm, at, "base", "tip") for at in (q, q + dq))
    np.testing.assert_allclose(
        pose_error(moved, T), frame_jacobian(arm, q, "base", "tip") @ dq, atol=1e-11
    )


def test_each_frame_takes_its_share_of_a_small_error(arm: Body) -> None:
    q = np.linspace(-0.6, 0.7, 7)
    aim = aim_at(arm, q + 1e-4)
    first = FREE.step(arm, q, [aim], arm.joints)
    second = FREE.step(arm, first.q, [aim], arm.joints)
    share = 1 - FREE.gain
    assert second.position_error == pytest.approx(share * first.position_error, rel=1e-3)
    assert second.rotation_error == pytest.approx(share * first.rotation_error, rel=1e-3)


def test_it_reaches_the_aim_by_the_true_body_and_misses_by_a_wrong_one(arm: Body) -> None:
    q, offset = np.linspace(-0.6, 0.7, 7), np.deg2rad([5, 4, 3, -2, 3, -7, 3])
    true = replace(arm, offset=offset)
    aim = aim_at(true, q + 0.2)
    for believed, least, most in ((true, 0.0, 1e-6), (arm, 0.005, 1.0)):
        at = q
        for _ in range(80):
            at = Servoing().step(believed, at, [aim], arm.joints).q
        e = relative_pose(true, at, "base", "tip")[:3, 3] - aim.position
        assert least <= np.linalg.norm(e) < most


def test_joints_stay_in_their_range_and_are_named(arm: Body) -> None:
    q = np.linspace(-0.6, 0.7, 7)
    low, high = np.full(7, -2.0), np.full(7, 2.0)
    free = FREE.step(arm, q, [aim_at(arm, q + 0.3)], arm.joints).q
    pushed = int(np.argmax(free - q))
    high[pushed] = q[pushed]
    body, at = replace(arm, lower=low, upper=high), q
    first = FREE.step(body, q, [aim_at(arm, q + 0.3)], arm.joints)
    assert first.held == (arm.joints[pushed],)
    for _ in range(30):
        step = FREE.step(body, at, [aim_at(arm, q + 0.3)], arm.joints)
        at = step.q
        assert (at <= high).all()
        assert (at >= low).all()
    # Six joints are left for six numbers: what the held one cannot do the others do.
    assert step.position_error < 0.1 * first.position_error


def test_near_a_singular_posture_joints_stay_slow() -> None:
    """A planar arm stretched out cannot shorten by small steps: undamped it would whirl."""
    n = 4
    placement = np.tile(np.eye(4), (n, 1, 1))
    placement[2:, 0, 3] = 0.3
    body = Body.build(
        "planar", ["base", "upper", "lower", "tip"], ["", "a", "b", "tip_joint"],
        range(-1, n - 1), [0, 1, 1, 0], np.tile([0.0, 0.0, 1.0], (n, 1)), placement,
    )  # fmt: skip
    aim = Aim("base", "tip", [0.5, 0.05, 0.0])
    q = np.array([0.0, 1e-4])
    step = Servoing(largest_step=1e9)
    damped = np.abs(step.step(body, q, [aim], body.joints).q - q).max()
    wild = replace(step, slow_below=1e-12).step(body, q, [aim], body.joints).q - q
    assert damped < 0.2
    assert np.abs(wild).max() > 50


def test_two_arms_reach_at_once() -> None:
    """Two hands on one trunk: shared joint 0, then a joint chain each."""
    rng = np.random.default_rng(2)
    frames = ["base", "trunk", *(f"{s}{i}" for s in "lr" for i in range(1, 7))]
    parent = [-1, 0, 1, 2, 3, 4, 5, 6, 1, 8, 9, 10, 11, 12]
    axis = rng.normal(size=(14, 3))
    placement = lie.transform(np.tile(np.eye(3), (14, 1, 1)), 0.15 * rng.normal(size=(14, 3)))
    body = Body.build(
        "pair", frames, ["", *(f"j_{f}" for f in frames[1:])], parent, [0, *[1] * 13],
        axis / np.linalg.norm(axis, axis=1, keepdims=True), placement,
    )  # fmt: skip
    goal = rng.uniform(-0.5, 0.5, 13)
    aims = [aim_at(body, goal, "l6"), aim_at(body, goal, "r6")]
    at = goal + rng.uniform(-0.1, 0.1, 13)
    for _ in range(60):
        step = Servoing().step(body, at, aims, body.joints)
        at = step.q
    assert step.position_error < 1e-5
    assert step.rotation_error < 1e-4


def test_it_slows_and_stops_with_what_is_not_known(arm: Body) -> None:
    q = np.linspace(-0.6, 0.7, 7)
    aim, law = aim_at(arm, q + 0.01), Servoing()
    J = frame_jacobian(arm, q, "base", "tip")[:3]
    unit = np.sqrt(np.linalg.eigvalsh(J @ J.T).max())
    full = law.step(arm, q, [aim], arm.joints).q - q
    for r, gate in ((0.009, 1.0), (0.02, 0.5), (0.031, 0.0)):
        step = law.step(arm, q, [aim], arm.joints, (r / unit) ** 2 * np.eye(7))
        assert step.uncertainty == pytest.approx(r)
        assert step.gate == pytest.approx(gate)
        np.testing.assert_allclose(step.q - q, gate * full, atol=1e-12)


def test_no_aim_and_a_covariance_of_another_arm_are_refused(arm: Body) -> None:
    with pytest.raises(InputError, match="no aim"):
        Servoing().step(arm, np.zeros(7), [], arm.joints)
    with pytest.raises(InputError, match=r"covariance \(7, 7\)"):
        Servoing().step(arm, np.zeros(7), [aim_at(arm, np.zeros(7))], arm.joints, np.eye(3))
