"""What is left of a piece that reaches behind the near plane, such as an arm beside the head.

A face with a corner nearer than the plane takes no part in the contour: its sign becomes 0, which
turns its neighbours' edges into edges of the contour by itself. If it still has a corner before the
plane it is clipped to z >= near, which leaves three or four corners, and the outline of that
polygon is added to the contour with the face's own sign. The new corners on an edge are always
computed from the corner in front, so that both faces of the edge get the same ones.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import kernel
from bodyschema.vision.scratch import Scratch
from bodyschema.vision.surface import Columns

Floats = NDArray[np.float32]


@kernel
def clip_piece(
    columns: Columns, b: int, T: Floats, lens: Floats, near: np.float32, memory: Scratch, n: int
) -> int:
    """Take the faces of piece b that reach behind the plane out of S; append what is left of them.

    Args:
        columns: of the surface.
        b: the piece.
        T: (3, 4) T_cam_piece.
        lens: (4,) f_x, f_y, c_x, c_y.
        near: m.
        memory: where signs and segments are.
        n: segments there are.

    Returns:
        How many segments there are now.
    """
    corner, polygon = np.empty((3, 3), np.float32), np.empty((5, 2), np.float32)
    for f in range(columns.fo[b], columns.fo[b + 1]):
        in_front = 0
        for i in range(3):
            v = columns.F[f, i]
            x, y, z = columns.VX[v], columns.VY[v], columns.VZ[v]
            for k in range(3):
                corner[i, k] = T[k, 0] * x + T[k, 1] * y + T[k, 2] * z + T[k, 3]
            in_front += corner[i, 2] >= near
        if in_front == 3:
            continue
        weight = np.int32(memory.S[f])
        memory.S[f] = 0
        m = _clip(corner, near, lens, polygon)
        polygon[m] = polygon[0]
        for i in range(m):
            n = _add_segment(polygon[i], polygon[i + 1], weight, memory, n)
    return n


@kernel
def _clip(corner: Floats, near: np.float32, lens: Floats, polygon: Floats) -> int:
    """Pixels of the part of a triangle (3, 3) at z >= near, and their number: 0, 3 or 4."""
    m = 0
    for i in range(3):
        a, b = corner[i], corner[(i + 1) % 3]
        if a[2] >= near:
            _pixel(a[0], a[1], a[2], lens, polygon[m])
            m += 1
        if (a[2] >= near) != (b[2] >= near):
            if a[2] < near:
                a, b = b, a
            t = (a[2] - near) / (a[2] - b[2])
            _pixel(a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), near, lens, polygon[m])
            m += 1
    return m


@kernel
def _pixel(x: np.float32, y: np.float32, z: np.float32, lens: Floats, out: Floats) -> None:
    nearness = np.float32(1) / z
    out[0] = lens[0] * x * nearness + lens[2]
    out[1] = lens[1] * y * nearness + lens[3]


@kernel
def _add_segment(a: Floats, b: Floats, weight: np.int32, memory: Scratch, n: int) -> int:
    """Append the segment from pixel a to pixel b, if it crosses a row; as for contour edges."""
    if a[1] > b[1]:
        a, b, weight = b, a, np.int32(-weight)
    begin = max(np.ceil(a[1]), np.float32(0))
    stop = min(np.ceil(b[1]), np.float32(memory.full.shape[0]))
    if stop <= begin:
        return n
    g = (b[0] - a[0]) / (b[1] - a[1])
    memory.first[n], memory.rows[n] = np.int32(begin), np.int32(stop - begin)
    memory.x[n], memory.g[n] = a[0] + (begin - a[1]) * g, g
    memory.weight[n] = np.int32(8) + weight
    return n + 1
