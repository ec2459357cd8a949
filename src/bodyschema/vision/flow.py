"""How each cell of the image moved from one frame to the next, and how far that can be believed.

Dense optical flow (DIS, Kroeger et al. 2016) on a picture of at most about 320 pixels' width gives
w(x), a displacement for every pixel x. In a cell C it is averaged with the squared gradient of the
grey value g as weight, since flow is seen only where the picture varies:

    v = sum_C |dg|^2 w / sum_C |dg|^2

Dense flow leaks from what moves over what lies beside it. So the cell's own pixels are asked: does
the flow bring the second picture nearer to the first one than the background's motion b does?

    E(w) = variance over C of g2(x + w) - g1(x),      support = (E(b) - E(v)) / (E(b) + E_0)

A variance, so that a shadow that passes over the cell does not count; E_0 is what camera noise
alone leaves. A cell's own motion is v - b as far as it is supported: zero where nothing moves,
where there is no texture, and where flow has only leaked in.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import MissingExtraError
from bodyschema.vision.background import background_flow

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Grey = NDArray[np.uint8]

WORKING_WIDTH = 300
"""pixels; pictures are reduced by a whole factor as long as they stay wider than this."""
TEXTURE = 20.0
"""Squared grey values a pixel: mean squared gradient at which a cell counts half."""
NOISE_ERROR = 4.0
"""E_0, squared grey values; twice the variance of a blurred camera image, and a little more."""
LITTLE, ENOUGH = 0.1, 0.4
"""Support at which nothing and all of a cell's motion is believed."""
SAME = 5.0
"""Grey values: mean difference that video coding leaves in a cell of a repeated picture."""
COMPANY = 3
"""Neighbours, of eight, that move with a cell: fewer at a shadow's edge than on a body."""


@dataclass(frozen=True)
class CellFlow:
    """Motion of the cells from one frame to the next."""

    own: Array
    """(rows, cols, 2) pixels/frame against the background; 0 where no motion is believed."""
    background: Array
    """(rows, cols, 2) pixels/frame that the camera's own motion gives the view."""
    texture: Array
    """(rows, cols) from 0, nothing to see motion by, to 1."""


def prepare(image: Grey, cell_px: int) -> Grey:
    """A grey image, smaller if it is large, cut to whole cells and blurred against noise."""
    cv2 = opencv()
    factor, (height, width) = reduction(image.shape[1], cell_px), image.shape
    rows, cols = height // cell_px, width // cell_px
    whole = image[: rows * cell_px, : cols * cell_px]
    if factor > 1:
        size = (whole.shape[1] // factor, whole.shape[0] // factor)
        whole = cv2.resize(whole, size, interpolation=cv2.INTER_AREA)
    return np.asarray(cv2.GaussianBlur(whole, (5, 5), 0), dtype=np.uint8)


def reduction(width: int, cell_px: int) -> int:
    """The whole factor by which `prepare` makes an image smaller; cells stay whole pixels."""
    factors = [k for k in range(1, cell_px + 1) if cell_px % k == 0 and width // k >= WORKING_WIDTH]
    return max((k for k in factors if cell_px // k >= 8), default=1)


def cell_flow(before: Grey, after: Grey, cell_px: int, factor: int, turns: bool) -> CellFlow:
    """Motion from one prepared image to the next.

    Args:
        before: what `prepare` gave for the earlier frame.
        after: and for the later one.
        cell_px: side of a cell in the frame, pixels.
        factor: by which the prepared images are smaller.
        turns: whether joints carry the camera; otherwise it stands, and shakes at most.
    """
    cv2, side = opencv(), cell_px // factor
    dense = _dis().calc(before, after, None)
    slope_x = cv2.Sobel(before, cv2.CV_32F, 1, 0, scale=0.125)
    slope_y = cv2.Sobel(before, cv2.CV_32F, 0, 1, scale=0.125)
    weight = slope_x * slope_x + slope_y * slope_y
    mean_weight = cell_means(weight, side)
    v = cell_means(dense * weight[..., None], side) / (mean_weight[..., None] + 1e-3)
    texture = mean_weight / (mean_weight + TEXTURE)
    b = background_flow(v, texture, turns)
    still = _mismatch(before, after, b, side)
    moved = _mismatch(before, after, v, side)
    support = (still - moved) / (still + NOISE_ERROR)
    gate = np.clip((support - LITTLE) / (ENOUGH - LITTLE), 0.0, 1.0)
    own = (gate * texture)[..., None] * (v - b)
    return CellFlow(factor * own, factor * b, texture)


def cell_means(picture: NDArray[Any], side: int) -> Array:
    """Means over square cells: (rows * side, cols * side[, k]) -> (rows, cols[, k])."""
    cv2 = opencv()
    size = (picture.shape[1] // side, picture.shape[0] // side)
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), dtype=np.float64)


def repeats(before: Grey, after: Grey, cell_px: int, factor: int) -> bool:
    """Whether no cell of a prepared image differs from the one before beyond noise and coding."""
    difference = opencv().absdiff(before, after)
    return float(cell_means(difference.astype(np.float32), cell_px // factor).max()) < SAME


def in_company(moves: Flags) -> Flags:
    """Moving cells that have at least `COMPANY` moving cells among their eight neighbours.

    Past the border the picture is mirrored about the outermost cells, so that what enters there is
    not cut short and no cell is its own neighbour.

    Args:
        moves: (rows, cols), at least two either way.
    """
    around = np.pad(moves, 1, mode="reflect").astype(np.int64)
    blocks = np.lib.stride_tricks.sliding_window_view(around, (3, 3))
    return np.asarray(moves & (blocks.sum(axis=(2, 3)) - moves >= COMPANY))


def _mismatch(before: Grey, after: Grey, flow: Array, side: int) -> Array:
    """E of each cell, (rows, cols), for one displacement a cell, (rows, cols, 2)."""
    cv2 = opencv()
    height, width = before.shape
    if not flow.any():
        back = after
    else:
        shift = flow.astype(np.float32).repeat(side, axis=0).repeat(side, axis=1)
        x, y = _grid(width, height)
        back = cv2.remap(
            after, x + shift[..., 0], y + shift[..., 1], cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REPLICATE,
        )  # fmt: skip
    difference = cv2.subtract(back, before, dtype=cv2.CV_32F)
    return cell_means(difference * difference, side) - cell_means(difference, side) ** 2


@cache
def _grid(width: int, height: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    x, y = np.meshgrid(np.arange(width, dtype=np.float32), np.arange(height, dtype=np.float32))
    return x, y


@cache
def _dis() -> Any:
    """The flow's own scratch memory is used again from frame to frame."""
    cv2 = opencv()
    return cv2.DISOpticalFlow_create(cv2.DISOPTICAL_FLOW_PRESET_FAST)


def opencv() -> Any:
    """The module cv2.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        import cv2
    except ImportError:
        raise MissingExtraError("opencv-python-headless", "vision", "optical flow") from None
    return cv2
