"""A robot that is commanded: it goes where it is sent, or nowhere, and sees what is true."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.acting.robot import Robot
from bodyschema.errors import InputError
from bodyschema.estimation.identifiability import random_postures
from bodyschema.model.kinematics import relative_pose
from bodyschema.simulation.humanoid import ENDS, EYE, humanoid
from bodyschema.simulation.moving_robot import MovingRobot

pytest.importorskip("mujoco")


@pytest.fixture
def robot() -> MovingRobot:
    return MovingRobot(humanoid())


def test_it_sees_where_its_limbs_are(robot: MovingRobot) -> None:
    body = humanoid()
    for q in random_postures(body, 5, np.random.default_rng(0)):
        robot.command(q)
        np.testing.assert_array_equal(robot.read(), q)
        for marker in ENDS:
            expected = relative_pose(body, q, EYE, marker)[:3, 3]
            np.testing.assert_allclose(robot.see(EYE, marker), expected, atol=1e-9)


def test_a_command_beyond_the_range_moves_nothing(robot: MovingRobot) -> None:
    before, seen = robot.read(), robot.see(EYE, "r_hand")
    q = before.copy()
    q[[3, 5]] = [0.1, 3.0]
    with pytest.raises(InputError, match=r"'r_shoulder_roll' was sent to 3\.000"):
        robot.command(q)
    with pytest.raises(InputError, match="24 joint positions"):
        robot.command([0.0, np.nan])
    np.testing.assert_array_equal(robot.read(), before)
    np.testing.assert_array_equal(robot.see(EYE, "r_hand"), seen)


def test_what_is_read_is_a_copy(robot: MovingRobot) -> None:
    robot.read()[:] = 9.0
    assert np.abs(robot.read()).max() < 1.0


def test_it_is_a_robot(robot: MovingRobot) -> None:
    held: Robot = robot
    assert held.joints == humanoid().joints
