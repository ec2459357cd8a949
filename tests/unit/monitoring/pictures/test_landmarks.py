"""Landmarks: found again where they should be; a region that is missed has gone."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("cv2")

from bodyschema import lie
from bodyschema.monitoring.pictures.landmarks import Landmarks
from bodyschema.vision.anchor import templates
from bodyschema.vision.anchored_corners import AnchoredTracker, no_corners
from seen_patch import STEREO, on_plate, sights, world_camera


@pytest.fixture(scope="module")
def remembered():
    """Corners of the first frame, as landmarks."""
    seen = list(sights(5, 12))
    corners = AnchoredTracker(most=20).births(
        no_corners(seen[0].left), seen[0].mask, seen[0].right, bucket=16
    )
    T = lie.inverse(world_camera(5)) @ seen[0].T_world_hand
    n, none = len(corners.name), np.zeros(len(corners.name), dtype=np.int64)
    T_, G, variance = templates(seen[0].left, corners.place)
    marks = Landmarks(
        corners.name, on_plate(corners.place, T), np.tile(T[:3, :3], (n, 1, 1)), T_, G, variance,
        none, none, none, np.full(n, -np.inf),
    )  # fmt: skip
    return seen, marks


def pose(sight):
    return lie.inverse(world_camera(5)) @ sight.T_world_hand


def test_landmarks_are_found_again_where_the_hand_says_they_are(remembered):
    seen, marks = remembered
    looked = marks.sought(seen[4].left, 1.0, pose(seen[4]), STEREO)
    asked = looked.looks > 0
    assert asked.sum() >= 6
    assert looked.hits[asked].mean() > 0.9


def test_from_another_side_they_are_not_looked_for(remembered):
    seen, marks = remembered
    T = pose(seen[0]) @ lie.transform(lie.exp_so3([0.5, 0.0, 0.0]), np.zeros(3))
    assert not marks.sought(seen[0].left, 1.0, T, STEREO).looks.any()


def marks_at(place: np.ndarray, **fields) -> Landmarks:
    n = len(place)
    none = np.zeros(n, dtype=np.int64)
    whole = Landmarks(
        np.arange(n), place, np.tile(np.eye(3), (n, 1, 1)), np.zeros((n, 225)),
        np.zeros((n, 6, 225)), np.full(n, 100.0), none, np.full(n, 10), np.full(n, 10),
        np.full(n, 5.0),
    )  # fmt: skip
    return replace(whole, **fields)


TOOL, HAND = np.tile([0.0, 0.0, 0.2], (6, 1)), np.zeros((8, 3))
BOTH = np.vstack([TOOL, HAND])
ON_TOOL = np.arange(14) < 6


def missed(n: int) -> np.ndarray:
    return np.where(ON_TOOL, n, 0)


def test_a_region_whose_landmarks_are_all_missed_has_gone():
    marks = marks_at(BOTH, misses=missed(2), looks=10 + missed(2))
    assert np.array_equal(marks.gone(5.5), ON_TOOL)


def test_one_look_is_too_few():
    assert not marks_at(BOTH, misses=missed(1), looks=10 + missed(1)).gone(5.5).any()


def test_landmarks_that_were_hardly_ever_found_say_nothing():
    marks = marks_at(BOTH, misses=missed(2), hits=np.where(ON_TOOL, 1, 10), looks=10 + missed(2))
    assert not marks.gone(5.5).any()
    poor = marks_at(BOTH, misses=missed(2), hits=np.where(ON_TOOL, 5, 10), looks=10 + missed(2))
    assert not poor.gone(5.5).any()


def test_when_the_whole_hand_is_missed_nothing_is_said_of_the_tool():
    """It is hidden, or out of the picture, or dark."""
    marks = marks_at(BOTH, misses=np.full(14, 3), looks=np.full(14, 13))
    assert not marks.gone(5.5).any()


def test_old_looks_do_not_count():
    marks = marks_at(BOTH, misses=missed(2), looks=10 + missed(2))
    assert not marks.gone(20.0).any()


def test_a_region_that_is_half_there_has_not_gone():
    """Five of ten are hidden by a cable."""
    both = np.vstack([np.tile([0.0, 0.0, 0.2], (10, 1)), HAND])
    misses = np.where(np.arange(18) < 5, 2, 0)
    assert not marks_at(both, misses=misses, looks=10 + misses).gone(5.5).any()
    misses = np.where(np.arange(18) < 10, 2, 0)
    assert marks_at(both, misses=misses, looks=10 + misses).gone(5.5).sum() == 10


def test_landmarks_that_are_mostly_missed_are_forgotten():
    bad = marks_at(BOTH, hits=np.where(ON_TOOL, 1, 10), looks=np.full(14, 10))
    assert np.array_equal(bad.worth_keeping, ~ON_TOOL)
