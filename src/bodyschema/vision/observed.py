"""What a camera saw, summed along its rows, so that a span of any length costs two look-ups.

    P[r, x]  = number of mask pixels of row r left of column x
    PD[r, x] = sum of the distances of row r left of column x

The distance of a pixel is that to the nearest pixel of the mask's contour (mask pixels with a
4-neighbour outside the mask), truncated, in units of 1/256 pixel: integers, so that sums over
spans are exact.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError, MissingExtraError

Ints = NDArray[np.int32]
Flags = NDArray[np.bool_]

TRUNCATION = 20.0
"""pixels; a contour pixel farther away than this is as wrong as can be."""

UNIT = 256
"""Distance units to a pixel."""


@dataclass(frozen=True)
class ObservedMask:
    """Which pixels of a view are the body."""

    mask: Flags
    """(height, width)"""
    area: int
    """Pixels of the mask."""
    row_sums: Ints
    """(height, width + 1) P."""
    distance_sums: Ints
    """(height, width + 1) PD, in 1/256 pixel."""
    truncation: float
    """pixels, the largest distance."""

    @classmethod
    def of(cls, mask: ArrayLike, truncation: float = TRUNCATION) -> ObservedMask:
        """Prepare a mask, (height, width); non-zero is the body. Undistort it first.

        Raises:
            InputError: the mask is no single-channel image.
            MissingExtraError: OpenCV is not installed.
        """
        seen = np.asarray(mask) != 0
        if seen.ndim != 2 or seen.size == 0:
            raise InputError(f"a mask has one channel (height, width); got shape {seen.shape}.")
        distance = distance_to(contour_of(seen), truncation)
        return cls(seen, int(seen.sum()), row_sums(seen), row_sums(distance), truncation)


def contour_of(mask: Flags) -> Flags:
    """Mask pixels with a 4-neighbour outside the mask; beyond the image counts as inside."""
    padded = np.pad(mask, 1, constant_values=True)
    inner = padded[:-2, 1:-1] & padded[2:, 1:-1] & padded[1:-1, :-2] & padded[1:-1, 2:]
    return np.asarray(mask & ~inner)


def distance_to(pixels: Flags, truncation: float = TRUNCATION) -> Ints:
    """Distance of every pixel to the nearest of the given ones, (height, width), 1/256 pixel.

    Args:
        pixels: (height, width); if there is none, every distance is the truncation.
        truncation: largest distance, pixels.
    """
    try:
        import cv2
    except ImportError:
        raise MissingExtraError("opencv-python-headless", "vision", "distances") from None
    if not 0 < truncation * UNIT * pixels.shape[1] < 2**31:
        raise InputError(f"the truncation must be positive and moderate, not {truncation} pixels.")
    if not pixels.any():
        return np.full(pixels.shape, round(truncation * UNIT), dtype=np.int32)
    away = (~pixels).astype(np.uint8)
    distance = cv2.distanceTransform(away, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    return np.asarray(np.rint(np.minimum(distance, truncation) * UNIT), dtype=np.int32)


def row_sums(image: NDArray[np.bool_] | Ints) -> Ints:
    """Sums of the pixels left of each column, (height, width + 1)."""
    sums = np.zeros((image.shape[0], image.shape[1] + 1), dtype=np.int32)
    np.cumsum(image, axis=1, dtype=np.int32, out=sums[:, 1:])
    return sums
