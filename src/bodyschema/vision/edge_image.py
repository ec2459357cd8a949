"""Edges that a camera saw, by direction, and how far every pixel is from one that fits.

A Canny edge pixel has the tangent direction phi = atan2(g_y, g_x) + pi/2 (mod pi), g the gradient
of grey or, in a colour image, of the channel where it is largest. Directions fall into K channels
of width pi / K. With D_j the distance to the nearest edge pixel of channel j, the oriented one is

    D(x, k) = min over j of  D_j(x) + lambda |k - j| pi / K,

|k - j| counted round the circle: an edge of another direction is as bad as one farther away (Liu,
Tuzel, Veeraraghavan, Chellappa 2010, "Fast directional chamfer matching", Eq. 3). It is truncated
and kept in 1/256 pixel as whole numbers, so that sums do not depend on their order.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.vision.observed import TRUNCATION, UNIT, distance_to

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Shorts = NDArray[np.int16]
Flags = NDArray[np.bool_]

CHANNELS = 8
"""K."""

TURN_COST = 6.0
"""lambda, pixels per radian."""

THRESHOLDS = (60.0, 140.0)
"""Canny's, in grey levels of a Sobel gradient: an edge starts at the higher and goes on to the
lower one."""


@dataclass(frozen=True)
class ObservedEdges:
    """Edges of one view by direction."""

    edges: Flags
    """(height, width) edge pixels."""
    channel: Ints
    """(height, width) direction of each, 0 to K - 1."""
    distance: Shorts
    """(K, height, width) D, in 1/256 pixel."""
    truncation: float
    """pixels, the largest distance."""

    @classmethod
    def of(
        cls,
        image: ArrayLike,
        thresholds: tuple[float, float] = THRESHOLDS,
        turn_cost: float = TURN_COST,
        truncation: float = TRUNCATION,
    ) -> ObservedEdges:
        """Find the edges of an image without distortion.

        Args:
            image: (height, width) grey or (height, width, channels), 8 bit; or a boolean mask.
            thresholds: of Canny.
            turn_cost: lambda, pixels per radian.
            truncation: largest distance, pixels; at most 127.

        Raises:
            InputError: no 8-bit image.
            MissingExtraError: OpenCV is not installed.
        """
        if not 0 < truncation < 128:
            raise InputError(f"the truncation must lie in 0 to 127 pixels, not {truncation}.")
        g_x, g_y = strongest_gradient(image)
        edges = _cv2().Canny(g_x, g_y, *thresholds) > 0
        phi = np.arctan2(g_y.astype(np.float64), g_x) + np.pi / 2
        channel = np.rint(phi * CHANNELS / np.pi).astype(np.int64) % CHANNELS
        layers = [distance_to(edges & (channel == k), truncation) for k in range(CHANNELS)]
        distance = _joined(np.stack(layers), turn_cost, truncation)
        return cls(edges, channel, distance, truncation)


def strongest_gradient(image: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
    """Sobel gradients g_x, g_y (height, width) int16 of the channel where they are largest.

    Raises:
        InputError: no 8-bit image.
    """
    seen = np.asarray(image)
    seen = seen.astype(np.uint8) * np.uint8(255) if seen.dtype == np.bool_ else seen
    if seen.dtype != np.uint8 or seen.ndim not in (2, 3) or seen.size == 0:
        raise InputError(
            "expected an 8-bit image (height, width) or (height, width, channels), got "
            f"{seen.dtype} of shape {seen.shape}."
        )
    cv2 = _cv2()
    layers = [seen] if seen.ndim == 2 else [seen[..., i] for i in range(seen.shape[2])]
    layers = [cv2.GaussianBlur(layer, (3, 3), 0) for layer in layers]
    g_x = np.stack([cv2.Sobel(layer, cv2.CV_16S, 1, 0) for layer in layers])
    g_y = np.stack([cv2.Sobel(layer, cv2.CV_16S, 0, 1) for layer in layers])
    best = np.argmax(np.abs(g_x.astype(np.int32)) + np.abs(g_y), axis=0)[None]
    return (
        np.ascontiguousarray(np.take_along_axis(g_x, best, 0)[0]),
        np.ascontiguousarray(np.take_along_axis(g_y, best, 0)[0]),
    )


def _joined(layers: NDArray[np.int32], turn_cost: float, truncation: float) -> Shorts:
    """D from the distances D_j of each channel alone, both (K, height, width) in 1/256 pixel."""
    best = layers.copy()
    for away in range(1, CHANNELS // 2 + 1):
        cost = round(turn_cost * away * np.pi / CHANNELS * UNIT)
        for shift in (away, -away):
            np.minimum(best, np.roll(layers, shift, axis=0) + cost, out=best)
    return np.minimum(best, round(truncation * UNIT)).astype(np.int16)


def _cv2() -> Any:
    try:
        import cv2
    except ImportError:
        raise MissingExtraError("opencv-python-headless", "vision", "finding edges") from None
    return cv2
