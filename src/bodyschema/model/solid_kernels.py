"""Lines and triangles: where a line enters a solid, and how near it passes one that it misses.

A triangle has the corners a, b, c, counter-clockwise from outside, and the unit normal n. The line
is p + s u with |u| = 1. Only triangles are looked at whose outside the push F presses on, that is
n.F < -limit |F|.

    entered   Moeller and Trumbore 1997, "Fast, minimum storage ray/triangle intersection"
    passed    a line that misses a triangle is nearest to it on one of its three edges
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import kernel

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SLACK = 1e-9
"""Share of a triangle's side by which the line may pass it: no line slips between two triangles."""


@kernel
def entered(
    corners: Array,
    normals: Array,
    push: Array,
    limit: float,
    p: Array,
    u: Array,
    faces: Ints,
    along: Array,
) -> int:
    """Write the triangles (m, 3, 3) that the line meets, and s of each; returns how many."""
    found = 0
    for m in range(corners.shape[0]):
        if normals[m, 0] * push[0] + normals[m, 1] * push[1] + normals[m, 2] * push[2] >= -limit:
            continue
        ax, ay, az = corners[m, 0]
        bx, by, bz = corners[m, 1, 0] - ax, corners[m, 1, 1] - ay, corners[m, 1, 2] - az
        cx, cy, cz = corners[m, 2, 0] - ax, corners[m, 2, 1] - ay, corners[m, 2, 2] - az
        hx, hy, hz = u[1] * cz - u[2] * cy, u[2] * cx - u[0] * cz, u[0] * cy - u[1] * cx
        volume = bx * hx + by * hy + bz * hz
        if volume == 0.0:
            continue
        x, y, z = p[0] - ax, p[1] - ay, p[2] - az
        v = (x * hx + y * hy + z * hz) / volume
        if v < -SLACK or v > 1 + SLACK:
            continue
        gx, gy, gz = y * bz - z * by, z * bx - x * bz, x * by - y * bx
        w = (u[0] * gx + u[1] * gy + u[2] * gz) / volume
        if w < -SLACK or v + w > 1 + SLACK:
            continue
        faces[found] = m
        along[found] = (cx * gx + cy * gy + cz * gz) / volume
        found += 1
    return found


@kernel
def passed(
    corners: Array,
    normals: Array,
    push: Array,
    limit: float,
    p: Array,
    u: Array,
    point: Array,
) -> int:
    """Write the point (3,) of the triangles' edges nearest to the line; returns its triangle.

    -1 if the push presses on no triangle.
    """
    nearest, best = np.inf, -1
    for m in range(corners.shape[0]):
        if normals[m, 0] * push[0] + normals[m, 1] * push[1] + normals[m, 2] * push[2] >= -limit:
            continue
        for k in range(3):
            q, r = corners[m, k], corners[m, (k + 1) % 3]
            # Across the line: d from the line to q, e along the edge.
            qu = (q[0] - p[0]) * u[0] + (q[1] - p[1]) * u[1] + (q[2] - p[2]) * u[2]
            eu = (r[0] - q[0]) * u[0] + (r[1] - q[1]) * u[1] + (r[2] - q[2]) * u[2]
            dx, dy, dz = (
                q[0] - p[0] - qu * u[0],
                q[1] - p[1] - qu * u[1],
                q[2] - p[2] - qu * u[2],
            )
            ex, ey, ez = (
                r[0] - q[0] - eu * u[0],
                r[1] - q[1] - eu * u[1],
                r[2] - q[2] - eu * u[2],
            )
            ee = ex * ex + ey * ey + ez * ez
            t = 0.0
            if ee > 0.0:
                t = min(max(-(dx * ex + dy * ey + dz * ez) / ee, 0.0), 1.0)
            gap = (dx + t * ex) ** 2 + (dy + t * ey) ** 2 + (dz + t * ez) ** 2
            if gap < nearest:
                nearest, best = gap, m
                for i in range(3):
                    point[i] = q[i] + t * (r[i] - q[i])
    return best
