"""A lens to begin with, from pictures of a flat board alone (Zhang 2000), where nobody knows it.

OpenCV's calibration has a pose of its own for every picture, which the robot does not vouch for; it
is used for a start, and the poses are thrown away. Pictures that fit much worse than the middle one
are left out and the rest calibrated again, so that a board of another kind does not bend the lens.
A rational lens begins as a plumb_bob: what the further coefficients add, the robot's fit finds.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.camera import Camera
from bodyschema.model.distortion import FISHEYE, MODELS, PLUMB_BOB

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
    corners: Sequence[Array],
    images: Sequence[Array],
    width: int,
    height: int,
    model: str = PLUMB_BOB,
) -> Camera | None:
    """The camera that sees the board best in all pictures; None when they are too few.

    Args:
        corners: (m, 3) m of each picture, places on the board.
        images: (m, 2) px, where they were seen.
        width: px
        height: px
        model: of its distortion; see `model.distortion`.
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
            [corners[k] for k in kept], [images[k] for k in kept], (width, height), model
        )
        good = errors <= WORSE * np.median(errors)
        if good.all():
            break
        kept = [k for k, one in zip(kept, good, strict=True) if one]
    return lens


def _calibrated(
    corners: Sequence[Array], images: Sequence[Array], size: tuple[int, int], model: str
) -> tuple[Camera, Array]:
    """OpenCV's lens, and each picture's error, px rms."""
    find = _fisheye if model == FISHEYE else _pinhole
    K, k, turns, moves = find(corners, images, size)
    given = np.zeros(len(MODELS[model].names))
    given[: len(k)] = k
    lens = Camera("lens", "lens", *size, K, given, fisheye=model == FISHEYE)
    errors = []
    for p, seen, w, t in zip(corners, images, turns, moves, strict=True):
        placed = p @ lie.exp_so3(np.ravel(w)).T + np.ravel(t)
        errors.append(float(np.sqrt(np.mean((lens.project(placed) - seen) ** 2))))
    return lens, np.array(errors)


def _pinhole(corners: Sequence[Array], images: Sequence[Array], size: tuple[int, int]) -> Any:
    """K, five coefficients, and a pose a picture: without k3, which pictures tell last."""
    import cv2

    places: Any = [one.astype(np.float32).reshape(-1, 1, 3) for one in corners]
    seen: Any = [one.astype(np.float32).reshape(-1, 1, 2) for one in images]
    empty: Any = None
    _, K, k, turns, moves = cv2.calibrateCamera(
        places, seen, size, empty, empty, flags=cv2.CALIB_FIX_K3
    )
    return K, np.ravel(k)[:5], turns, moves


def _fisheye(corners: Sequence[Array], images: Sequence[Array], size: tuple[int, int]) -> Any:
    """K, four coefficients, and a pose a picture.

    OpenCV 5 moved the flags to another module and gave them other values; a wrong one leaves poses
    as they were guessed, without an error.
    """
    import cv2

    flags = 0
    for name in ("CALIB_RECOMPUTE_EXTRINSIC", "CALIB_FIX_SKEW"):
        flags |= getattr(cv2.fisheye if hasattr(cv2.fisheye, name) else cv2, name)
    places: Any = [one.astype(np.float64).reshape(1, -1, 3) for one in corners]
    seen: Any = [one.astype(np.float64).reshape(1, -1, 2) for one in images]
    K, k = np.eye(3), np.zeros(4)
    _, K, k, turns, moves = cv2.fisheye.calibrate(places, seen, size, K, k, flags=flags)
    return np.array(K), np.ravel(k), turns, moves
