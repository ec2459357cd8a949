"""Corners that are followed by what they looked like at birth: exact, and without drift."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("cv2")

import cv2

from bodyschema import lie
from bodyschema.vision.anchor import GRID, HALF, STEPS, WEIGHT, align, templates
from bodyschema.vision.anchored_corners import AnchoredTracker, no_corners
from seen_patch import HEIGHT, STEREO, WIDTH, on_plate, sights, world_camera

FRAMES = 75


def blots(seed: int) -> np.ndarray:
    raw = np.random.default_rng(seed).integers(0, 256, (120, 160)).astype(np.uint8)
    return cv2.normalize(cv2.GaussianBlur(raw, (0, 0), 2), None, 20, 220, cv2.NORM_MINMAX)


def sought(image, T, G, place, affine=None):
    A = np.eye(2)[None].repeat(len(place), 0) if affine is None else affine.copy()
    found, alike, variance = place.copy(), np.empty(len(place)), np.empty(len(place))
    align(image, T, G, WEIGHT, GRID, A, found, STEPS, alike, variance)
    return A, found, alike


def test_a_patch_that_was_turned_stretched_and_dimmed_is_found_where_it_is():
    first = blots(0)
    middle = np.array([[80.0, 60.0]])
    T, G, _ = templates(first, middle)
    A = np.array([[1.06, -0.09], [0.05, 0.95]])
    there = np.array([81.3, 58.9])
    # first(middle + g) is seen at there + A g.
    M = np.column_stack([A, there - A @ middle[0]])
    second = cv2.warpAffine(first, M, first.shape[::-1], flags=cv2.INTER_CUBIC)
    second = np.clip(0.7 * second + 25, 0, 255).astype(np.uint8)
    affine, found, alike = sought(second, T, G, np.array([[80.4, 59.6]]))
    assert np.abs(found[0] - there).max() < 0.05
    assert np.abs(affine[0] - A).max() < 0.02
    assert alike[0] > 0.98


def test_a_patch_of_the_same_picture_is_found_where_it_was_cut_out():
    image = blots(1)
    place = np.array([[40.25, 50.75], [100.5, 70.0]])
    T, G, _ = templates(image, place)
    _, found, alike = sought(image, T, G, place + 0.6)
    assert np.abs(found - place).max() < 0.02
    assert (alike > 0.995).all()


def test_a_slope_of_light_across_a_patch_does_not_slow_the_descent():
    """Where the patch moves its mean and contrast change as well; two steps know that."""
    y, x = np.mgrid[0:60, 0:80].astype(float)
    spot = 60 * np.exp(-((x - 38) ** 2 + (y - 30) ** 2) / 60)
    image = np.clip(120 + spot + 0.8 * (x - 40), 0, 255).astype(np.uint8)
    T, G, _ = templates(image, np.array([[40.0, 30.0]]))
    A, found, alike, variance = np.eye(2)[None], np.array([[40.4, 30.3]]), np.empty(1), np.empty(1)
    align(image, T, G, WEIGHT, GRID, A, found, 2, alike, variance)
    assert np.abs(found[0] - [40.0, 30.0]).max() < 0.01


def test_a_patch_beyond_the_border_and_one_of_nothing_are_not_found():
    image = blots(2)
    T, G, _ = templates(image, np.array([[40.0, 50.0]] * 2))
    _, _, alike = sought(image, T, G, np.array([[HALF - 3.0, 50.0], [np.nan, 4.0]]))
    assert (alike == -2.0).all()


@pytest.fixture(scope="module")
def followed():
    seen = list(sights(3, FRAMES))
    tracker = AnchoredTracker(most=15)
    state = tracker.births(no_corners(seen[0].left), seen[0].mask, seen[0].right)
    states = [state]
    for sight in seen[1:]:
        states.append(tracker.step(states[-1], sight.left, sight.right))
    return seen, states


def test_corners_are_born_in_the_mask_and_seen_in_both_pictures(followed):
    seen, states = followed
    u, v = np.rint(states[0].place).astype(int).T
    assert 5 <= len(u) <= 15
    assert seen[0].mask[v, u].all()
    assert np.isfinite(states[0].stereo).all()


def test_what_is_followed_for_seconds_has_not_drifted(followed):
    seen, states = followed
    T_cam_world = lie.inverse(world_camera(3))
    tips = on_plate(states[0].place, T_cam_world @ seen[0].T_world_hand)
    first = {name: k for k, name in enumerate(states[0].name)}
    T = T_cam_world @ seen[-1].T_world_hand
    true = STEREO.project(tips @ T[:3, :3].T + T[:3, 3])
    last = states[-1]
    off = [
        np.r_[
            last.place[k] - true[first[n], :2],
            last.disparity[k] - (true[first[n], 0] - true[first[n], 2]),
        ]
        for k, n in enumerate(last.name)
        if last.seen[k]
    ]
    assert len(off) >= 4
    assert np.abs(np.array(off)).max() < 0.3


def test_corners_end_when_their_template_is_not_found_any_more(followed):
    _, states = followed
    tracker, state = AnchoredTracker(most=15), states[0]
    empty = np.full((HEIGHT, WIDTH), 128, dtype=np.uint8)
    for _ in range(4):
        state = tracker.step(state, empty, empty)
    assert not len(state.name)


def test_names_are_never_given_twice(followed):
    seen, states = followed
    tracker = AnchoredTracker(most=40)
    more = tracker.births(states[-1], seen[-1].mask, seen[-1].right, bucket=14)
    assert len(set(more.name.tolist())) == len(more.name)
    assert set(more.name) - set(states[-1].name)
    assert min(set(more.name) - set(states[-1].name)) >= states[0].born


def test_no_more_are_born_than_there_is_room_for(followed):
    seen, states = followed
    assert (
        len(
            AnchoredTracker(most=6)
            .births(no_corners(seen[0].left), seen[0].mask, seen[0].right)
            .name
        )
        <= 6
    )
    full = AnchoredTracker(most=len(states[0].name)).births(states[0], seen[0].mask, seen[0].right)
    assert len(full.name) == len(states[0].name)
