"""Ends: the frames of a sense that nobody measured, while it places them from its own samples.

A sample depends on T_a_b = X^-1 K(q) Y, where X places `seen_from` on its parent, Y places `seen`
on its parent and K is the robot's kinematics between those parents. An end whose placement is known
stays inside K, and identity stands for it. Each sense has a closed form for X or Y of its own, see
`placing` and `turning`; what they share is this cut.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Ends:
    """The ends of one sense: which are open, and the kinematics between the others."""

    body: Body
    looking: str
    """`seen_from`."""
    seen: str
    find_x: bool
    """Whether X, the placement of `seen_from`, is open."""
    find_y: bool
    K: Array
    """(n, 4, 4) at the readings."""

    @classmethod
    def of(cls, body: Body, sense: Sense, unknown: Collection[str]) -> Self:
        """Cut a sense out of the tree at those of its ends that are unknown."""
        find_x, find_y = sense.seen_from in unknown, sense.seen in unknown
        a, b = body.frame_index(sense.seen_from), body.frame_index(sense.seen)
        left = body.frames[body.parent[a]] if find_x else sense.seen_from
        right = body.frames[body.parent[b]] if find_y else sense.seen
        K = relative_pose(body, sense.readings(body), left, right)
        return cls(body, sense.seen_from, sense.seen, find_x, find_y, K)

    @property
    def any(self) -> bool:
        """Whether anything is open."""
        return self.find_x or self.find_y

    @property
    def X(self) -> Array:
        """(4, 4) as the body has it now; identity where it is inside K."""
        return self._now(self.looking, self.find_x)

    @property
    def Y(self) -> Array:
        """(4, 4) as the body has it now; identity where it is inside K."""
        return self._now(self.seen, self.find_y)

    def placed(self, X: Array, Y: Array) -> Body:
        """The body with the open ends placed, by (4, 4) each."""
        body = self.body
        if self.find_x:
            body = body.with_placement(self.looking, X)
        return body.with_placement(self.seen, Y) if self.find_y else body

    def between(self, w: Array, v: Array) -> Array:
        """From points w of `seen_from` to points v of `seen`, were the open positions zero.

        (n, 3) each, m, in the frame that K ends in: t_K + R_K R_Y v - R_X w.
        """
        R, t = self.K[:, :3, :3], self.K[:, :3, 3]
        reached = t + np.einsum("nij,nj->ni", R, v @ self.Y[:3, :3].T)
        return np.asarray(reached - w @ self.X[:3, :3].T)

    @staticmethod
    def at(T: Array, position: Array) -> Array:
        """A frame with another origin, (4, 4) and (3,)."""
        return lie.transform(T[:3, :3], position)

    def _now(self, frame: str, is_open: bool) -> Array:
        body = self.body
        return body.placement[body.frame_index(frame)] if is_open else np.eye(4)


def tilted(T_parent_frame: Array, up: Array) -> Array:
    """A frame turned the short way until its z axis points along `up` (3,), (4, 4)."""
    z, aim = T_parent_frame[:3, 2], up / np.linalg.norm(up)
    normal = np.cross(z, aim)
    sine, cosine = float(np.linalg.norm(normal)), float(z @ aim)
    # Opposite directions leave the axis free: the frame's own x axis will do.
    axis = normal / sine if sine > 1e-9 else T_parent_frame[:3, 0]
    T = T_parent_frame.copy()
    T[:3, :3] = lie.exp_so3(np.arctan2(sine, cosine) * axis) @ T[:3, :3]
    return np.asarray(T)
