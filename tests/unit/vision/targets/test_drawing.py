"""Photographs with their corners drawn in: colours where they belong, lines as long as is said."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.vision.overlay import GREEN, RED
from bodyschema.vision.targets.drawing import REJECTED, SEEN, Marks, drawn, enlargement

pytest.importorskip("cv2")

GREY = np.full((120, 200, 3), 128, np.uint8)
SEEN_AT = np.array([[40.0, 30.0], [160.0, 30.0], [40.0, 90.0], [160.0, 90.0]])
NOTHING = np.empty((0, 2))


def count(picture: NDArray[np.uint8], colour: tuple[int, int, int]) -> int:
    return int((picture == colour).all(axis=-1).sum())


def halves(marks: Marks) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    picture = drawn(GREY, marks, 400)
    assert picture.shape[1] == 800
    return picture[:, :400], picture[:, 400:]


def test_before_stands_left_and_after_right() -> None:
    far, near = SEEN_AT + np.array([8.0, 0.0]), SEEN_AT + np.array([0.1, 0.0])
    left, right = halves(Marks(SEEN_AT, far, near, NOTHING))
    assert count(left, RED) > 100 > count(left, GREEN)
    assert count(right, GREEN) > 100 > count(right, RED)
    assert count(left, SEEN) > 50
    assert count(left, REJECTED) == 0


def test_what_is_not_used_has_a_colour_of_its_own() -> None:
    left, right = halves(Marks(NOTHING, NOTHING, NOTHING, SEEN_AT))
    assert min(count(left, REJECTED), count(right, REJECTED)) > 50
    assert count(left, SEEN) == 0
    left, _ = halves(Marks(SEEN_AT, SEEN_AT, SEEN_AT, NOTHING, held_off=True))
    assert count(left, REJECTED) > 50
    assert count(left, SEEN) == 0


def test_nothing_found_and_nothing_predicted_are_drawn_too() -> None:
    left, _ = halves(Marks(NOTHING, NOTHING, NOTHING, NOTHING))
    assert left.shape[0] == 240
    nowhere = np.full_like(SEEN_AT, np.nan)
    left, _ = halves(Marks(SEEN_AT, nowhere, nowhere, NOTHING))
    assert count(left, RED) == 0


def test_lines_are_enlarged_to_be_seen() -> None:
    assert enlargement(np.array([0.3, 0.4, 0.5])) == 50
    assert enlargement(np.array([300.0])) == 1
    assert enlargement(np.array([np.nan])) == 1
