"""Overlays: the first camera's pictures with the outline before (red) and after (green)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from bodyschema.cli.tracking.album import Album
from bodyschema.model.camera import Camera
from bodyschema.model.tree import Body
from bodyschema.report.tracking.evidence import OverlayPicture
from bodyschema.vision.overlay import jpeg_bytes, overlay, png_bytes
from bodyschema.vision.poses import piece_poses
from bodyschema.vision.surface import Surface

Pixels = NDArray[np.uint8]

WIDEST = 1280
"""pixels of a picture inside the report."""


def draw_overlays(
    album: Album, surface: Surface, camera: Camera, found: Body, shown: Sequence[int]
) -> dict[int, Pixels]:
    """Pictures by their numbers.

    Args:
        album: where they are, with the body as believed.
        surface: what shows of it.
        camera: the first one, as it was found.
        found: the corrected body, with its cameras.
        shown: moments to draw, in order.
    """
    drawn = {}
    for moment, pictures in zip(shown, album.pictures(shown), strict=True):
        poses = [
            piece_poses(body, album.q[moment], [camera], surface.frames)[0, 0]
            for body in (album.body, found)
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
        OverlayPicture(f"Camera '{camera}', picture {number}", jpeg_bytes(picture, WIDEST))
        for number, picture in drawn.items()
    ]
