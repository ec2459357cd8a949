"""Observed masks: contour, distances and row sums."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt

from bodyschema.errors import InputError
from bodyschema.vision.observed import UNIT, ObservedMask, contour_of, distance_to

cv2 = pytest.importorskip("cv2")


@pytest.fixture
def mask() -> np.ndarray:
    seen = np.zeros((40, 60), dtype=np.uint8)
    cv2.circle(seen, (20, 18), 12, 255, -1)
    cv2.rectangle(seen, (25, 10), (70, 16), 255, -1)
    return seen


def test_the_contour_is_what_a_cross_erodes(mask: np.ndarray) -> None:
    cross = cv2.getStructuringElement(cv2.MORPH_CROSS, (3, 3))
    eroded = cv2.erode(mask, cross, borderType=cv2.BORDER_CONSTANT, borderValue=255)
    np.testing.assert_array_equal(contour_of(mask != 0), (mask != 0) & (eroded == 0))


def test_sums_along_rows_give_back_mask_and_distance(mask: np.ndarray) -> None:
    seen = ObservedMask.of(mask, truncation=8.0)
    np.testing.assert_array_equal(np.diff(seen.row_sums, axis=1), mask != 0)
    assert (seen.row_sums[:, 0] == 0).all()
    assert seen.area == np.count_nonzero(mask)
    exact = np.minimum(distance_transform_edt(~contour_of(mask != 0)), 8.0)
    assert np.abs(np.diff(seen.distance_sums, axis=1) / UNIT - exact).max() < 1 / UNIT


def test_where_nothing_is_seen_every_distance_is_the_truncation() -> None:
    assert (distance_to(np.zeros((4, 5), dtype=bool), 3.0) == 3 * UNIT).all()


def test_a_mask_has_one_channel() -> None:
    with pytest.raises(InputError, match="one channel"):
        ObservedMask.of(np.zeros((4, 5, 3)))
    with pytest.raises(InputError, match="truncation"):
        ObservedMask.of(np.ones((4, 5)), truncation=0.0)
