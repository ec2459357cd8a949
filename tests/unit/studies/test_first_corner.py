"""Several corners with a learner each: the first to finish wins, and is watched alone."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.model.kinematics import relative_pose
from bodyschema.simulation.katana import draw_motion, draw_scene, katana, perceive, stereo
from bodyschema.simulation.rod_film import RATE, RodFilm
from bodyschema.studies.first_corner import FirstCorner


@pytest.fixture(scope="module")
def course():
    """20 s of an arm with three corners, the last of which belongs to the wall."""
    rng, eyes = np.random.default_rng(4), stereo(0.3)
    scene = draw_scene(rng, points=2)
    _, q = draw_motion(20.0, rng, scene.T_world_cam)
    T = relative_pose(katana(), q, "base", "hand")
    seen = eyes.triangulate(perceive(scene, T, eyes, rng))
    wall = np.broadcast_to([0.2, 0.1, 1.2], (len(T), 1, 3)) + 0.003 * rng.normal(
        size=(len(T), 1, 3)
    )
    return T, np.concatenate([seen, wall], axis=1)


def run(T, seen, state=None):
    """What happened first, by sample, and the state then; nothing and the last state otherwise."""
    learner = FirstCorner(seen.shape[1], 0.001)
    state = state or learner.start()
    for i in range(len(T)):
        state, event = learner.step(state, T[i], seen[i])
        if event:
            return (i, event), state
    return None, state


def test_the_first_corner_that_finishes_stops_all_and_a_wall_never_does(course):
    (at, event), state = run(*course)
    assert event == "identified"
    alone = [run(course[0], course[1][:, k : k + 1])[0][0] for k in (0, 1)]
    assert at == min(alone)
    assert state.winner == int(np.argmin(alone))
    assert run(course[0], course[1][:, 2:])[0] is None


def test_the_winner_alone_is_watched_and_when_it_moves_all_begin_anew(course):
    T, seen = course
    _, state = run(T, seen)
    other = 1 - state.winner
    moved = seen[:30].copy()
    moved[:, other] += 0.3
    assert run(T[:30], moved, state)[0] is None
    moved = seen[:30].copy()
    moved[:, state.winner] += 0.3
    happened, after = run(T[:30], moved, state)
    assert happened == (9, "alarm")
    assert after.winner is None
    assert all(relation.moments.count == 0 for relation in after.relations)


def test_a_corner_that_is_not_seen_says_nothing(course):
    T, seen = course
    hidden = seen.copy()
    hidden[:, 0] = np.nan
    _, state = run(T, hidden)
    assert state.winner == 1
    assert state.relations[0].moments.count == 0


def test_the_robot_of_the_film_stops_and_its_rod_slips_meanwhile(offscreen):
    film = RodFilm([0, 0, 0], 3.0, (1.0, 0.042), (9.0, 0.1))
    stops, q, shown = [], [], []
    for moment in film.watched(stops):
        if round(moment.time * RATE) == 4:
            stops.append(1.0)
        q.append(moment.q)
        shown.append(film.hand())
    still = np.flatnonzero((np.diff(q, axis=0) == 0).all(axis=1))
    assert still.tolist() == list(range(4, 14))
    # In that second the rod began to move, in pictures of an arm that rests.
    assert (shown[14] != shown[10]).sum() > 50
    assert (shown[8] != shown[5]).sum() == 0
