"""The wall says whether the camera has moved; single things that move do not."""

from __future__ import annotations

import numpy as np

from bodyschema.monitoring.pictures.background import Background

NAMES = np.arange(12, dtype=np.int64)


def run(places):
    """States and whether a turn has just ended, frame by frame; places (n, K, 2)."""
    state, ended, moving = Background(), [], []
    for place in places:
        state, now = state.step(NAMES[: len(place)], place)
        ended.append(now)
        moving.append(state.moving)
    return np.array(moving), np.array(ended)


def still(n, rng, noise=0.1, K=12):
    anchor = rng.uniform(0, 600, (K, 2))
    return anchor + noise * rng.normal(size=(n, K, 2)), anchor


def test_a_still_camera_never_moves_though_it_shakes():
    rng = np.random.default_rng(0)
    places, _ = still(2000, rng, 0.08)
    shake = 0.2 * rng.normal(size=(2000, 1, 2))
    moving, ended = run(places + shake)
    assert not moving.any()
    assert not ended.any()


def test_a_turn_is_noticed_within_a_few_frames_and_ends_once():
    places, _ = still(120, np.random.default_rng(1))
    way = 40 * np.clip((np.arange(120) - 60) / 15, 0, 1)
    moving, ended = run(places + way[:, None, None] * [1.0, 0.3])
    assert not moving[:60].any()
    assert moving[60:64].any()
    assert ended.sum() == 1
    assert 75 <= int(np.flatnonzero(ended)[0]) <= 84
    assert not moving[90:].any()


def test_a_slow_turn_is_noticed_too():
    places, _ = still(300, np.random.default_rng(2))
    way = 0.05 * np.maximum(np.arange(300) - 60, 0)
    moving, _ = run(places + way[:, None, None] * [1.0, 0.0])
    assert moving[:110].any()


def test_a_third_of_the_corners_on_things_that_move_say_nothing():
    rng = np.random.default_rng(3)
    places, _ = still(300, rng)
    places[:, :4] += np.cumsum(rng.normal(size=(300, 4, 2)), axis=0)
    moving, _ = run(places)
    assert not moving.any()


def test_half_of_the_corners_on_one_thing_that_moves_say_nothing():
    """A person who walks by, before a wall with as many corners."""
    places, _ = still(200, np.random.default_rng(6))
    places[:, :6] += 0.5 * np.maximum(np.arange(200) - 50, 0)[:, None, None]
    moving, _ = run(places)
    assert not moving.any()


def test_few_corners_say_nothing():
    places, _ = still(60, np.random.default_rng(4), K=4)
    moving, _ = run(places + np.arange(60)[:, None, None])
    assert not moving.any()


def test_new_corners_get_anchors_of_their_own():
    rng = np.random.default_rng(5)
    state = Background()
    for k in range(100):
        names = np.arange(k // 5, k // 5 + 8, dtype=np.int64)
        place = np.column_stack([names * 30.0, names * 10.0]) + 0.1 * rng.normal(size=(8, 2))
        state, _ = state.step(names, place)
        assert not state.moving
