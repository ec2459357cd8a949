"""A photograph of a board with what was found in it and what was predicted, for people to look at.

Two panels of the part that shows the board: on the left what the robot as modelled predicts, on the
right the corrected one. Rings are corners as they were found, crosses where they were predicted,
lines lead from one to the other, so many times as long as is said in the panel's corner.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.vision.overlay import GREEN, RED, Colour

Array = NDArray[np.float64]
Pixels = NDArray[np.uint8]

SEEN, REJECTED = (20, 120, 255), (230, 0, 230)
"""Red, green, blue: of corners that are used, and of those that are not."""

MARGIN = 0.25
"""Of the board's extent, shown around it."""

LONG = 24.0
"""px of a panel, that the middle line should have: lines are enlarged to about that."""

STEPS = (1, 2, 5, 10, 20, 50, 100, 200, 500)
"""Enlargements."""

LINE = 2
"""px of a panel."""

FINER = 4
"""Bits of a pixel in which places are drawn."""


@dataclass(frozen=True)
class Marks:
    """What is drawn over one photograph, px of it."""

    seen: Array
    """(m, 2) corners that were used."""
    before: Array
    """(m, 2) where the robot as modelled predicts them; nan where nothing is known."""
    after: Array
    """(m, 2) where the corrected one does."""
    rejected: Array
    """(k, 2) what was detected and is no corner, or is held off."""
    held_off: bool = False
    """The whole picture was left out by the fit."""


def drawn(picture: Pixels, marks: Marks, width: int = 800) -> Pixels:
    """Both panels side by side.

    Args:
        picture: (height, width, 3) red, green, blue.
        marks: on it.
        width: px of a panel.

    Returns:
        (h, 2 width, 3) red, green, blue.
    """
    left, top, right, bottom = _part(picture, np.concatenate([marks.seen, marks.rejected]))
    scale = width / (right - left)
    size = (width, max(round((bottom - top) * scale), 1))
    cv2 = _opencv()
    way = cv2.INTER_LINEAR if scale > 1 else cv2.INTER_AREA
    shown = np.asarray(cv2.resize(picture[top:bottom, left:right], size, interpolation=way))
    panels = []
    for predicted, colour in ((marks.before, RED), (marks.after, GREEN)):
        panel = shown.copy()
        seen, told, rejected = (
            (places - (left, top) + 0.5) * scale - 0.5
            for places in (marks.seen, predicted, marks.rejected)
        )
        _panel(panel, seen, told, colour, marks.held_off)
        for place in rejected:
            _ring(panel, place, REJECTED)
        panels.append(panel)
    return np.hstack(panels)


def enlargement(lengths: Array) -> int:
    """How many times as long lines are drawn, of lengths (m,) px of a panel."""
    known = lengths[np.isfinite(lengths)]
    middle = float(np.median(known)) if len(known) else LONG
    return next((step for step in reversed(STEPS) if step * middle <= LONG), 1)


def _panel(panel: Pixels, seen: Array, predicted: Array, colour: Colour, held_off: bool) -> None:
    """Draw rings, lines and crosses, places in px of the panel."""
    cv2 = _opencv()
    times = enlargement(np.linalg.norm(predicted - seen, axis=1))
    for place, told in zip(seen, predicted, strict=True):
        _ring(panel, place, REJECTED if held_off else SEEN)
        if not np.isfinite(told).all():
            continue
        end = np.clip(place + times * (told - place), -1e4, 1e4)
        cv2.line(panel, _fine(place), _fine(end), colour, LINE, cv2.LINE_AA, FINER)
        for across in ((3.0, 3.0), (3.0, -3.0)):
            cv2.line(
                panel, _fine(told - across), _fine(told + across), colour, LINE, cv2.LINE_AA, FINER
            )
    if len(seen) and np.isfinite(predicted).any():
        low = panel.shape[0] - 1
        cv2.rectangle(panel, (0, low - 32), (90, low), (0, 0, 0), cv2.FILLED)
        white, font = (255, 255, 255), cv2.FONT_HERSHEY_SIMPLEX
        cv2.putText(panel, f"x{times}", (8, low - 8), font, 0.8, white, 1, cv2.LINE_AA)


def _ring(panel: Pixels, place: Array, colour: Colour) -> None:
    cv2 = _opencv()
    cv2.circle(panel, _fine(place), 6 << FINER, colour, LINE, cv2.LINE_AA, FINER)


def _fine(place: Array) -> tuple[int, int]:
    x, y = np.rint(np.clip(place, -1e4, 1e4) * (1 << FINER)).astype(int)
    return int(x), int(y)


def _part(picture: Pixels, places: Array) -> tuple[int, int, int, int]:
    """The part of a picture that shows the corners: left, top, right and bottom, px."""
    height, width = picture.shape[:2]
    if len(places) < 2:
        return 0, 0, width, height
    low, high = places.min(axis=0), places.max(axis=0)
    margin = MARGIN * float(np.max(high - low)) + 10
    left, top = np.floor(np.clip(low - margin, 0, None)).astype(int)
    right, bottom = np.ceil(np.minimum(high + margin + 1, [width, height])).astype(int)
    return int(left), int(top), max(int(right), int(left) + 1), max(int(bottom), int(top) + 1)


def _opencv() -> Any:
    import cv2

    return cv2
