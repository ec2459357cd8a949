"""A rigid pair of pinhole cameras: projection, view limits, and triangulation.

A point p in the optical frame (x right, y down, z forward) is seen at u = f x / z + c_x,
v = f y / z + c_y; pixel (0, 0) is the centre of the top-left pixel.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema import lie

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

WIDTH, HEIGHT = 320, 240
"""pixels"""
FOCAL_LENGTH = 257.34
"""pixels; 64 by 50 degrees of view, as the cameras of the iCub simulator."""
CENTRE = (159.5, 119.5)
"""pixels"""


def project(p_eye: ArrayLike) -> Array:
    """Pixels of points before a camera: (*batch, 3) m -> (*batch, 2)."""
    p = np.asarray(p_eye, dtype=np.float64)
    return np.asarray(FOCAL_LENGTH * p[..., :2] / p[..., 2:] + CENTRE)


def in_view(p_eye: ArrayLike, near: float, far: float, margin: float = 8.0) -> Flags:
    """Whether points are near..far m away and `margin` pixels inside the image: (*batch, 3)."""
    p = np.asarray(p_eye, dtype=np.float64)
    distance = np.linalg.norm(p, axis=-1)
    ahead = p[..., 2] > near / 2
    u, v = np.moveaxis(project(np.where(ahead[..., None], p, [0.0, 0.0, 1.0])), -1, 0)
    across = (margin <= u) & (u <= WIDTH - 1 - margin)
    along = (margin <= v) & (v <= HEIGHT - 1 - margin)
    return np.asarray(ahead & across & along & (near <= distance) & (distance <= far))


def triangulate(left: ArrayLike, right: ArrayLike, T_left_right: ArrayLike) -> Array:
    """Points in the left eye that fit two views best: (*batch, 2) pixels -> (*batch, 3) m.

    The point halfway along the shortest line between the two rays s d_l and c + t d_r; s and t
    solve the normal equations [1, -e; -e, 1] (s, t) = (d_l c, -d_r c) with e = d_l d_r.
    """
    T = np.asarray(T_left_right, dtype=np.float64)
    d_l, d_r, c = _ray(left), _ray(right) @ T[:3, :3].T, T[:3, 3]
    e, a, b = np.sum(d_l * d_r, axis=-1), d_l @ c, -(d_r @ c)
    s, t = (a + e * b) / (1 - e * e), (b + e * a) / (1 - e * e)
    return np.asarray((s[..., None] * d_l + c + t[..., None] * d_r) / 2)


def eye_transform(T_head_left: ArrayLike, T_head_right: ArrayLike) -> Array:
    """T_left_right of two mountings on the head, (4, 4)."""
    return np.asarray(lie.inverse(T_head_left) @ np.asarray(T_head_right, dtype=np.float64))


def _ray(pixel: ArrayLike) -> Array:
    """Unit vector through a pixel, in its own camera."""
    plane = (np.asarray(pixel, dtype=np.float64) - CENTRE) / FOCAL_LENGTH
    ray = np.concatenate([plane, np.ones((*plane.shape[:-1], 1))], axis=-1)
    return np.asarray(ray / np.linalg.norm(ray, axis=-1, keepdims=True))
