"""A lens to begin with, from pictures of a flat board alone (Zhang 2000), where nobody knows it.

OpenCV's calibration has a pose of its own for every picture, which the robot does not vouch for; it
is used for a start, and the poses are thrown away. Pictures that fit much worse than the middle one
are left out and the rest calibrated again, so that a board of another kind does not bend the lens.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.camera import Camera

Array = NDArray[np.float64]

LEAST = 3
"""Pictures, each a different tilt of the board: one tells two numbers of a lens."""

MOST = 30
"""Pictures, spread over all: a start needs no more, and costs the cube of it."""

WORSE, ROUNDS = 3.0, 3
"""Times the median error of a picture that is left out; how often."""

FEW = 6
"""Corners of a picture that counts: four fit any lens."""


def begun_lens(
    corners: Sequence[Array], images: Sequence[Array], width: int, height: int
) -> Camera | None:
    """The camera that sees the board best in all pictures; None when they are too few.

    Args:
        corners: (m, 3) m of each picture, places on the board.
        images: (m, 2) px, where they were seen.
        width: px
        height: px
    """
    kept = [k for k in range(len(corners)) if len(corners[k]) >= FEW]
    kept = (
        [kept[k] for k in np.unique(np.linspace(0, len(kept) - 1, MOST).astype(int))]
        if kept
        else []
    )
    lens = None
    for _ in range(ROUNDS):
        if len(kept) < LEAST:
            return lens
        lens, errors = _calibrated(
            [corners[k] for k in kept], [images[k] for k in kept], width, height
        )
        good = errors <= WORSE * np.median(errors)
        if good.all():
            break
        kept = [k for k, one in zip(kept, good, strict=True) if one]
    return lens


def _calibrated(
    corners: Sequence[Array], images: Sequence[Array], width: int, height: int
) -> tuple[Camera, Array]:
    """OpenCV's lens without its k3, which pictures tell last, and each picture's error, px rms."""
    import cv2

    places: Any = [one.astype(np.float32).reshape(-1, 1, 3) for one in corners]
    seen: Any = [one.astype(np.float32).reshape(-1, 1, 2) for one in images]
    empty: Any = None
    found = cv2.calibrateCameraExtended(
        places, seen, (width, height), empty, empty, flags=cv2.CALIB_FIX_K3
    )
    K, distortion, errors = found[1], found[2], found[-1]
    lens = Camera("lens", "lens", width, height, K, np.asarray(distortion).ravel()[:5])
    return lens, np.asarray(errors).ravel()
