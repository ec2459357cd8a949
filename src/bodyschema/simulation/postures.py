"""Postures in which both eyes see the whole hand, by rejection sampling with the real robot.

About 3 % of the uniform draws pass; sixty postures take a tenth of a second.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.tree import Body
from bodyschema.simulation import eyes, icub
from bodyschema.simulation.real_robot import RealRobot

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

NEAR, FAR = 0.15, 0.6
"""m from either eye; all marks of a posture lie between."""
CHEST_CLEARANCE = 0.12
"""m that every mark stays before the chest: the model has no contacts that would stop the arm."""
DRAWS_A_BATCH, MOST_BATCHES = 1000, 500


def draw_postures(robot: RealRobot, body: Body, n: int, rng: np.random.Generator) -> Array:
    """Readings (n, n_joints) within the limits, uniform among those that show the whole hand."""
    moved = [body.joint_index(name) for name in icub.MOVED]
    still = np.clip(0.0, body.lower, body.upper)
    kept: list[Array] = []
    for _ in range(MOST_BATCHES):
        q = np.tile(still, (DRAWS_A_BATCH, 1))
        q[:, moved] = rng.uniform(body.lower[moved], body.upper[moved], (len(q), len(moved)))
        kept.append(q[_shows_hand(robot, q)])
        if sum(map(len, kept)) >= n:
            return np.concatenate(kept)[:n]
    raise InputError(
        f"only {sum(map(len, kept))} of {DRAWS_A_BATCH * MOST_BATCHES} random postures show the "
        f"hand to both eyes, {n} are needed; make the offsets or the eye's error smaller."
    )


def _shows_hand(robot: RealRobot, q: Array) -> Flags:
    p_chest = robot.poses(q, "chest", list(icub.LANDMARKS))[..., :3, 3]
    good = (p_chest[..., 2] > CHEST_CLEARANCE).all(axis=1)
    for p in landmarks(robot, q):
        good &= eyes.in_view(p, NEAR, FAR).all(axis=1)
    return np.asarray(good)


def landmarks(robot: RealRobot, q: Array) -> tuple[Array, Array]:
    """True landmarks in the left and in the right eye, each (n, nlandmarks, 3) m."""
    T_left = robot.poses(q, icub.LEFT_EYE, [icub.RIGHT_EYE, *icub.LANDMARKS])
    p_left = T_left[:, 1:, :3, 3]
    T_right_left = lie.inverse(T_left[:, :1])
    return p_left, (T_right_left[..., :3, :3] @ p_left[..., None])[..., 0] + T_right_left[
        ..., :3, 3
    ]
