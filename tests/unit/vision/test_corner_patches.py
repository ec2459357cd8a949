"""Patches sought in another image."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.vision.corner_patches import Patches

cv2 = pytest.importorskip("cv2")

PATCHES = Patches(window=11, back=0.5)
PLACE = np.array([[u, v] for u in range(15, 186, 10) for v in range(15, 136, 10)], dtype=float)


def blots(seed: int) -> np.ndarray:
    raw = np.random.default_rng(seed).integers(0, 256, (150, 200)).astype(np.uint8)
    return cv2.normalize(cv2.GaussianBlur(raw, (0, 0), 1.2), None, 0, 255, cv2.NORM_MINMAX)


def test_a_shift_is_found_to_a_fraction_of_a_pixel():
    image, A = blots(0), np.array([[1, 0, 2.3], [0, 1, -1.6]])
    moved = cv2.warpAffine(image, A, image.shape[::-1])
    found, sure = PATCHES.follow(image, moved, PLACE, PLACE)
    assert sure.mean() > 0.9
    away = np.abs(found[sure] - PLACE[sure] - A[:, 2])
    assert np.median(away) < 0.03
    assert np.quantile(away, 0.99) < 0.1


def test_what_is_not_there_is_not_found():
    _, sure = PATCHES.follow(blots(0), blots(1), PLACE, PLACE)
    assert sure.mean() < 0.01


def test_nan_begins_nowhere():
    image, place = blots(0), PLACE[:3].copy()
    place[1] = np.nan
    found, sure = PATCHES.follow(image, image, place, place)
    np.testing.assert_array_equal(sure, [True, False, True])
    np.testing.assert_allclose(found[[0, 2]], place[[0, 2]], atol=1e-3)


def test_along_a_row():
    image = blots(0)
    right = np.roll(image, -23, axis=1)
    assert PATCHES.along_row(image, right, np.array([120.0, 70.0])) == 23
    assert np.isnan(PATCHES.along_row(image, blots(1), np.array([120.0, 70.0])))
    assert np.isnan(PATCHES.along_row(image, right, np.array([2.0, 70.0])))
