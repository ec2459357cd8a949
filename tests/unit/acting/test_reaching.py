"""Reaching with a right body, a wrong one and none: MuJoCo says where the hand truly is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema.acting.inverse_kinematics import Aim
from bodyschema.acting.reaching import reach
from bodyschema.errors import InputError
from bodyschema.estimation.identifiability import random_postures
from bodyschema.estimation.invisible import invisible_motions
from bodyschema.learners.published.online_gradient import from_nothing
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_skeleton
from bodyschema.simulation.humanoid import ENDS, EYE, humanoid
from bodyschema.simulation.moving_robot import MovingRobot

pytest.importorskip("mujoco")
TARGETS = 12


def errors(believed: Body, targets: int = TARGETS) -> list[float]:
    """True distances between hand and target, m."""
    robot, body = MovingRobot(humanoid()), humanoid()
    seen = []
    for q in random_postures(body, targets, np.random.default_rng(0)):
        robot.command(q)
        seen.append(robot.see(EYE, "r_hand"))
    found = []
    for target in seen:
        reach(robot, believed, Aim(EYE, "r_hand", target))
        found.append(float(np.linalg.norm(robot.see(EYE, "r_hand") - target)))
    return found


def test_with_the_true_body_the_hand_is_there() -> None:
    assert max(errors(humanoid())) < 1e-6


def test_a_body_that_cannot_be_told_apart_reaches_as_well() -> None:
    """Fig. 8 of Hersch et al. 2008: other joint centres, the same movements of the hand."""
    rng = np.random.default_rng(1)
    body = humanoid()
    variables = free_skeleton(body)
    rows = [m.row for m in invisible_motions(body, variables) if m.frame not in (EYE, *ENDS)]
    other = body.with_variables(variables, rng.normal(0, 0.1, len(rows)) @ np.array(rows))
    assert np.linalg.norm(other.placement[:, :3, 3] - body.placement[:, :3, 3], axis=1).max() > 0.1
    assert max(errors(other)) < 1e-6


def test_without_learning_the_hand_is_anywhere() -> None:
    body = humanoid()
    untaught = from_nothing(body, free_skeleton(body), 0.1, np.random.default_rng(2))
    assert np.median(errors(untaught, 3)) > 0.05


def test_another_robot_s_body_is_refused() -> None:
    body = humanoid()
    renamed = replace(body, joints=tuple(f"{joint}_2" for joint in body.joints))
    with pytest.raises(InputError, match="same joints in the same order"):
        reach(MovingRobot(body), renamed, Aim(EYE, "r_hand", [0.2, 0.0, -0.2]))
