"""Corners on the body: chosen inside the mask, followed without drift, measured in stereo."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("cv2")

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.vision.corners import CornerTracker
from seen_patch import HEIGHT, STEREO, WIDTH, on_plate, sights, world_camera

FRAMES = 60
TRACKER = CornerTracker(count=12)


@pytest.fixture(scope="module")
def followed():
    """Two seconds: what was seen, and the corners."""
    seen = list(sights(0, FRAMES))
    states = [TRACKER.start(seen[0].left, seen[0].mask, seen[0].right)]
    for sight in seen[1:]:
        states.append(TRACKER.step(states[-1], sight.left, sight.right))
    return seen, states


def true_pixels(seen, states) -> np.ndarray:
    """(FRAMES, K, 3) where the points of the first frame are truly seen."""
    T_cam_world = lie.inverse(world_camera(0))
    tips = on_plate(states[0].place, T_cam_world @ seen[0].T_world_hand)
    poses = [T_cam_world @ sight.T_world_hand for sight in seen]
    return np.array([STEREO.project(tips @ T[:3, :3].T + T[:3, 3]) for T in poses])


def test_all_corners_lie_on_the_body(followed):
    seen, states = followed
    u, v = np.rint(states[0].place).astype(int).T
    assert len(u) == TRACKER.count
    assert seen[0].mask[v, u].all()
    assert np.hypot(u - u[:, None], v - v[:, None])[~np.eye(len(u), dtype=bool)].min() > 9


def test_followed_to_a_fraction_of_a_pixel_without_drift(followed):
    seen, states = followed
    away = np.array([s.pixels for s in states]) - true_pixels(seen, states)
    assert np.isfinite(away).mean() > 0.95
    early, late = (np.nanmedian(np.abs(part)) for part in (away[5:15], away[-10:]))
    assert late < 0.15
    assert late < 2 * early + 0.05
    assert np.nanpercentile(np.abs(away), 99) < 0.6


def test_depth_is_that_of_the_stereo_pair(followed):
    seen, states = followed
    c = STEREO.triangulate(states[30].pixels)
    truth = STEREO.triangulate(true_pixels(seen, states)[30])
    assert np.nanmax(np.abs(c - truth)) < 3e-3


def test_one_camera_leaves_the_right_column_empty(followed):
    seen, _ = followed
    state = TRACKER.step(TRACKER.start(seen[0].left, seen[0].mask), seen[1].left)
    assert np.isfinite(state.pixels[:, :2]).all()
    assert np.isnan(state.pixels[:, 2]).all()


def test_a_hidden_corner_is_not_seen_and_comes_back(followed):
    seen, states = followed
    state, at = states[20], states[20].place[0]
    hidden = seen[21].left.copy()
    u, v = np.rint(at).astype(int)
    rng = np.random.default_rng(0)
    window = np.s_[v - 25 : v + 26, u - 25 : u + 26]
    hidden[window] = rng.integers(0, 256, hidden[window].shape)
    blind = TRACKER.step(state, hidden, seen[21].right)
    assert not blind.seen[0]
    assert np.isnan(blind.pixels[0]).all()
    again = TRACKER.step(blind, seen[22].left, seen[22].right)
    assert again.seen[0]
    assert np.linalg.norm(again.place[0] - states[22].place[0]) < 0.3


def test_nothing_is_seen_in_noise(followed):
    seen, _ = followed
    state = TRACKER.start(seen[0].left, seen[0].mask)
    noise = np.random.default_rng(1)
    for _ in range(5):
        state = TRACKER.step(state, noise.integers(0, 256, (HEIGHT, WIDTH)).astype(np.uint8))
        assert not state.seen.any()
    assert TRACKER.step(state, seen[1].left).seen.mean() > 0.5, "seen again afterwards"


def test_unfit_images(followed):
    seen, states = followed
    with pytest.raises(InputError, match="no corner on the body"):
        TRACKER.start(seen[0].left, np.zeros((HEIGHT, WIDTH), dtype=bool))
    with pytest.raises(InputError, match="expected a grey 8-bit image"):
        TRACKER.step(states[0], seen[0].left[:-1])
    with pytest.raises(InputError, match="expected a grey 8-bit image"):
        TRACKER.start(seen[0].left.astype(float), seen[0].mask)
