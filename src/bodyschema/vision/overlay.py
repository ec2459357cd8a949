"""A picture: imagined outlines drawn over what a camera saw, for people to look at.

An outline is what two cross-shaped erosions take away from the silhouette at `magnify` times the
size of the image: a line of two pixels just inside the imagined contour.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.atomic import new_file
from bodyschema.errors import InputError, MissingExtraError
from bodyschema.model.camera import Camera
from bodyschema.vision.contours import silhouette
from bodyschema.vision.observed import contour_of
from bodyschema.vision.surface import Surface

Pixels = NDArray[np.uint8]
Colour = tuple[int, int, int]

LINE = 2
"""Pixels of the picture."""

JPEG_QUALITY = 85

RED, GREEN = (230, 40, 40), (40, 210, 70)
"""Red, green, blue: what was believed before, and after."""


def overlay(
    image: ArrayLike,
    camera: Camera,
    surface: Surface,
    poses: Sequence[ArrayLike],
    colours: Sequence[Colour] = (RED, GREEN),
    magnify: int = 2,
) -> Pixels:
    """Draw the outlines of bodies over an image.

    Args:
        image: (height, width) grey or (height, width, 3) red, green, blue; 8 bit, straightened by
            `Camera.undistort`.
        camera: that took it.
        surface: the visible body.
        poses: of each body, T_cam_piece (n_pieces, 3 or 4, 4); later ones are drawn on top.
        colours: of the outlines.
        magnify: pixels of the picture to a pixel of the image, each way.

    Returns:
        (magnify height, magnify width, 3) red, green, blue.

    Raises:
        InputError: the image is not one of this camera, or there are too few colours.
    """
    seen: NDArray[Any] = np.asarray(image)
    if seen.dtype != np.uint8 or seen.shape[:2] != (camera.height, camera.width):
        raise InputError(
            f"expected an 8-bit image of {camera.height} rows and {camera.width} columns, got "
            f"{seen.dtype} of shape {seen.shape}."
        )
    if len(colours) < len(poses):
        raise InputError(f"there are {len(poses)} bodies to draw and {len(colours)} colours.")
    picture = seen if seen.ndim == 3 else np.repeat(seen[..., None], 3, axis=2)
    picture = np.repeat(np.repeat(picture, magnify, axis=0), magnify, axis=1)
    large = camera.scaled(magnify * camera.width, magnify * camera.height)
    for T_cam_piece, colour in zip(poses, colours, strict=False):
        inside = silhouette(surface, T_cam_piece, large)
        for _ in range(LINE):
            rim = contour_of(inside)
            picture[rim], inside = colour, inside & ~rim
    return picture


def save_png(picture: Pixels, path: str | Path) -> None:
    """Write a picture (height, width, 3) red, green, blue, whole or not at all.

    Raises:
        InputError: the place cannot be written.
        MissingExtraError: OpenCV is not installed.
    """
    data = png_bytes(picture)
    with new_file(Path(path)) as temporary:
        temporary.write_bytes(data)


def png_bytes(picture: Pixels) -> bytes:
    """A picture (height, width, 3) red, green, blue as a PNG file.

    Raises:
        MissingExtraError: OpenCV is not installed.
    """
    try:
        import cv2
    except ImportError:
        raise MissingExtraError("opencv-python-headless", "vision", "writing pictures") from None
    _, data = cv2.imencode(".png", np.ascontiguousarray(picture[..., ::-1]))
    return bytes(data)


def jpeg_bytes(picture: Pixels, widest: int) -> bytes:
    """A picture (height, width, 3) red, green, blue as a JPEG file, shrunk to a width in pixels.

    Raises:
        MissingExtraError: OpenCV is not installed.
    """
    try:
        import cv2
    except ImportError:
        raise MissingExtraError("opencv-python-headless", "vision", "writing pictures") from None
    height, width = picture.shape[:2]
    if width > widest:
        size = widest, max(round(height * widest / width), 1)
        picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
    options = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
    _, data = cv2.imencode(".jpg", np.ascontiguousarray(picture[..., ::-1]), options)
    return bytes(data)
