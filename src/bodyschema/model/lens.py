"""Lens: pixels of points before a camera, and how they move with the point and with the lens.

A lens is nine numbers, f_x f_y c_x c_y k1 k2 p1 p2 k3 (a part of kind "lens"), and bends a point
(x, y, z) of the optical frame as `camera` says. With a = x / z, b = y / z, q = a^2 + b^2:

    s  = 1 + k1 q + k2 q^2 + k3 q^3                        s' = ds/dq = k1 + 2 k2 q + 3 k3 q^2
    a' = s a + 2 p1 a b + p2 (q + 2 a^2)                   u = f_x a' + c_x
    b' = s b + p1 (q + 2 b^2) + 2 p2 a b                   v = f_y b' + c_y

    da'/da = s + 2 a^2 s' + 2 p1 b + 6 p2 a                da'/db = 2 a b s' + 2 p1 a + 2 p2 b
    db'/db = s + 2 b^2 s' + 6 p1 b + 2 p2 a                db'/da = da'/db
    d(a, b)/d(x, y, z) = 1/z [1 0 -a; 0 1 -b]

A point behind the camera, or farther from its axis than such a lens can see, is in no picture: its
pixel is UNSEEN, far outside of all, and does not move. So an estimate that hides what was seen pays
for it, and imagined views tell nothing of what they could not show.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

NEAREST = 1e-3
"""m before the camera: what is nearer, or behind, is not seen."""

WIDEST = 4.0
"""q at the edge of all views, 63 degrees off the axis: wider lenses follow another model."""

UNSEEN = -1e4
"""px, both coordinates of a point that no picture shows."""

ROUNDS = 20
"""Newton steps from a bent ray to the straight one; lenses in use need about five."""


def pixels(lens: ArrayLike, points: ArrayLike) -> Array:
    """Pixels of points in the optical frame: (9,) and (n, 3) m -> (n, 2)."""
    numbers, p = np.asarray(lens, dtype=np.float64), np.asarray(points, dtype=np.float64)
    plane, seen = _plane(p)
    bent = _bend(numbers[4:], plane)
    image = bent * numbers[:2] + numbers[2:4]
    return np.where(seen[:, None], image, UNSEEN)


def pixel_derivatives(lens: ArrayLike, points: ArrayLike) -> tuple[Array, Array, Array]:
    """Pixels (n, 2), by the point (n, 2, 3) px/m and by the lens (n, 2, 9)."""
    numbers, p = np.asarray(lens, dtype=np.float64), np.asarray(points, dtype=np.float64)
    plane, seen = _plane(p)
    bent, slope = _bend(numbers[4:], plane), _slope(numbers[4:], plane)
    f = numbers[:2]
    by_plane = f[:, None] * slope
    depth = np.where(seen, p[:, 2], 1.0)
    ahead = np.zeros((len(p), 2, 3))
    ahead[:, 0, 0] = ahead[:, 1, 1] = 1.0
    ahead[:, :, 2] = -plane
    by_point = by_plane @ (ahead / depth[:, None, None])
    by_lens = _by_lens(f, plane, bent)
    image = np.where(seen[:, None], bent * f + numbers[2:4], UNSEEN)
    by_point[~seen], by_lens[~seen] = 0.0, 0.0
    return image, by_point, by_lens


def straight_rays(lens: ArrayLike, image: ArrayLike) -> Array:
    """The (a, b) that a lens bends to given pixels, by Newton's method: (9,), (n, 2) -> (n, 2)."""
    numbers = np.asarray(lens, dtype=np.float64)
    bent = (np.asarray(image, dtype=np.float64) - numbers[2:4]) / numbers[:2]
    plane = bent.copy()
    for _ in range(ROUNDS):
        left = bent - _bend(numbers[4:], plane)
        plane = plane + np.linalg.solve(_slope(numbers[4:], plane), left[..., None])[..., 0]
        if np.abs(left).max(initial=0.0) < 1e-14:
            break
    return plane


def _plane(p: Array) -> tuple[Array, NDArray[np.bool_]]:
    """(n, 2) a and b, zero where the point is not seen, and (n,) whether it is."""
    ahead = p[:, 2] > NEAREST
    plane = p[:, :2] / np.where(ahead, p[:, 2], 1.0)[:, None]
    seen = ahead & (np.sum(plane**2, axis=1) < WIDEST)
    return np.where(seen[:, None], plane, 0.0), seen


def _bend(distortion: Array, plane: Array) -> Array:
    """a' and b' of a and b, (n, 2) -> (n, 2)."""
    k1, k2, p1, p2, k3 = distortion
    a, b = plane[:, 0], plane[:, 1]
    q = a * a + b * b
    s = 1 + q * (k1 + q * (k2 + q * k3))
    bent_a = s * a + 2 * p1 * a * b + p2 * (q + 2 * a * a)
    bent_b = s * b + p1 * (q + 2 * b * b) + 2 * p2 * a * b
    return np.stack([bent_a, bent_b], axis=1)


def _slope(distortion: Array, plane: Array) -> Array:
    """d(a', b') / d(a, b), (n, 2, 2)."""
    k1, k2, p1, p2, k3 = distortion
    a, b = plane[:, 0], plane[:, 1]
    q = a * a + b * b
    s, rise = 1 + q * (k1 + q * (k2 + q * k3)), k1 + q * (2 * k2 + 3 * q * k3)
    slope = np.empty((len(plane), 2, 2))
    slope[:, 0, 0] = s + 2 * a * a * rise + 2 * p1 * b + 6 * p2 * a
    slope[:, 1, 1] = s + 2 * b * b * rise + 6 * p1 * b + 2 * p2 * a
    slope[:, 0, 1] = slope[:, 1, 0] = 2 * a * b * rise + 2 * p1 * a + 2 * p2 * b
    return slope


def _by_lens(f: Array, plane: Array, bent: Array) -> Array:
    """d(u, v) / d(f_x f_y c_x c_y k1 k2 p1 p2 k3), (n, 2, 9)."""
    a, b = plane[:, 0], plane[:, 1]
    q, cross = a * a + b * b, 2 * a * b
    by = np.zeros((len(plane), 2, 9))
    by[:, 0, 0], by[:, 1, 1] = bent[:, 0], bent[:, 1]
    by[:, 0, 2] = by[:, 1, 3] = 1.0
    for column, power in ((4, 1), (5, 2), (8, 3)):
        by[:, :, column] = f * plane * q[:, None] ** power
    by[:, 0, 6], by[:, 1, 6] = f[0] * cross, f[1] * (q + 2 * b * b)
    by[:, 0, 7], by[:, 1, 7] = f[0] * (q + 2 * a * a), f[1] * cross
    return by
