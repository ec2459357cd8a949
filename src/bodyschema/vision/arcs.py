"""Arcs: stretches of an outline, each one measurement.

Pixels along a contour err together: over a step of a mask's staircase, where an edge is blurred, or
where a shadow lies. A thousand rim points are therefore not a thousand measurements. The points of
one arc, a short straight stretch of one piece's outline, are taken together; arcs err on their own.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.vision.correspondences import Rim

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

ARC = 8.0
"""px. Shorter ones err together and state too little doubt; on the curved links of a humanoid 16 px
tell a third less."""

LONGEST = 256.0
"""px: longer steps of a staircase than this are counted as such."""

SECTORS = 16
"""Directions of the normal that are told apart: an arc does not go round a corner."""

LEAST = 1 / 3
"""Share of an arc that must be there."""

MATCHED = 2.0
"""px; a rim point is matched when its outline was found within so much, and belongs to its arc when
it lies within so much of the arc's middle."""


def arcs(rim: Rim, there: Flags, distance: Array, length: float, most: int) -> Ints:
    """The points of a rim that make one measurement each, (n, most) of its rows; -1 for none.

    Points of one piece whose normals lie in one sector belong to an arc when they lie on the same
    stretch of the line along that sector's tangent. An edge that is nearly a row or a column of the
    picture errs together over a whole step of its staircase: there arcs are longer.

    Args:
        rim: in one view.
        there: (n_points,) which of them were found.
        distance: (n_points,) px outward where they were found.
        length: px of an arc.
        most: points of an arc; of more, so many are taken evenly.
    """
    points = np.flatnonzero(there)
    if not len(points):
        return np.zeros((0, most), dtype=np.int64)
    _, arc = np.unique(_stretches(rim, length)[points], axis=0, return_inverse=True)
    order, kept = np.argsort(arc, kind="stable"), []
    for rows in np.split(points[order], np.cumsum(np.bincount(arc))[:-1]):
        near = rows[np.abs(distance[rows] - np.median(distance[rows])) < MATCHED]
        if rim.length[near].sum() >= LEAST * length:
            few = near[np.linspace(0, len(near) - 1, min(len(near), most)).round().astype(int)]
            kept.append(np.pad(few, (0, most - len(few)), constant_values=-1))
    return np.array(kept, dtype=np.int64).reshape(-1, most)


def _stretches(rim: Rim, length: float) -> Ints:
    """Piece, sector, how much longer, and place along the tangent of each point, (n_points, 4)."""
    angle = np.arctan2(rim.normal[:, 1], rim.normal[:, 0])
    sector = np.round(angle * SECTORS / (2 * np.pi)).astype(np.int64) % SECTORS
    turn = sector * 2 * np.pi / SECTORS
    along = -np.sin(turn) * rim.pixel[:, 0] + np.cos(turn) * rim.pixel[:, 1]
    slope = np.abs(rim.normal).min(axis=1) / np.abs(rim.normal).max(axis=1)
    long = slope * length < 1
    place = np.floor(along / np.where(long, LONGEST, length)).astype(np.int64)
    return np.column_stack([rim.piece, sector, long, place])
