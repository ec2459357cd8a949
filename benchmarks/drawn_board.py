"""A board as a camera sees it: OpenCV's own pattern, bent by a homography, four times too fine.

Before a lens that bends, every pixel is looked up on the sheet along its own ray.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.camera import Camera
from bodyschema.model.lens import straight_rays
from bodyschema.model.parts import lens
from bodyschema.vision.targets.detection import dictionary
from bodyschema.vision.targets.target import Target

Array = NDArray[np.float64]

PX = 60
"""Of the sheet, a square."""

FINE = 4
ROUGH = 2
"""Times as fine, before a lens that bends: every part of a pixel has a ray of its own there."""

GREY = 128
"""Of what lies round the sheet."""
K = np.array([[600.0, 0.0, 320.0], [0.0, 600.0, 240.0], [0.0, 0.0, 1.0]])


def sheet(target: Target) -> tuple[NDArray[np.uint8], Array]:
    """A picture of the target lying flat, and where its frame has (0, 0), px; a margin round it."""
    import cv2

    c, r, margin = target.columns, target.rows, PX
    if target.kind == "charuco":
        size = (c * PX, r * PX)
        board: Any = cv2.aruco.CharucoBoard(
            (c, r), target.square_m, target.marker_m, dictionary(target.dictionary)
        )
        flat = board.generateImage((size[0] + 2 * margin, size[1] + 2 * margin), None, margin, 1)
        return flat, np.array([margin, margin]) - 0.5
    if target.kind == "chessboard":
        squares = np.add.outer(np.arange(r + 1), np.arange(c + 1)) % 2
        flat = np.kron(255 * squares, np.ones((PX, PX))).astype(np.uint8)
        return np.pad(flat, margin, constant_values=255), np.full(2, margin + PX) - 0.5
    across, down = target.corners[:, :2].max(axis=0) / target.square_m
    flat = np.full((round(down + 2) * PX, round(across + 2) * PX), 255, np.uint8)
    if target.kind == "tags":
        side = round(PX * target.marker_m / target.square_m)
        for k in range(c * r):
            tag = cv2.aruco.generateImageMarker(
                dictionary(target.dictionary), target.first_id + k, side
            )
            i, j = divmod(k, c)
            flat[margin // 2 + i * PX :, margin // 2 + j * PX :][:side, :side] = tag
        return flat, np.full(2, margin // 2) - 0.5
    for x, y, _ in target.corners / target.square_m:
        cv2.circle(flat, (round(PX * (x + 1)), round(PX * (y + 1))), PX // 4, 0, -1, cv2.LINE_AA)
    return flat, np.full(2, PX)


def drawn(target: Target, T_camera_target: Array) -> NDArray[np.uint8]:
    """The picture (480, 640) of a target at a pose before the lens K."""
    import cv2

    flat, origin = sheet(target)
    scale = target.square_m / PX
    to_target = np.array(
        [[scale, 0, -scale * origin[0]], [0, scale, -scale * origin[1]], [0, 0, 1.0]]
    )
    homography = K @ T_camera_target[:3, [0, 1, 3]] @ to_target
    finer = np.array([[FINE, 0, (FINE - 1) / 2], [0, FINE, (FINE - 1) / 2], [0, 0, 1.0]])
    large = cv2.warpPerspective(
        flat, finer @ homography, (640 * FINE, 480 * FINE), borderValue=GREY, flags=cv2.INTER_AREA
    )
    return np.asarray(cv2.resize(large, (640, 480), interpolation=cv2.INTER_AREA), dtype=np.uint8)


def drawn_through(target: Target, T_camera_target: Array, camera: Camera) -> NDArray[np.uint8]:
    """The picture of a target at a pose, as a camera with any lens takes it."""
    import cv2

    flat, origin = sheet(target)
    key = (*parts_of(camera), camera.fisheye)
    rays = _rays(camera.width, camera.height, key)
    back = np.linalg.inv(T_camera_target[:3, [0, 1, 3]])
    on = rays @ back[:, :2].T + back[:, 2]
    at = on[..., :2] / on[..., 2:] * (PX / target.square_m) + origin
    at[on[..., 2] <= 0] = -10.0
    columns, rows = np.moveaxis(at.astype(np.float32), -1, 0)
    large = cv2.remap(flat, columns, rows, cv2.INTER_LINEAR, borderValue=GREY)
    size = (camera.width, camera.height)
    return np.asarray(cv2.resize(large, size, interpolation=cv2.INTER_AREA), dtype=np.uint8)


def parts_of(camera: Camera) -> tuple[float, ...]:
    """The numbers of its lens."""
    return tuple(lens(camera).values.tolist())


@lru_cache(maxsize=1)
def _rays(width: int, height: int, key: tuple[float, ...]) -> Array:
    """(height ROUGH, width ROUGH, 2) where the ray of each part of a pixel meets depth 1."""
    v, u = (np.mgrid[: ROUGH * height, : ROUGH * width] + 0.5) / ROUGH - 0.5
    image = np.stack([u.ravel(), v.ravel()], axis=1)
    parts = np.array_split(image, 64)
    rays = np.concatenate([straight_rays(np.array(key[:-1]), some) for some in parts])
    return np.asarray(rays.reshape(ROUGH * height, ROUGH * width, 2))
