"""An open-loop movement: from one posture to another in equal steps of all joints.

    q_d = K^-1(x_d),    q_{t+1} = q_t + (q_d - q_i) / D        D frames

(Vicente, Jamone, Bernardino 2016, Eq. 26-27). Nothing is looked at on the way: where the hand ends
is as wrong as the body that K^-1 believes in.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError

Array = NDArray[np.float64]


def joint_trajectory(q_i: ArrayLike, q_d: ArrayLike, frames: int) -> Array:
    """The postures q_1 .. q_D (frames, n_joints); the last is q_d itself.

    Args:
        q_i: (n_joints,) where the robot stands, rad or m.
        q_d: (n_joints,) where it shall go.
        frames: D, how many commands it takes.

    Raises:
        InputError: postures of two robots, or no frame.
    """
    start, goal = np.asarray(q_i, dtype=np.float64), np.asarray(q_d, dtype=np.float64)
    if start.ndim != 1 or start.shape != goal.shape or frames < 1:
        raise InputError(
            f"expected two postures (n_joints,) and at least one frame, got {start.shape}, "
            f"{goal.shape} and {frames}."
        )
    share = np.arange(1, frames + 1)[:, None] / frames
    # Not a running sum: rounding would leave the last command beside q_d.
    return np.asarray((1 - share) * start + share * goal)
