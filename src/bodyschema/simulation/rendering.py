"""A small software renderer for pictures: meshes in, nearness and shading of one eye's view out.

No graphics library is used. Triangles are filled one by one into a buffer of nearness (1/z, which
is linear in the image). An arm takes half a second: enough for a figure, too slow for learning.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.simulation import eyes

Array = NDArray[np.float64]

SCALE = 4
"""Picture pixels to an image pixel, each way."""
NEAREST = 0.02
"""m; triangles that reach nearer than this to the eye are left out."""
LIGHT = np.array([-0.45, -0.65, -0.62])
"""Towards the light, in the optical frame: from the upper left, behind the eye."""

STL_TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])


def read_stl(path: str | Path) -> Array:
    """Corners of the triangles of a binary STL file, (n, 3, 3), in the file's unit.

    Raises:
        InputError: the file is missing or is no binary STL.
    """
    try:
        data = Path(path).read_bytes()
    except OSError as error:
        raise InputError(f"cannot read the mesh '{path}': {error.strerror}.") from None
    count = int.from_bytes(data[80:84], "little")
    if len(data) < 84 + count * STL_TRIANGLE.itemsize or len(data) < 84:
        raise InputError(f"'{path}' is not a whole binary STL file.")
    triangles = np.frombuffer(data, STL_TRIANGLE, count, offset=84)
    return np.asarray(triangles["corners"], dtype=np.float64)


def render(triangles: Array) -> tuple[Array, Array]:
    """Nearness (1/m, 0 where empty) and brightness (0..1), each (HEIGHT, WIDTH) * SCALE.

    Args:
        triangles: (n, 3, 3) corners in the optical frame of the eye, m.
    """
    nearness = np.zeros((eyes.HEIGHT * SCALE, eyes.WIDTH * SCALE))
    shade = np.zeros_like(nearness)
    seen = triangles[(triangles[:, :, 2] > NEAREST).all(axis=1)]
    normal = np.cross(seen[:, 1] - seen[:, 0], seen[:, 2] - seen[:, 0])
    length = np.linalg.norm(normal, axis=1)
    # A face with its back to the eye is hidden by a front one, as the meshes are closed.
    front = (length > 0) & (np.sum(normal * seen[:, 0], axis=1) < 0)
    seen, normal = seen[front], normal[front] / length[front, None]
    brightness = 0.35 + 0.65 * np.clip(normal @ (LIGHT / np.linalg.norm(LIGHT)), 0, 1)
    corners = (eyes.project(seen) + 0.5) * SCALE - 0.5
    for corner, near, light in zip(corners, 1 / seen[:, :, 2], brightness, strict=True):
        _fill(nearness, shade, corner, near, light)
    return nearness, shade


def _fill(nearness: Array, shade: Array, corner: Array, near: Array, light: float) -> None:
    """Draw one triangle where it is nearer than what is there."""
    low = np.maximum(np.ceil(corner.min(axis=0)), 0).astype(int)
    high = np.minimum(np.floor(corner.max(axis=0)) + 1, nearness.shape[::-1]).astype(int)
    if (low >= high).any():
        return
    (x0, y0), (x1, y1), (x2, y2) = corner
    area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
    if area == 0:
        return
    x, y = np.arange(low[0], high[0]), np.arange(low[1], high[1])[:, None]
    b = ((x - x0) * (y2 - y0) - (x2 - x0) * (y - y0)) / area
    c = ((x1 - x0) * (y - y0) - (x - x0) * (y1 - y0)) / area
    a = 1 - b - c
    new = a * near[0] + b * near[1] + c * near[2]
    window = np.s_[low[1] : high[1], low[0] : high[0]]
    in_front = (a >= 0) & (b >= 0) & (c >= 0) & (new > nearness[window])
    nearness[window][in_front] = new[in_front]
    shade[window][in_front] = light
