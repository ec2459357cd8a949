"""A body as a lamp beside the eye would show it: grey pictures whose edges are those of the shape.

The light comes from the eye, so no shadow is seen and a point of unit normal n in the direction d
(unit vector) has the brightness

    g = a + (1 - a) |n . d|,

a the share of light from all sides; the background is black. Normals are smoothed over a mesh's
faces and kept apart at its creases. So an edge of the picture is the outline, a part before
another one, or a crease; what edges a detector finds does not depend on where lamps stand.

Hidden parts: as in `depth_buffer`, the ray of a pixel meets the triangle a, b, c where l_a, l_b,
l_c have the sign of its volume, and these are the weights of its corners' normals too.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.model.camera import Camera
from bodyschema.model.kernels import kernel
from bodyschema.vision.contours import NEAR
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]
Grey = NDArray[np.uint8]
Ints = NDArray[np.int64]

CREASE = float(np.deg2rad(40))
"""rad; faces that meet at a larger angle have an edge between them."""

AMBIENT = 0.4
"""a; what is seen edge-on still stands out from the background."""


def corner_normals(surface: Surface) -> Array:
    """(n_faces, 3, 3) unit normals at the corners of every face, smoothed but over creases.

    The normal at a corner is the mean, weighed by area, over the faces that share the corner and
    whose normals differ from this face's by less than `CREASE`.
    """
    a, b, c = np.moveaxis(surface.vertices[surface.faces], 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    flat = surface.planes[:, :3]
    corner = surface.faces.ravel()
    order = np.argsort(corner, kind="stable")
    first = np.searchsorted(corner[order], np.arange(len(surface.vertices) + 1))
    out = np.empty((len(flat), 3, 3))
    _smooth(surface.faces, order // 3, first, flat, area, float(np.cos(CREASE)), out)
    return out


def shaded_image(
    surface: Surface,
    normals: Array,
    T_cam_piece: ArrayLike,
    camera: Camera,
    near: float = NEAR,
) -> Grey:
    """The picture of a body, (height, width) 0 to 255; 0 where there is none.

    Args:
        surface: the visible body.
        normals: (n_faces, 3, 3) of `corner_normals`.
        T_cam_piece: (n_pieces, 3 or 4, 4).
        camera: the view, without distortion.
        near: m; what is nearer to the plane of the camera is not seen.
    """
    points, turned = np.empty_like(surface.vertices), np.empty_like(normals)
    for T, v, f in zip(np.asarray(T_cam_piece), pairwise(surface.vo), pairwise(surface.fo),
                       strict=True):  # fmt: skip
        points[slice(*v)] = surface.vertices[slice(*v)] @ T[:3, :3].T + T[:3, 3]
        turned[slice(*f)] = normals[slice(*f)] @ T[:3, :3].T
    depth = np.full((camera.height, camera.width), np.inf)
    grey = np.zeros(depth.shape, dtype=np.uint8)
    _draw(points[surface.faces], turned, camera.intrinsics, near, AMBIENT, depth, grey)
    return grey


@kernel
def _smooth(
    faces: Ints, sharing: Ints, first: Ints, flat: Array, area: Array, least: float, out: Array
) -> None:
    """Fill the corner normals; `sharing[first[v]:first[v + 1]]` are the faces at vertex v."""
    for f in range(faces.shape[0]):
        for k in range(3):
            v, x, y, z = faces[f, k], 0.0, 0.0, 0.0
            for i in range(first[v], first[v + 1]):
                g = sharing[i]
                if (flat[f] * flat[g]).sum() > least or g == f:
                    x += area[g] * flat[g, 0]
                    y += area[g] * flat[g, 1]
                    z += area[g] * flat[g, 2]
            length = max(np.sqrt(x * x + y * y + z * z), 1e-300)
            out[f, k, 0], out[f, k, 1], out[f, k, 2] = x / length, y / length, z / length


@kernel
def _draw(
    triangles: Array, normals: Array, lens: Array, near: float, ambient: float, depth: Array,
    grey: Grey,
) -> None:  # fmt: skip
    """Draw triangles (n, 3, 3) with the normals (n, 3, 3) of their corners."""
    f_x, f_y, c_x, c_y = lens
    height, width = depth.shape
    for n in range(triangles.shape[0]):
        ax, ay, az = triangles[n, 0]
        bx, by, bz = triangles[n, 1]
        cx, cy, cz = triangles[n, 2]
        left, right, top, bottom = 0, width - 1, 0, height - 1
        if min(az, bz, cz) >= near:
            u0, u1, u2 = f_x * ax / az, f_x * bx / bz, f_x * cx / cz
            v0, v1, v2 = f_y * ay / az, f_y * by / bz, f_y * cy / cz
            left = max(left, int(np.ceil(min(u0, u1, u2) + c_x)))
            right = min(right, int(np.floor(max(u0, u1, u2) + c_x)))
            top = max(top, int(np.ceil(min(v0, v1, v2) + c_y)))
            bottom = min(bottom, int(np.floor(max(v0, v1, v2) + c_y)))
        elif max(az, bz, cz) < near:
            continue
        bc_x, bc_y, bc_z = by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx
        ca_x, ca_y, ca_z = cy * az - cz * ay, cz * ax - cx * az, cx * ay - cy * ax
        ab_x, ab_y, ab_z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
        volume = ax * bc_x + ay * bc_y + az * bc_z
        sign = 1.0 if volume > 0 else -1.0
        for y in range(top, bottom + 1):
            q = (y - c_y) / f_y
            for x in range(left, right + 1):
                p = (x - c_x) / f_x
                l_a = sign * (p * bc_x + q * bc_y + bc_z)
                l_b = sign * (p * ca_x + q * ca_y + ca_z)
                l_c = sign * (p * ab_x + q * ab_y + ab_z)
                total = l_a + l_b + l_c
                if l_a < 0 or l_b < 0 or l_c < 0 or total <= 0:
                    continue
                z = sign * volume / total
                if near <= z < depth[y, x]:
                    depth[y, x] = z
                    N = normals[n]
                    nx = l_a * N[0, 0] + l_b * N[1, 0] + l_c * N[2, 0]
                    ny = l_a * N[0, 1] + l_b * N[1, 1] + l_c * N[2, 1]
                    nz = l_a * N[0, 2] + l_b * N[1, 2] + l_c * N[2, 2]
                    size = np.sqrt((nx * nx + ny * ny + nz * nz) * (p * p + q * q + 1))
                    cosine = abs(nx * p + ny * q + nz) / max(size, 1e-300)
                    grey[y, x] = np.uint8(255 * (ambient + (1 - ambient) * cosine))
