"""Where the observed outline lies, looked for along the normals of the imagined one.

Along the normal n of a rim point p the image is read at p + t n, t = -reach .. reach. The answer is
d, pixels outward from the imagined outline, positive where the body is larger than imagined.

In a mask, d is where the slightly blurred mask falls through 1/2 from inside to outside, the
crossing nearest to t = 0, by linear interpolation. A mask pixel tells only whether its centre is
inside; the blur makes the pixels along the contour share what they know.

In an image, with g the gradient (of the channel where it is largest) and a = n.g,

    d = argmax |a(t)|   over the local maxima with |a| >= strength, |a| >= |g| / sqrt 2

and a of the sign that is asked for: the direction must fit within 45 degrees, and the body be the
darker side (a > 0), the brighter one (a < 0) or either. The top of a parabola through the maximum
and its neighbours gives fractions of a step. Evidence of colour (see `colours`) is an image in
which the body is always the brighter side.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.model.kernels import kernel
from bodyschema.vision.correspondences import Rim
from bodyschema.vision.edge_image import strongest_gradient

Array = NDArray[np.float64]
Floats = NDArray[np.float32]
Flags = NDArray[np.bool_]

REACH = 15.0
"""pixels"""

STEP = 1.0
"""pixels between readings along a normal; a parabola through closer ones follows the kinks that
bilinear reading makes at every pixel."""

BLUR = 1.0
"""pixels, standard deviation."""

STRENGTH = 60.0
"""grey levels of a Sobel gradient (8 times the slope): Canny's lower threshold."""


@dataclass(frozen=True)
class Outline:
    """How far outward the observed outline lies from points of the imagined one."""

    distance: Array
    """(n,) pixels; 0 where nothing was found."""
    found: Flags
    """(n,)"""


@dataclass(frozen=True)
class Gradient:
    """Slopes of one view's image."""

    g_x: Floats
    """(height, width)"""
    g_y: Floats
    """(height, width)"""

    @classmethod
    def of(cls, image: ArrayLike) -> Gradient:
        """Sobel gradient of an 8-bit image; of the channel where it is largest."""
        g_x, g_y = strongest_gradient(image)
        return cls(g_x.astype(np.float32), g_y.astype(np.float32))

    @classmethod
    def of_evidence(cls, evidence: ArrayLike) -> Gradient:
        """Sobel gradient of the evidence of colour, scaled so that a full step is 255 levels."""
        seen = np.asarray(evidence, dtype=np.float32)
        share = np.float32(255) / (1 + np.exp(-seen))
        cv2, smooth = _cv2(), _cv2().GaussianBlur(share, (0, 0), BLUR)
        return cls(cv2.Sobel(smooth, cv2.CV_32F, 1, 0), cv2.Sobel(smooth, cv2.CV_32F, 0, 1))


def search_masks(rim: Rim, masks: Sequence[ArrayLike], reach: float = REACH) -> Outline:
    """Look for the outline of masks.

    Args:
        rim: the imagined outline.
        masks: (height, width) of each view; non-zero is the body. Undistort them first.
        reach: pixels to either side.
    """
    _check(rim, len(masks))
    cv2 = _cv2()
    seen = [(np.asarray(mask) != 0).astype(np.float32) for mask in masks]
    blurred = [cv2.GaussianBlur(mask, (0, 0), BLUR) for mask in seen]
    t, p = _readings(rim, blurred, reach)
    falls = (p[:, :-1] >= 0.5) & (p[:, 1:] < 0.5)
    rise = np.where(falls, p[:, :-1] - p[:, 1:], 1.0)
    place = t[:-1] + STEP * np.where(falls, (p[:, :-1] - 0.5) / rise, 0.0)
    nearest = np.argmin(np.where(falls, np.abs(place), np.inf), axis=1)[:, None]
    found = np.asarray(falls.any(axis=1))
    return Outline(np.where(found, np.take_along_axis(place, nearest, 1)[:, 0], 0.0), found)


def search_edges(
    rim: Rim,
    images: Sequence[Gradient],
    reach: float = REACH,
    polarity: ArrayLike = 0,
    strength: float = STRENGTH,
) -> Outline:
    """Look for the strongest edge that fits.

    Args:
        rim: the imagined outline.
        images: of each view.
        reach: pixels to either side.
        polarity: one for all points or (n,): +1 where the body is the darker side, -1 where it is
            the brighter one, 0 where nobody knows.
        strength: least slope across the outline, grey levels of a Sobel gradient.
    """
    _check(rim, len(images))
    t, g_x = _readings(rim, [image.g_x for image in images], reach)
    _, g_y = _readings(rim, [image.g_y for image in images], reach)
    a = rim.normal[:, :1] * g_x + rim.normal[:, 1:] * g_y
    wanted = np.broadcast_to(np.asarray(polarity, dtype=np.float64), (len(rim),))[:, None]
    size = np.where(wanted == 0, np.abs(a), wanted * a)
    fits = (size >= strength) & (2 * a**2 >= g_x**2 + g_y**2)
    before, here, after = size[:, :-2], size[:, 1:-1], size[:, 2:]
    peak = fits[:, 1:-1] & (here >= before) & (here > after)
    best = np.argmax(np.where(peak, here, -np.inf), axis=1)[:, None]
    low, top, high = (np.take_along_axis(part, best, 1)[:, 0] for part in (before, here, after))
    bend = low - 2 * top + high
    with np.errstate(invalid="ignore", divide="ignore"):
        place = t[1:-1][best[:, 0]] + STEP * 0.5 * (low - high) / bend
    found = peak.any(axis=1) & np.isfinite(place)
    return Outline(np.where(found, place, 0.0), found)


def _readings(rim: Rim, images: Sequence[NDArray[Any]], reach: float) -> tuple[Array, Array]:
    """t (m,) and the images there, (n, m); nan beyond the image."""
    half = int(np.ceil(reach / STEP))
    t = STEP * np.arange(-half, half + 1, dtype=np.float64)
    out = np.full((len(rim), len(t)), np.nan)
    for c, image in enumerate(images):
        mine = np.flatnonzero(rim.camera == c)
        read = np.empty((len(mine), len(t)))
        _read_lines(
            np.ascontiguousarray(image, dtype=np.float32),
            rim.pixel[mine],
            rim.normal[mine],
            t,
            read,
        )
        out[mine] = read
    return t, out


@kernel
def _read_lines(image: Floats, pixel: Array, normal: Array, t: Array, out: Array) -> None:
    """Bilinear readings at pixel + t normal, (n, m)."""
    height, width = image.shape
    for i in range(pixel.shape[0]):
        for k in range(t.shape[0]):
            x, y = pixel[i, 0] + t[k] * normal[i, 0], pixel[i, 1] + t[k] * normal[i, 1]
            if not (0 <= x <= width - 1 and 0 <= y <= height - 1):
                out[i, k] = np.nan
                continue
            c, r = min(int(x), width - 2), min(int(y), height - 2)
            a, b = x - c, y - r
            upper = (1 - a) * image[r, c] + a * image[r, c + 1]
            lower = (1 - a) * image[r + 1, c] + a * image[r + 1, c + 1]
            out[i, k] = (1 - b) * upper + b * lower


def _check(rim: Rim, n_images: int) -> None:
    if len(rim) and rim.camera.max() >= n_images:
        raise InputError(
            f"the contour was found in {rim.camera.max() + 1} views, there are {n_images} images."
        )


def _cv2() -> Any:
    try:
        import cv2
    except ImportError:
        raise MissingExtraError("opencv-python-headless", "vision", "looking for edges") from None
    return cv2
