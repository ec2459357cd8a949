"""When it is enough, and which motion would tell most."""

from __future__ import annotations

import numpy as np

from bodyschema.attention.confirming import Moved, next_motion, verdict, with_motion

NAMES = ("shoulder", "elbow", "wrist")
OWN = np.arange(3)
SEEN = np.ones(6)


def moved(*turns: tuple[float, float, float]) -> Moved:
    state = Moved(np.zeros(3, dtype=np.int64), np.zeros(3), np.zeros(3))
    for turn in turns:
        state = with_motion(state, np.array(turn), 0.004)
    return state


def test_turns_are_counted_joint_by_joint():
    state = moved((0.1, 0.0, 0.3), (0.2, 0.001, 0.0))
    assert state.motions.tolist() == [2, 0, 1]
    np.testing.assert_allclose(state.usual(), [np.sqrt(0.025), 0.1, 0.3])
    assert state.last.tolist() == [0.2, 0.001, 0.0]


def test_a_joint_that_has_not_moved_comes_first():
    state = moved((0.1, 0.1, 0.0), (0.1, -0.1, 0.0))
    V = np.diag([1e-4, 1e-4, 1e4])
    asked = next_motion(np.full(6, 0.4), SEEN, np.zeros((6, 2, 3)), V, state, NAMES, OWN)
    assert (asked.kind, asked.joint) == ("joint", "wrist")


def test_the_last_motion_is_repeated_if_it_moves_what_is_in_doubt():
    state = moved((0.1, 0.1, 0.1), (0.1, 0.0, 0.1))
    K = np.zeros((6, 2, 3))
    K[:, 0, [0, 2]] = 50.0
    asked = next_motion(np.full(6, 0.5), SEEN, K, 1e-6 * np.eye(3), state, NAMES, OWN)
    assert asked.kind == "repeat"


def test_the_joint_that_moves_the_doubtful_cells_is_asked_for():
    state = moved((0.1, 0.1, 0.1), (0.1, 0.1, 0.0))
    K, P = np.zeros((6, 2, 3)), np.array([0.99, 0.99, 0.99, 0.5, 0.5, 0.01])
    K[:3, 0, 0], K[3:5, 0, 1] = 80.0, 60.0
    K[3:5, 0, 0] = -60.0  # the last motion moved them by both joints, to no effect
    asked = next_motion(P, SEEN, K, 1e-6 * np.eye(3), state, NAMES, np.array([1, 2]))
    assert (asked.kind, asked.joint) == ("joint", "elbow")


def test_what_is_missing_is_said_in_turn():
    P, mask = np.array([0.99] * 4 + [0.01] * 2), np.array([True] * 4 + [False] * 2)
    ready = moved(*[(0.1, 0.1, 0.1)] * 2)

    def says(P=P, mask=mask, moved=ready, sd=0.001) -> tuple[bool, str]:
        return verdict(P, mask, SEEN, moved, sd, NAMES, OWN)

    assert says()[0]
    assert "no joint has moved" in says(moved=moved())[1]
    assert "nothing in view" in says(mask=np.zeros(6, dtype=bool))[1]
    assert "wrist" in says(moved=moved((0.1, 0.1, 0.1), (0.1, 0.1, 0.0)))[1]
    assert "in doubt" in says(P=np.array([0.99] * 4 + [0.5] * 2))[1]
    assert "delay" in says(sd=0.05)[1]
    assert not says(sd=np.nan)[0]
