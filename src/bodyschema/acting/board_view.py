"""Whether a camera would see a board: in the picture, from its front, and about as far as before.

Corners are projected through the lens that was found. As many have to be inside the picture, a
little off its edge, as recorded pictures showed (all of a chessboard, some of a ChArUco board); the
board must not be tilted, nor be nearer or farther, by much more than it ever was: pattern and focus
were good there, and nobody knows how far they remain so.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kinematics import relative_pose
from bodyschema.model.lens import pixels
from bodyschema.model.tree import Body
from bodyschema.senses.pixels import Pixels

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

EDGE = 0.03
"""Of the picture's size, kept from its edge: squares and tags reach beyond their corners."""

GROWTH, SLACK, STEEPEST = 1.2, 0.1, 1.3
"""The recorded tilt and distances grow by the first; tilt by the second, rad, and never beyond the
third, rad, where squares are too narrow to be found."""

USUAL = 0.1
"""Quantile of the recorded pictures by their share of corners that has to be reached."""

LEAST = 4
"""Corners of a board; fewer points are no board, and have a `candidates.View`."""


@dataclass(frozen=True)
class BoardView:
    """What a camera has seen of a board."""

    sense: Pixels
    corners: Array
    """(m, 3) of the board, in the target's own coordinates."""
    share: float
    """Of the corners that have to be in the picture."""
    front: float
    """1 or -1: the sign of the board's z along the line of sight."""
    cosine: float
    """Of the largest tilt."""
    nearest: float
    """m"""
    farthest: float
    """m"""

    @classmethod
    def of(cls, body: Body, sense: Pixels) -> BoardView | None:
        """The view of recorded pictures; None where there are none, or of no board."""
        corners = np.unique(sense.target, axis=0)
        if not len(sense) or len(corners) < LEAST or not all(sense.size):
            return None
        _, first, counts = np.unique(sense.rows, return_index=True, return_counts=True)
        T = relative_pose(body, sense.q[first], sense.seen_from, sense.seen)
        cosines, distances = _sight(T, corners.mean(axis=0))
        front = 1.0 if np.median(cosines) >= 0 else -1.0
        tilt = float(np.arccos(np.clip(front * cosines, -1, 1)).max())
        return cls(
            sense,
            corners,
            float(np.quantile(counts / len(corners), USUAL)),
            front,
            float(np.cos(min(GROWTH * tilt + SLACK, max(STEEPEST, tilt)))),
            float(distances.min()) / GROWTH,
            float(distances.max()) * GROWTH,
        )

    def holds(self, body: Body, q: Array) -> Flags:
        """Whether the board is in view at each posture, (n,)."""
        sense, m = self.sense, len(self.corners)
        T = relative_pose(body, q, sense.seen_from, sense.seen)
        scale = body.part(sense.scale)["scale"] if sense.scale else 1.0
        places = np.einsum("nij,mj->nmi", T[:, :3, :3], scale * self.corners) + T[:, None, :3, 3]
        image = pixels(sense.lens_of(body), places.reshape(-1, 3)).reshape(len(q), m, 2)
        size = np.array(sense.size, dtype=np.float64)
        edge = EDGE * size
        inside = ((image > edge) & (image < size - 1 - edge)).all(axis=2)
        cosines, distances = _sight(T, self.corners.mean(axis=0))
        faced = self.front * cosines >= self.cosine - 1e-9
        near = (distances >= self.nearest) & (distances <= self.farthest)
        return np.asarray((inside.mean(axis=1) >= self.share - 1e-9) & faced & near)


def _sight(T_a_b: Array, middle: Array) -> tuple[Array, Array]:
    """Cosine of the line of sight with the board's z, and the distance of its middle, (n,) each."""
    places = np.einsum("nij,j->ni", T_a_b[:, :3, :3], middle) + T_a_b[:, :3, 3]
    distances = np.linalg.norm(places, axis=1)
    along = np.einsum("ni,ni->n", places, T_a_b[:, :3, 2]) / np.maximum(distances, 1e-12)
    return np.asarray(along), np.asarray(distances)
