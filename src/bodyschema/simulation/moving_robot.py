"""A robot that can be commanded and that sees itself, placed by MuJoCo's kinematics.

Bodies of a study know no masses, so nothing swings or sags: a command places the joints, and MuJoCo
says where every frame is then. What is seen comes from MuJoCo's own reader and kinematics, not from
`bodyschema.model`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.tree import Body
from bodyschema.simulation.real_robot import RealRobot

Array = NDArray[np.float64]


class MovingRobot:
    """The robot that a body describes; see `acting.robot.Robot`."""

    def __init__(self, body: Body) -> None:
        """Stand at zero, or as near to it as the joints allow.

        Args:
            body: how the robot is truly built.

        Raises:
            MissingExtraError: MuJoCo is not installed.
        """
        self.joints = body.joints
        self._low, self._high = body.lower, body.upper
        self._q = np.clip(np.zeros(len(body.joints)), body.lower, body.upper)
        self._robot = RealRobot(write_urdf(body), {}, body.joints, {})

    def read(self) -> Array:
        """(n_joints,) encoder readings, rad or m."""
        return self._q.copy()

    def command(self, q: ArrayLike) -> None:
        """Go to these readings, (n_joints,).

        Raises:
            InputError: beyond the range of a joint, or not one number for each.
        """
        posture = np.array(q, dtype=np.float64)
        if posture.shape != self._q.shape or not np.isfinite(posture).all():
            raise InputError(
                f"expected {len(self.joints)} joint positions ({', '.join(self.joints)}), "
                f"got {q!r}."
            )
        beyond = np.flatnonzero((posture < self._low - 1e-9) | (posture > self._high + 1e-9))
        if len(beyond):
            j = int(beyond[0])
            raise InputError(
                f"joint '{self.joints[j]}' was sent to {posture[j]:.3f}, beyond its range of "
                f"{self._low[j]:.3f} to {self._high[j]:.3f}; the robot did not move."
            )
        self._q = posture

    def see(self, seen_from: str, seen: str) -> Array:
        """(3,) m: where the origin of a frame truly is, in the frame that looks."""
        return np.asarray(self._robot.poses(self._q, seen_from, [seen])[0, 0, :3, 3])
