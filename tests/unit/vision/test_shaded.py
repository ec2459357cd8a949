"""Shaded pictures: what is nearest, how bright, and where normals are smoothed."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.model.camera import Camera
from bodyschema.vision.depth_buffer import depth_image
from bodyschema.vision.shaded import AMBIENT, corner_normals, shaded_image
from bodyschema.vision.surface import Surface

CAMERA = Camera.from_fov("eye", "eye", 64, 48, 1.0)
CUBE = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float) / 10
SIDES = [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6],
         [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]  # fmt: skip


def box() -> Surface:
    return Surface.build({"box": (CUBE, SIDES)})


def placed(z: float, turn: float = 0.0) -> np.ndarray:
    T = np.eye(4)[None]
    T[0, :3, 3] = 0.0, 0.0, z
    c, s = np.cos(turn), np.sin(turn)
    T[0, :3, :3] = [[c, 0, s], [0, 1, 0], [-s, 0, c]]
    return T


def test_it_shows_what_the_depth_image_shows() -> None:
    T = placed(0.5, 0.6)
    image = shaded_image(box(), corner_normals(box()), T, CAMERA)
    np.testing.assert_array_equal(image > 0, np.isfinite(depth_image(box(), T, CAMERA)))


@pytest.mark.parametrize("turn", [0.0, 0.5, np.pi / 4])
def test_a_flat_side_is_as_bright_as_it_faces_the_eye(turn: float) -> None:
    T = placed(0.5, turn)
    image = shaded_image(box(), corner_normals(box()), T, CAMERA)
    depth = depth_image(box(), T, CAMERA)
    rows, columns = np.nonzero(np.isfinite(depth))
    f_x, f_y, c_x, c_y = CAMERA.intrinsics
    d = np.stack([(columns - c_x) / f_x, (rows - c_y) / f_y, np.ones(len(rows))], axis=1)
    sides = T[0, :3, :3].T  # rows: normals of the three pairs of sides
    at = (d * depth[rows, columns, None] - T[0, :3, 3]) @ T[0, :3, :3]
    normal = sides[np.abs(at).argmax(axis=1)]
    cosine = np.abs((normal * d).sum(axis=1)) / np.linalg.norm(d, axis=1)
    expected = 255 * (AMBIENT + (1 - AMBIENT) * cosine)
    off = np.abs(image[rows, columns] - expected)
    assert np.mean(off < 1.01) > 0.97  # but for pixels on an edge of the box


def test_creases_stay_and_round_shapes_are_smoothed() -> None:
    surface = box()
    np.testing.assert_allclose(
        corner_normals(surface), np.repeat(surface.planes[:, None, :3], 3, axis=1), atol=1e-12
    )
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    ring = np.stack([np.cos(angle), np.sin(angle)], axis=1) / 10
    V = np.concatenate([np.column_stack([ring, np.full(24, h)]) for h in (-0.1, 0.1)])
    F = [[i, (i + 1) % 24, 24 + i] for i in range(24)]
    F += [[(i + 1) % 24, 24 + (i + 1) % 24, 24 + i] for i in range(24)]
    tube = Surface.build({"tube": (V, F)})
    outward = tube.vertices[tube.faces] * [10, 10, 0]
    assert np.sum(corner_normals(tube) * outward, axis=2).min() > 0.995


def test_what_is_too_near_is_not_seen() -> None:
    assert not shaded_image(box(), corner_normals(box()), placed(0.5), CAMERA, near=0.7).any()
    inside = shaded_image(box(), corner_normals(box()), placed(0.0), CAMERA, near=0.01)
    assert (inside > 0).all()
