"""A hand that moves freely: the body of a robot of which only the poses of its hand are known.

Six joints in a row, three that slide along the base's axes and three that turn (yaw, pitch, roll),
reach every pose T_base_hand, so that poses take the place of joint readings.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema import lie
from bodyschema.model.kernels import FIXED, PRISMATIC, REVOLUTE
from bodyschema.model.tree import Body

Array = NDArray[np.float64]

MOVES = ("x", "y", "z", "yaw", "pitch", "roll")


def free_hand(base: str = "base", hand: str = "hand", q: ArrayLike | None = None) -> Body:
    """A hand that hangs on its base by nothing.

    Args:
        base: frame that the poses are in.
        hand: frame whose poses they are.
        q: (n, 6) readings; where they are given, positions stay within their box.
    """
    names = [f"{hand}_{move}" for move in MOVES]
    x, y, z = np.eye(3)
    reach = {}
    if q is not None and len(np.asarray(q)):
        places = np.asarray(q)[:, :3]
        low, high = places.min(axis=0), places.max(axis=0)
        reach = {n: (float(a), float(b)) for n, a, b in zip(names, low, high, strict=False)}
    return Body.build(
        name=f"free_{hand}",
        frames=[base, *names[:-1], hand],
        carriers=["", *names],
        parent=range(-1, 6),
        kind=[FIXED, *[PRISMATIC] * 3, *[REVOLUTE] * 3],
        axis=np.array([z, x, y, z, z, y, x]),
        placement=np.tile(np.eye(4), (7, 1, 1)),
        limits=reach,
    )


def hand_readings(T_base_hand: ArrayLike) -> Array:
    """Joint readings (n, 6), m and rad, at which a free hand has these poses (n, 4, 4)."""
    T = np.asarray(T_base_hand, dtype=np.float64).reshape(-1, 4, 4)
    roll_pitch_yaw = lie.rpy_from_rotation(T[:, :3, :3])
    return np.hstack([T[:, :3, 3], roll_pitch_yaw[:, ::-1]])
