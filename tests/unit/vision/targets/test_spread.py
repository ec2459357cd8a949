"""Edges that do not meet at a corner, and blur."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.vision.targets.found import Found
from bodyschema.vision.targets.spread import NO_CORNER, in_no_order, spreads

pytest.importorskip("cv2")


def quarters(blur: float, shift: float = 0.0) -> NDArray[np.uint8]:
    """Two black and two white squares that meet in the middle of a picture, (41, 41)."""
    from scipy.special import ndtr

    at = ndtr((np.arange(41) - 20 - shift) / blur)
    black = np.outer(at, at) + np.outer(1 - at, 1 - at)
    return np.asarray(np.rint(200 * black + 30), dtype=np.uint8)


MIDDLE = np.array([[20.0, 20.0]])


def test_edges_through_a_corner_leave_their_own_width() -> None:
    widths = [float(spreads(quarters(blur), MIDDLE, 5)[0]) for blur in (0.5, 1.0, 1.5, 2.0)]
    assert np.all(np.diff(widths) > 0.1)
    assert widths[1] == pytest.approx(0.8, abs=0.2)
    assert widths[1] < 0.5 * NO_CORNER * in_no_order(5)


def test_edges_in_no_order_have_the_spread_that_is_said() -> None:
    rng = np.random.default_rng(0)
    noise = rng.integers(0, 256, (400, 400)).astype(np.uint8)
    places = rng.uniform(20, 380, (300, 2))
    for half in (3, 5):
        middle = float(np.median(spreads(noise, places, half)))
        assert middle == pytest.approx(in_no_order(half), rel=0.05)


def test_what_is_no_corner_is_held_off() -> None:
    seen = np.array([[20.0, 20.0], [13.0, 12.0]])
    found = Found.of(quarters(0.8), np.array([4, 7]), seen)
    assert found.ids.tolist() == [4]
    assert found.rejected.tolist() == [[13.0, 12.0]]


def test_where_nothing_is_nothing_is_found() -> None:
    flat = np.full((41, 41), 90, np.uint8)
    assert float(spreads(flat, MIDDLE, 5)[0]) == in_no_order(5)
