"""Lens: pixels of points before a camera, and how they move with the point and with the lens.

A lens is f_x f_y c_x c_y and the coefficients of one of three models of `distortion`, told apart by
their count (a part of kind "lens"). A point (x, y, z) of the optical frame is on the ray a = x / z,
b = y / z, which the model bends to a', b':

    u = f_x a' + c_x                     d(a, b)/d(x, y, z) = 1/z [1 0 -a; 0 1 -b]
    v = f_y b' + c_y

A point behind the camera, or farther from its axis than such a lens can see, is in no picture: its
pixel is UNSEEN, far outside of all, and does not move. So an estimate that hides what was seen pays
for it, and imagined views tell nothing of what they could not show.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.model.distortion import MODELS, OF_COUNT, Distortion

Array = NDArray[np.float64]

NEAREST = 1e-3
"""m before the camera: what is nearer, or behind, is not seen."""

UNSEEN = -1e4
"""px, both coordinates of a point that no picture shows."""

ROUNDS = 20
"""Newton steps from a bent ray to the straight one; lenses in use need about five."""


FARTHEST = 4.0
"""Times the widest q: where rays end that a lens cannot see."""


def pixels(lens: ArrayLike, points: ArrayLike) -> Array:
    """Pixels of points in the optical frame: (4 + k,) and (n, 3) m -> (n, 2)."""
    numbers, p = np.asarray(lens, dtype=np.float64), np.asarray(points, dtype=np.float64)
    model = distortion_of(numbers)
    plane, seen = _plane(p, model.widest)
    bent = model.bend(numbers[4:], plane)
    image = bent * numbers[:2] + numbers[2:4]
    return np.where(seen[:, None], image, UNSEEN)


def pixel_derivatives(lens: ArrayLike, points: ArrayLike) -> tuple[Array, Array, Array]:
    """Pixels (n, 2), by the point (n, 2, 3) px/m and by the lens (n, 2, 4 + k)."""
    numbers, p = np.asarray(lens, dtype=np.float64), np.asarray(points, dtype=np.float64)
    model = distortion_of(numbers)
    plane, seen = _plane(p, model.widest)
    bent, slope = model.bend(numbers[4:], plane), model.slope(numbers[4:], plane)
    f = numbers[:2]
    by_plane = f[:, None] * slope
    depth = np.where(seen, p[:, 2], 1.0)
    ahead = np.zeros((len(p), 2, 3))
    ahead[:, 0, 0] = ahead[:, 1, 1] = 1.0
    ahead[:, :, 2] = -plane
    by_point = by_plane @ (ahead / depth[:, None, None])
    by_lens = np.zeros((len(p), 2, len(numbers)))
    by_lens[:, 0, 0], by_lens[:, 1, 1] = bent[:, 0], bent[:, 1]
    by_lens[:, 0, 2] = by_lens[:, 1, 3] = 1.0
    by_lens[:, :, 4:] = f[:, None] * model.by_coefficient(numbers[4:], plane)
    image = np.where(seen[:, None], bent * f + numbers[2:4], UNSEEN)
    by_point[~seen], by_lens[~seen] = 0.0, 0.0
    return image, by_point, by_lens


def straight_rays(lens: ArrayLike, image: ArrayLike) -> Array:
    """The (a, b) that a lens bends to pixels, by Newton's method: (4 + k,), (n, 2) -> (n, 2)."""
    numbers = np.asarray(lens, dtype=np.float64)
    model = distortion_of(numbers)
    bent = (np.asarray(image, dtype=np.float64) - numbers[2:4]) / numbers[:2]
    plane = model.straightened(numbers[4:], bent)
    for _ in range(ROUNDS):
        left = bent - model.bend(numbers[4:], plane)
        plane = plane + np.linalg.solve(model.slope(numbers[4:], plane), left[..., None])[..., 0]
        # A pixel that no ray of the model reaches would send them away for ever.
        far = np.sqrt(np.sum(plane**2, axis=1) / (FARTHEST * model.widest))
        plane = plane / np.maximum(far, 1.0)[:, None]
        if np.abs(left).max(initial=0.0) < 1e-14:
            break
    return plane


def distortion_of(lens: Array) -> Distortion:
    """The model of a lens. Raises InputError for a count of numbers that no model has."""
    name = OF_COUNT.get(len(lens) - 4)
    if name is None:
        counts = ", ".join(f"{4 + count} ({name})" for count, name in OF_COUNT.items())
        raise InputError(f"a lens has {counts} numbers; got {len(lens)}.")
    return MODELS[name]


def _plane(p: Array, widest: float) -> tuple[Array, NDArray[np.bool_]]:
    """(n, 2) a and b, zero where the point is not seen, and (n,) whether it is."""
    ahead = p[:, 2] > NEAREST
    plane = p[:, :2] / np.where(ahead, p[:, 2], 1.0)[:, None]
    seen = ahead & (np.sum(plane**2, axis=1) < widest)
    return np.where(seen[:, None], plane, 0.0), seen
