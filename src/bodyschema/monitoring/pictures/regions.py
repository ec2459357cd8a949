"""Where corners of the hand, and of the background, may be born."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.learners.hand_eye.stereo_points import Stereo

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

NEAR_CORNER, NEAR_POINT = 22, 10
"""px round a corner that lives, and round where a remembered point should be, that are me."""
CLEAR = 45
"""px round everything that may be me in which nothing is taken for the background."""


def discs(size: tuple[int, int], place: Array, radius: int) -> Flags:
    """(height, width) pixels within a radius of places (K, 2)."""
    from bodyschema.vision.corner_patches import vision

    picture = np.zeros(size, dtype=np.uint8)
    for u, v in np.rint(place).astype(int):
        vision().circle(picture, (int(u), int(v)), radius, 1, -1)
    return picture.astype(bool)


def remembered(points: Array, T_cam_hand: Array, stereo: Stereo, size: tuple[int, int]) -> Array:
    """(n, 2) px: where points (K, 3) of the hand should be seen; those in the picture."""
    c = points @ T_cam_hand[:3, :3].T + T_cam_hand[:3, 3]
    c = c[c[:, 2] > 0.1]
    u = stereo.project(c)[:, :2]
    height, width = size
    inside = (u > 0).all(axis=1) & (u[:, 0] < width) & (u[:, 1] < height)
    return np.asarray(u[inside])


def of_me(
    size: tuple[int, int], corners: Array, points: Array, T_world_cam: Array | None,
    T_world_hand: Array, stereo: Stereo,
) -> Flags:  # fmt: skip
    """(height, width) where corners of the hand may be born.

    Args:
        size: height and width.
        corners: (K, 2) px of those that live.
        points: (n, 3) m, remembered points of the hand.
        T_world_cam: (4, 4); None while nothing is known.
        T_world_hand: (4, 4).
        stereo: the lens.
    """
    me = discs(size, corners, NEAR_CORNER)
    if T_world_cam is not None and len(points):
        there = remembered(points, lie.inverse(T_world_cam) @ T_world_hand, stereo, size)
        me |= discs(size, there, NEAR_POINT)
    return me


def of_background(me: Flags) -> Flags:
    """(height, width) what is far from everything that may be me."""
    return ~_wider(me, CLEAR)


def beside(me: Flags, by: int) -> Flags:
    """(height, width) what is not me, and within so many pixels of it."""
    return _wider(me, by) & ~me


def _wider(mask: Flags, by: int) -> Flags:
    from bodyschema.vision.corner_patches import vision

    kernel = np.ones((2 * by + 1, 2 * by + 1), np.uint8)
    return np.asarray(vision().dilate(mask.astype(np.uint8), kernel) > 0)
