"""What a detector is given, checked once where it comes in: settings, frames and positions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError, did_you_mean

Array = NDArray[np.float64]
Grey = NDArray[np.uint8]

LEAST_CELLS = 3
"""Cells that an image has at least, each way."""


@dataclass(frozen=True)
class Frame:
    """One picture and what the encoders said then."""

    time: float
    """s"""
    image: Grey
    """(height, width) grey."""
    q: ArrayLike
    """(J,) rad or m, joint positions at the same time stamp."""


def check_settings(joints: Sequence[str], cell_px: int, camera_joints: Sequence[str]) -> None:
    """Refuse settings that no detector can work with.

    Raises:
        InputError: no joints, a name twice, a camera joint that is none, or a cell too small.
    """
    if not joints:
        raise InputError("a detector needs the name of at least one joint.")
    if len(set(joints)) < len(joints):
        twice = sorted({name for name in joints if list(joints).count(name) > 1})
        raise InputError(f"joints are named once each; named twice: {', '.join(twice)}.")
    for name in camera_joints:
        if name not in joints:
            raise InputError(f"no joint '{name}' to carry the camera{did_you_mean(name, joints)}")
    if set(camera_joints) == set(joints):
        raise InputError("every joint carries the camera; name one that moves the body in view.")
    if cell_px < 8:
        raise InputError(f"a cell of {cell_px} pixels shows too little; give 8 or more.")


def grid(size: tuple[int, int], cell_px: int) -> tuple[int, int]:
    """Rows and columns of whole cells in an image of (width, height) pixels.

    Raises:
        InputError: fewer than three either way.
    """
    width, height = size
    rows, cols = height // cell_px, width // cell_px
    if min(rows, cols) < LEAST_CELLS:
        raise InputError(
            f"an image of {width} x {height} pixels has fewer than {LEAST_CELLS} cells of "
            f"{cell_px} pixels each way; give larger images or smaller cells."
        )
    return rows, cols


def check_frame(size: tuple[int, int], joints: Sequence[str], last: float, frame: Frame) -> Array:
    """Positions (J,) of a frame that can be used.

    Raises:
        InputError: not the announced image, not one finite number a joint, or time runs backward.
    """
    width, height = size
    time, image, positions = frame.time, frame.image, frame.q
    if not isinstance(image, np.ndarray) or image.dtype != np.uint8 or image.ndim != 2:
        got = f"{image.dtype} {image.shape}" if isinstance(image, np.ndarray) else repr(type(image))
        raise InputError(f"a frame is a grey image, uint8 (height, width); got {got}.")
    if image.shape != (height, width):
        raise InputError(
            f"expected frames of {width} x {height} pixels as announced at the start; "
            f"got {image.shape[1]} x {image.shape[0]}."
        )
    if not np.isfinite(time) or time <= last:
        raise InputError(
            f"frames come in order of time, each later than the one before; {time:g} s came "
            f"after {last:g} s."
        )
    q = np.asarray(positions, dtype=np.float64)
    if q.shape != (len(joints),):
        raise InputError(f"expected {len(joints)} joint positions; got shape {q.shape}.")
    if not np.isfinite(q).all():
        name = joints[int(np.flatnonzero(~np.isfinite(q))[0])]
        raise InputError(
            f"the position of joint '{name}' at {time:g} s is {q[~np.isfinite(q)][0]}."
        )
    return q
