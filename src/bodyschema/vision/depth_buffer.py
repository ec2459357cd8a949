"""The plain way to see a body: ask every pixel about every triangle. Slow; the referee of tests.

The ray of a pixel is d = ((u - c_x) / f_x, (v - c_y) / f_y, 1). With the corners a, b, c of a
triangle in the optical frame, the weights

    l_a = d.(b x c),   l_b = d.(c x a),   l_c = d.(a x b)

all have the sign of a.(b x c) where the ray, or the line behind it, meets the triangle, at depth

    z = a.(b x c) / (l_a + l_b + l_c).

Nothing is projected and nothing has to be clipped: a hit counts if z >= near.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.model.camera import Camera
from bodyschema.model.kernels import kernel
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]


def depth_image(
    surface: Surface, T_cam_piece: ArrayLike, camera: Camera, near: float = 0.01
) -> Array:
    """Depth z of the nearest triangle at every pixel, m, inf where there is none; (height, width).

    Args:
        surface: the visible body.
        T_cam_piece: (n_pieces, 3 or 4, 4).
        camera: the view.
        near: m; nearer hits do not count.
    """
    T = np.asarray(T_cam_piece, dtype=np.float64)
    piece = np.repeat(np.arange(len(surface.frames)), np.diff(surface.vo))
    points = (T[piece, :3, :3] @ surface.vertices[:, :, None])[..., 0] + T[piece, :3, 3]
    depth = np.full((camera.height, camera.width), np.inf)
    _fill(points[surface.faces], camera.intrinsics, near, depth)
    return depth


@kernel
def _fill(triangles: Array, lens: Array, near: float, depth: Array) -> None:
    """Draw triangles (n, 3, 3) into the depth image."""
    f_x, f_y, c_x, c_y = lens
    height, width = depth.shape
    for n in range(triangles.shape[0]):
        a, b, c = triangles[n]
        left, right, top, bottom = 0, width - 1, 0, height - 1
        if min(a[2], b[2], c[2]) >= near:
            z = triangles[n, :, 2]
            u, v = f_x * triangles[n, :, 0] / z + c_x, f_y * triangles[n, :, 1] / z + c_y
            left, right = max(left, int(np.ceil(u.min()))), min(right, int(np.floor(u.max())))
            top, bottom = max(top, int(np.ceil(v.min()))), min(bottom, int(np.floor(v.max())))
        bc, ca, ab = np.cross(b, c), np.cross(c, a), np.cross(a, b)
        volume = (a * bc).sum()
        sign = 1.0 if volume > 0 else -1.0
        for y in range(top, bottom + 1):
            for x in range(left, right + 1):
                p, q = (x - c_x) / f_x, (y - c_y) / f_y
                l_a = sign * (p * bc[0] + q * bc[1] + bc[2])
                l_b = sign * (p * ca[0] + q * ca[1] + ca[2])
                l_c = sign * (p * ab[0] + q * ab[1] + ab[2])
                if l_a >= 0 and l_b >= 0 and l_c >= 0 and l_a + l_b + l_c > 0:
                    z = sign * volume / (l_a + l_b + l_c)
                    if near <= z < depth[y, x]:
                        depth[y, x] = z
