"""The map of the hand: votes for and against, and what has gone."""

from __future__ import annotations

import numpy as np

from bodyschema.monitoring.pictures.hand_map import HandMap


def test_corners_on_the_hand_are_remembered_and_wrong_ones_are_not():
    here, there = np.array([[0.01, 0.02, 0.03]]), np.array([[0.5, 0.0, 0.0]])
    hand = HandMap().voted(here, 1).voted(there, 1).voted(there, -5)
    assert np.allclose(hand.points, here)
    assert np.allclose(hand.voted(there, 1).points, here)


def test_neighbours_share_a_cube_and_the_map_stays_small():
    rng = np.random.default_rng(0)
    hand = HandMap()
    for _ in range(50):
        hand = hand.voted(0.01 * rng.uniform(size=(40, 3)), 1)
    assert 1 <= len(hand.points) <= 8


def test_what_has_gone_is_forgotten():
    here, there = np.array([[0.0, 0.0, 0.0]]), np.array([[0.1, 0.0, 0.0]])
    hand = HandMap().voted(np.vstack([here, there]), 1).without(there + 0.01, 0.02)
    assert np.allclose(hand.points, here)


def test_places_beyond_all_measure_are_left_out():
    assert not len(HandMap().voted(np.array([[1e9, 0.0, 0.0]]), 1).points)
    assert not len(HandMap().voted(np.zeros((0, 3)), 1).points)
