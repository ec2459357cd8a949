"""Pictures of what was found: cells that are me over the image, in the colour of their joint.

Cells that are me are tinted in the colour of the joint that moves them furthest, with a line where
me and not me meet. Cells that move now as the joints do carry a frame, green or, where they are me
already, in the joint's colour. The strip below the image names all joints; those that own no cell
are grey.
"""

from __future__ import annotations

import colorsys
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.attention.body_in_view import BodyInView
from bodyschema.errors import InputError, MissingExtraError

Pixels = NDArray[np.uint8]
Flags = NDArray[np.bool_]

TINT = 0.35
"""Share of the joint's colour in a cell that is me."""
INSET = 2
"""px between the edge of a cell and the frame that says that it moves now."""
LINE, GAP = 18, 12
"""px: height of a line of text below the image, and space between names."""
FONT = 0.4
"""Of OpenCV's plain letters."""
WHITE = np.array([255, 255, 255], dtype=np.uint8)
GREEN = np.array([60, 255, 60], dtype=np.uint8)
GREY = np.array([110, 110, 110], dtype=np.uint8)


def joint_colours(count: int) -> Pixels:
    """(count, 3) red, green, blue: neighbours in the list are far apart on the colour circle."""
    golden = 0.618034
    turns = [(0.33 + k * golden) % 1 for k in range(count)]
    colours = [colorsys.hsv_to_rgb(turn, 0.85, 1.0) for turn in turns]
    return np.asarray(np.rint(255 * np.array(colours).reshape(-1, 3)), dtype=np.uint8)


def draw_found(image: Pixels, found: BodyInView, note: str = "") -> Pixels:
    """Draw the cells that are me over an image.

    Args:
        image: (height, width, 3) red, green, blue, of the size that was searched.
        found: the answer.
        note: a line of text to stand first below the image.

    Returns:
        (height + strip, width, 3); the strip is as high for every answer about the same joints.

    Raises:
        InputError: the image has another size.
        MissingExtraError: OpenCV is not installed.
    """
    width, height = found.size
    if image.shape != (height, width, 3) or image.dtype != np.uint8:
        raise InputError(
            f"expected an 8-bit image of shape {(height, width, 3)}, got {image.dtype} of shape "
            f"{image.shape}."
        )
    colours = joint_colours(len(found.joints))
    picture = image.copy()
    _tint(picture, found, colours)
    _frame(picture, found, colours)
    own = np.unique(found.joint[found.mask])
    shown = [colours[j] if j in own else GREY for j in range(len(colours))]
    return np.vstack([picture, _strip(width, note, found.joints, shown)])


def _tint(picture: Pixels, found: BodyInView, colours: Pixels) -> None:
    """Colour the cells that are me, and draw a line where me and not me meet."""
    padded = np.pad(found.mask, 1)
    for row, col in np.argwhere(found.mask):
        cell = _cell(picture, found.cell_px, row, col)
        colour = _colour(found, row, col, colours)
        cell[:] = np.rint((1 - TINT) * cell + TINT * colour).astype(np.uint8)
        around = padded[row : row + 3, col : col + 3]
        edges = (cell[:1], cell[-1:], cell[:, :1], cell[:, -1:])
        beside = (around[0, 1], around[2, 1], around[1, 0], around[1, 2])
        for edge, me in zip(edges, beside, strict=True):
            if not me:
                edge[:] = colour


def _frame(picture: Pixels, found: BodyInView, colours: Pixels) -> None:
    """A frame inside each cell that moves now."""
    for row, col in np.argwhere(found.now):
        cell = _cell(picture, found.cell_px, row, col)
        inner = cell[INSET:-INSET, INSET:-INSET]
        colour = _colour(found, row, col, colours)
        for edge in (inner[:1], inner[-1:], inner[:, :1], inner[:, -1:]):
            edge[:] = colour


def _cell(picture: Pixels, side: int, row: int, col: int) -> Pixels:
    return picture[row * side : (row + 1) * side, col * side : (col + 1) * side]


def _colour(found: BodyInView, row: int, col: int, colours: Pixels) -> Pixels:
    joint = found.joint[row, col]
    return np.asarray(colours[joint] if joint >= 0 else GREEN, dtype=np.uint8)


def _strip(width: int, note: str, joints: Sequence[str], colours: Sequence[Pixels]) -> Pixels:
    """The note, then the joints from left to right in as many lines as they take."""
    cv2 = _vision()
    words, x, line = [(4, 0, note, WHITE)], 4, 1
    for joint, colour in zip(joints, colours, strict=True):
        long = cv2.getTextSize(joint, cv2.FONT_HERSHEY_SIMPLEX, FONT, 1)[0][0]
        if x > 4 and x + long > width:
            x, line = 4, line + 1
        words.append((x, line, joint, colour))
        x += long + GAP
    strip = np.zeros((LINE * (line + 1), width, 3), np.uint8)
    for x, line, text, colour in words:
        place, ink = (x, LINE * line + 13), tuple(int(c) for c in colour)
        cv2.putText(strip, text, place, cv2.FONT_HERSHEY_SIMPLEX, FONT, ink, 1, cv2.LINE_AA)
    return strip


def _vision() -> Any:
    try:
        import cv2
    except ImportError:
        raise MissingExtraError("opencv-python-headless", "vision", "drawing") from None
    return cv2
