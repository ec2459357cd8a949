"""How far from a corner the edges pass that are said to meet there: what is no corner, and blur.

With g the gradients in a window and x their places, seen from the corner,

    spread^2 = sum (g . x)^2 / sum |g|^2                px^2

Edges through the corner leave their own width, which is about a pixel where a picture is sharp and
grows with blur. Edges that have nothing to do with the corner pass at any distance: for gradients
in all directions everywhere in a window 2 h + 1 wide, spread^2 = h (h + 1) / 3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Grey = NDArray[np.uint8]

NO_CORNER = 0.75
"""Of the spread of edges in no order: in 6 sets of photographs corners have 0.2 to 0.6 of it, and
what a detector made of drawings over a board 0.9 and more."""

LEAST_HALF = 3
"""px: a window of fewer shows no edge."""


def spreads(grey: Grey, image: Array, half: int) -> Array:
    """Distance at which edges pass corners, rms in a window about each, (m,) px.

    Args:
        grey: (height, width).
        image: (m, 2) px.
        half: the window is 2 half + 1 wide.
    """
    picture = grey.astype(np.float64)
    height, width = grey.shape
    by_v, by_u = np.gradient(picture, axis=0), np.gradient(picture, axis=1)
    out = np.empty(len(image))
    for k, (u, v) in enumerate(image):
        i, j = round(float(v)), round(float(u))
        rows, columns = (
            np.arange(max(middle - half, 0), min(middle + half + 1, size))
            for middle, size in ((i, height), (j, width))
        )
        window = np.ix_(rows, columns)
        past = by_u[window] * (columns - u) + by_v[window] * (rows - v)[:, None]
        size = float(np.sum(by_u[window] ** 2 + by_v[window] ** 2))
        out[k] = np.sqrt(np.sum(past**2) / size) if size else in_no_order(half)
    return out


def in_no_order(half: int) -> float:
    """The spread of edges that have nothing to do with a corner, px."""
    return float(np.sqrt(half * (half + 1) / 3))
