"""Inverse kinematics: against a formula, against a grid, within limits, from any frame to any."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.acting.inverse_kinematics import Aim, InverseKinematics, _Problem
from bodyschema.errors import InputError
from bodyschema.estimation.identifiability import random_postures
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.simulation.humanoid import EYE, humanoid
from simulated import seen_arm

Array = NDArray[np.float64]
SOLVER = InverseKinematics()


def planar(first: float = 0.5, second: float = 0.3, limit: float = np.pi) -> Body:
    """Two links in the plane z = 0."""
    placement = np.tile(np.eye(4), (4, 1, 1))
    placement[2, 0, 3], placement[3, 0, 3] = first, second
    return Body.build(
        "planar", ["base", "upper", "lower", "tip"], ["", "shoulder", "elbow", "tip_joint"],
        [-1, 0, 1, 2], [0, 1, 1, 0], [[0, 0, 1]] * 4, placement,
        limits={"shoulder": (-limit, limit), "elbow": (-limit, limit)},
    )  # fmt: skip


def at_rest(body: Body) -> Array:
    return np.clip(np.zeros(len(body.joints)), body.lower, body.upper)


def test_two_links_against_the_law_of_cosines() -> None:
    body, (x, y) = planar(), (0.4, 0.35)
    found = SOLVER.solve(body, Aim("base", "tip", [x, y, 0.0]), [0.1, 0.2])
    assert found.converged
    assert found.position_error < 1e-9
    elbow = np.arccos((x**2 + y**2 - 0.5**2 - 0.3**2) / (2 * 0.5 * 0.3))
    assert abs(found.q[1]) == pytest.approx(elbow, abs=1e-8)


def test_out_of_reach_the_arm_is_stretched_towards_the_aim() -> None:
    body, aim = planar(), np.array([0.9, 1.2, 0.0])
    found = SOLVER.solve(body, Aim("base", "tip", aim), [0.1, 0.2])
    assert not found.converged
    assert found.position_error == pytest.approx(1.5 - 0.8, abs=1e-6)
    assert found.q == pytest.approx([np.arctan2(1.2, 0.9), 0.0], abs=1e-3)


def test_within_limits_against_a_grid() -> None:
    """The nearest posture of a fine grid is not nearer than the one found."""
    body = planar(limit=0.7)
    grid = np.linspace(-0.7, 0.7, 701)
    q = np.stack(np.meshgrid(grid, grid, indexing="ij"), axis=-1).reshape(-1, 2)
    tips = relative_pose(body, q, "base", "tip")[:, :3, 3]
    for aim in ([0.1, 0.5, 0.0], [-0.3, 0.2, 0.0], [0.78, 0.0, 0.1]):
        found = SOLVER.solve(body, Aim("base", "tip", aim), [0.0, 0.1])
        best = np.linalg.norm(tips - aim, axis=1).min()
        assert found.position_error <= best + 1e-9
        assert found.position_error == pytest.approx(best, abs=3e-3)
        assert (np.abs(found.q) <= 0.7).all()
    assert found.at_limits == ()
    held = SOLVER.solve(body, Aim("base", "tip", [-0.3, 0.2, 0.0]), [0.0, 0.1])
    assert held.at_limits == ("shoulder", "elbow")


@pytest.mark.parametrize("posed", [False, True], ids=["position", "pose"])
@pytest.mark.parametrize(("a", "b"), [(EYE, "r_hand"), ("l_foot", "r_hand"), ("r_hand", "l_hand")])
def test_what_can_be_reached_is_reached(posed: bool, a: str, b: str) -> None:
    body = humanoid()
    rng = np.random.default_rng(1)
    aims = relative_pose(body, random_postures(body, 15, rng), a, b)
    for T in aims:
        aim = Aim(a, b, T[:3, 3], T[:3, :3] if posed else None)
        found = SOLVER.solve(body, aim, at_rest(body))
        assert found.converged
        there = relative_pose(body, found.q, a, b)
        np.testing.assert_allclose(there[:3, 3], T[:3, 3], atol=1e-6)
        if posed:
            assert np.linalg.norm(lie.log_so3(there[:3, :3] @ T[:3, :3].T)) < 1e-6
        assert (found.q >= body.lower).all()
        assert (found.q <= body.upper).all()


def test_only_the_joints_that_may_move_move() -> None:
    body = humanoid()
    arm = [joint for joint in body.joints if joint[:2] == "r_"][:4]
    q0 = at_rest(body)
    q = q0.copy()
    q[[body.joint_index(joint) for joint in arm]] = [0.4, -0.3, 0.5, -0.9]
    aim = Aim(EYE, "r_hand", relative_pose(body, q, EYE, "r_hand")[:3, 3])
    found = SOLVER.solve(body, aim, q0, joints=arm)
    assert found.converged
    changed = {body.joints[j] for j in np.flatnonzero(found.q != q0)}
    assert changed <= set(arm)


@pytest.mark.parametrize("posed", [False, True], ids=["position", "pose"])
def test_the_jacobian_against_finite_differences(posed: bool) -> None:
    """Also with encoders that are off: it is the derivative by the readings."""
    rng = np.random.default_rng(2)
    body = replace(seen_arm(5, rng), gear=rng.normal(0, 0.1, 5), offset=rng.normal(0, 0.1, 5))
    q = random_postures(body, 1, rng)[0]
    aim = Aim(
        "tracker", "tool", rng.normal(size=3), lie.exp_so3([0.9, -0.7, 1.1]) if posed else None
    )
    problem = _Problem.of(body, aim, None, 0.3)
    _, A = problem.error(q)
    step = 1e-6
    for j in range(5):
        ahead, behind = q.copy(), q.copy()
        ahead[j] += step
        behind[j] -= step
        slope = (problem.error(behind)[0] - problem.error(ahead)[0]) / (2 * step)
        np.testing.assert_allclose(A[:, j], slope, atol=1e-8)


def test_the_same_seed_gives_the_same_posture() -> None:
    body = humanoid()
    aim = Aim(EYE, "r_hand", [5.0, 0.0, 0.0])
    one, same = (SOLVER.solve(body, aim, at_rest(body), seed=7) for _ in range(2))
    assert one.q.tobytes() == same.q.tobytes()
    assert not one.converged


@pytest.mark.parametrize(
    ("aim", "q", "says"),
    [
        (Aim("base", "tipp", [0, 0, 0]), [0, 0], "'tip'"),
        (Aim("base", "tip", [0, 0]), [0, 0], "three numbers"),
        (Aim("base", "tip", [0, 0, 0], np.ones((3, 3))), [0, 0], "3x3 rotation"),
        (Aim("base", "tip", [0, 0, 0]), [0, 0, 0], "2 joints"),
        (Aim("base", "tip", [0, 0, 0]), [0, 4], "'elbow' starts at 4.000"),
    ],
    ids=["frame", "position", "rotation", "posture", "range"],
)
def test_bad_input_is_refused(aim: Aim, q: list[float], says: str) -> None:
    with pytest.raises(InputError, match=says):
        SOLVER.solve(planar(), aim, q)


def test_postures_of_joints_with_one_limit() -> None:
    """Found by the fuzz bench: a lower limit beyond where an unlimited joint is taken to move."""
    arm = Body.random_chain(2, np.random.default_rng(0))
    arm = replace(arm, lower=np.array([9.0, -np.inf]), upper=np.array([np.inf, -9.0]))
    q = random_postures(arm, 50, np.random.default_rng(1))
    assert (q[:, 0] >= 9.0).all()
    assert (q[:, 1] <= -9.0).all()
    assert np.ptp(q, axis=0).min() > 2.0
