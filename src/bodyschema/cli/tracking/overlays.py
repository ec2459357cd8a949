"""Overlays: the first camera's pictures with the outline before (red) and after (green)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from bodyschema.cli.tracking.album import Album
from bodyschema.learners.images.markerless_fit import MarkerlessFit
from bodyschema.report.tracking.evidence import OverlayPicture
from bodyschema.vision.overlay import overlay, png_bytes
from bodyschema.vision.poses import piece_poses

Pixels = NDArray[np.uint8]

WIDEST = 1280
"""pixels of a picture inside the report."""
JPEG_QUALITY = 85


def draw_overlays(album: Album, fit: MarkerlessFit, shown: Sequence[int]) -> dict[int, Pixels]:
    """Pictures by their numbers.

    Args:
        album: where they are.
        fit: of the body.
        shown: moments to draw, in order.
    """
    surface, camera = fit.model.surface, fit.model.cameras(album.cameras, fit.z)[0]
    drawn = {}
    for moment, pictures in zip(shown, album.pictures(shown), strict=True):
        poses = [
            piece_poses(body, album.q[moment], [camera], surface.frames)[0, 0]
            for body in (album.body, fit.estimate.body)
        ]
        number = int(album.numbers[moment, 0])
        drawn[number] = overlay(pictures[0], camera, surface, poses)
    return drawn


def overlay_files(drawn: Mapping[int, Pixels]) -> dict[str, bytes]:
    """As PNG files of the result folder."""
    return {f"overlay_{number:04}.png": png_bytes(picture) for number, picture in drawn.items()}


def report_pictures(drawn: Mapping[int, Pixels], camera: str) -> list[OverlayPicture]:
    """Small enough for a page."""
    return [
        OverlayPicture(f"Camera '{camera}', picture {number}", _jpeg(picture))
        for number, picture in drawn.items()
    ]


def _jpeg(picture: Pixels) -> bytes:
    import cv2

    height, width = picture.shape[:2]
    if width > WIDEST:
        size = WIDEST, round(height * WIDEST / width)
        picture = np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)
    options = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
    _, data = cv2.imencode(".jpg", np.ascontiguousarray(picture[..., ::-1]), options)
    return bytes(data)
