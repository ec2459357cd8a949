"""Positions cut into motions, and positions some time ago."""

from __future__ import annotations

import numpy as np

from bodyschema.attention.motor import MotionCutter, Motor


def course(*pieces: tuple[float, float]) -> np.ndarray:
    """(n, 2) rad at 30 frames a second: turns (rad/s, s) of the first joint, the second rests."""
    speed = np.concatenate([np.full(round(30 * s), w) for w, s in pieces])
    return np.stack([np.cumsum(speed) / 30, np.zeros(len(speed))], axis=1)


def run(q: np.ndarray, noise: float = 0.0) -> list[Motor]:
    cutter, rng = MotionCutter(), np.random.default_rng(0)
    state, states = cutter.start(q.shape[1]), []
    for i, here in enumerate(q):
        state = cutter.step(state, i / 30, here + noise * rng.normal(size=here.shape))
        states.append(state)
    return states


def test_each_turn_is_one_motion_that_ends_in_the_rest():
    states = run(course((0, 0.5), (0.3, 0.6), (0, 0.8), (-0.3, 0.6), (0, 0.8)), noise=2e-4)
    ends = [i / 30 for i, state in enumerate(states) if state.ended]
    assert len(ends) == 2
    assert 1.4 < ends[0] < 1.75
    assert 2.8 < ends[1] < 3.15
    assert np.isnan(states[-1].began)


def test_a_robot_that_never_rests_is_cut_into_pieces():
    states = run(course((0.3, 5.0)))
    ends = [i / 30 for i, state in enumerate(states) if state.ended]
    assert len(ends) == 3
    assert max(np.diff(ends)) < 1.6


def test_noise_is_no_motion_and_only_the_joint_that_turns_moves():
    assert not any(state.moved.any() for state in run(np.zeros((60, 2)), noise=5e-4))
    assert run(course((0, 0.3), (0.3, 0.3)))[-1].moved.tolist() == [True, False]


def test_positions_some_time_ago_lie_on_straight_lines():
    state = run(course((0.3, 1.0)))[-1]
    now = 29 / 30
    wanted = np.array([now, now - 0.05, now - 0.1, -5.0])
    expected = np.interp(wanted, np.arange(30) / 30, course((0.3, 1.0))[:, 0])
    np.testing.assert_allclose(state.at(wanted)[:, 0], expected, atol=1e-12)
