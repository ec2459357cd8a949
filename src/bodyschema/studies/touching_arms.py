"""Two arms whose limbs touch each other: a robot that learns itself with its eyes shut.

Three random joints an arm, links of 0.2 m, one trunk. A touch is a posture in which a point on the
right limb's skin meets one on the left's, both within `skin` (m) of the hands' origins.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.kernels import FIXED, REVOLUTE
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_joints
from bodyschema.senses.touches import Touches

Array = NDArray[np.float64]

LINK = 0.2
"""m."""

ROUNDS, LONGEST_TURN, WIDEST, MET = 40, 0.3, 2.5, 1e-9
"""Steps towards a touch, rad of a joint in one of them, rad that a joint may reach, m."""


def two_arms(rng: np.random.Generator) -> Body:
    """Frames "trunk", "left_1" .. "left_3", "left", "right_1" .. "right_3", "right"."""
    axis, links = rng.normal(size=(9, 3)), rng.normal(size=(9, 3))
    links *= LINK / np.linalg.norm(links, axis=1, keepdims=True)
    links[0] = 0.0
    frames = [f"{side}{end}" for side in ("left", "right") for end in ("_1", "_2", "_3", "")]
    return Body.build(
        name="two_arms",
        frames=["trunk", *frames],
        carriers=["", *(f"{frame}_joint" for frame in frames)],
        parent=[-1, 0, 1, 2, 3, 0, 5, 6, 7],
        kind=[FIXED, *[REVOLUTE] * 3, FIXED, *[REVOLUTE] * 3, FIXED],
        axis=axis / np.linalg.norm(axis, axis=1, keepdims=True),
        placement=lie.transform(np.tile(np.eye(3), (9, 1, 1)), links),
    )


def touches(body: Body, skin: float, n: int, rng: np.random.Generator) -> Touches:
    """True touches, found by damped Gauss-Newton steps on the joints from n random postures.

    Postures that end apart, or with a joint too far out, are left out: fewer than n come back.
    """

    def points() -> Array:
        direction = rng.normal(size=(n, 3))
        far = skin * rng.uniform(0.3, 1.0, (n, 1))
        return np.asarray(far * direction / np.linalg.norm(direction, axis=1, keepdims=True))

    meet = Touches.make(rng.uniform(-2, 2, (n, 6)), points(), points(), "left", "right")
    nothing = free_joints(body, ())
    for _ in range(ROUNDS):
        L = meet.linearize(body, nothing, np.empty(0))
        J = L.by_joint
        pull = np.linalg.solve(J @ J.mT + 1e-6 * np.eye(3), L.residual[..., None])
        step = np.clip(-(J.mT @ pull)[..., 0], -LONGEST_TURN, LONGEST_TURN)
        meet = replace(meet, q=meet.q + step)
    apart = np.linalg.norm(meet.residual(body), axis=1)
    return meet.take((apart < MET) & (np.abs(meet.q).max(axis=1) < WIDEST))
