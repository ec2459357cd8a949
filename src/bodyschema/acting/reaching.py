"""Reaching: a robot brings a part of itself where it sees something, by the body it believes in."""

from __future__ import annotations

from bodyschema.acting.inverse_kinematics import Aim, InverseKinematics, Reached
from bodyschema.acting.robot import Robot
from bodyschema.errors import InputError
from bodyschema.model.tree import Body


def reach(
    robot: Robot,
    body: Body,
    aim: Aim,
    solver: InverseKinematics | None = None,
    seed: int = 0,
) -> Reached:
    """Move a robot so that a frame comes to a place, as near as the body knows how to.

    Args:
        robot: it moves, once.
        body: what is believed of it; how near the robot truly comes depends on how right this is.
        aim: which frame should be where, seen from where.
        solver: of the inverse kinematics, which starts at the present posture; as it comes if None.
        seed: of its random starts.

    Raises:
        InputError: the body's joints are not those of the robot; or see `InverseKinematics.solve`.
    """
    if robot.joints != body.joints:
        raise InputError(
            f"the robot's joints are {', '.join(robot.joints)} and the body's "
            f"{', '.join(body.joints)}; give a body with the same joints in the same order."
        )
    found = (solver or InverseKinematics()).solve(body, aim, robot.read(), seed=seed)
    robot.command(found.q)
    return found
