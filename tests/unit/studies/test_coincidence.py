"""The published motion coincidence with its confirming motion: what is counted, and how well."""

from __future__ import annotations

import json

import numpy as np
import pytest

from bodyschema.attention.onsets import OnsetCoincidence
from bodyschema.simulation.moving_scene import MovingScene, Studio
from bodyschema.simulation.random_motions import draw_motions, with_confirmation
from bodyschema.studies import confirmed_maps
from bodyschema.studies.confirmed_maps import Maps, near_onsets, published
from bodyschema.studies.nabeshima_coincidence import Figure3
from bodyschema.studies.runner import run_study
from bodyschema.studies.watched_scenes import shares

START = OnsetCoincidence(("pan", "lift"))
FOUND = START.found(START.start((48, 48)))


def evidence(*cells):
    """(2 joints, 3, 3) with one more for each (joint, row, col)."""
    answer = np.zeros((2, 3, 3))
    for cell in cells:
        answer[cell] += 1
    return answer


def test_only_what_moves_with_the_motion_and_with_its_confirmation_is_found():
    maps, steps = Maps(confirm=True), (
        evidence((0, 1, 1), (0, 0, 0)),
        evidence((0, 2, 2)),  # on the way back: counts neither way
        evidence((0, 1, 1), (0, 2, 2), (1, 0, 0)),
    )  # fmt: skip
    done = [maps.add(total) for total in np.cumsum(steps, axis=0)]
    assert done == [False, False, True]
    body = maps.body(FOUND, 0.0)
    assert np.argwhere(body.mask).tolist() == [[1, 1]]
    assert body.joint[1, 1] == 0


def test_without_confirmation_the_first_of_three_counts_alone():
    maps, steps = Maps(False, made=3), (
        evidence((0, 1, 1)), evidence((0, 2, 2)), evidence((0, 0, 0)), evidence((1, 2, 1)),
    )  # fmt: skip
    done = [maps.add(total) for total in np.cumsum(steps, axis=0)]
    assert done == [True, False, False, True]
    assert np.argwhere(maps.body(FOUND, 0.0).mask).tolist() == [[1, 1], [2, 1]]


def test_a_share_of_the_motions_is_stricter_than_any():
    maps = Maps(confirm=False)
    steps = (evidence((0, 1, 1)), evidence((0, 1, 1), (0, 2, 2)), evidence(), evidence((1, 1, 1)))
    assert all(maps.add(total) for total in np.cumsum(steps, axis=0))
    any_of_them, half = maps.body(FOUND, 0.0), maps.body(FOUND, 0.5)
    assert np.argwhere(any_of_them.mask).tolist() == [[1, 1], [2, 2]]
    assert np.argwhere(half.mask).tolist() == [[1, 1]]
    assert half.probability[1, 1] == pytest.approx(0.75)


def test_a_confirming_motion_goes_back_and_makes_it_again_with_rests_between():
    drawn = draw_motions(np.zeros(3), 4, np.full(3, 0.2), np.random.default_rng(1))
    made = with_confirmation(drawn, np.random.default_rng(2))
    first, back, again = made.turn[0::3], made.turn[1::3], made.turn[2::3]
    np.testing.assert_array_equal(drawn.turn != 0, again != 0)
    np.testing.assert_allclose(again, -back, rtol=0.23)
    assert np.all(np.sign(first) == np.sign(again))
    assert np.all(np.abs(np.cumsum(made.turn, axis=0)) < 0.2 * 1.25)
    begins = np.where(made.turn != 0, made.begin, np.inf).min(axis=1)
    assert np.all(begins[1:] - made.end[:-1] >= 0.5 - 1e-9)
    ends = np.where(made.turn != 0, made.begin + made.length, 0.0).max(axis=1)
    assert np.all(ends <= made.end + 1e-9)


def test_frames_away_from_onsets_change_nothing(offscreen, monkeypatch):
    film = Studio(MovingScene("arm", "always", 4, 2, confirm=True)).film()
    joints = film.joints[: len(film.joints) - len(film.head)]
    assert near_onsets(film, len(joints)).mean() < 0.5
    few = published(film, joints, 0.5, (1, 2))
    monkeypatch.setattr(
        confirmed_maps, "near_onsets", lambda film, joints: np.ones(len(film.time), dtype=bool)
    )
    every = published(film, joints, 0.5, (1, 2))
    assert {k: v["after"] for k, v in few.items()} == {k: v["after"] for k, v in every.items()}
    # In this film: what the confirming motion is good for.
    two = {name: shares([found["after"]["2"]]) for name, found in few.items()}
    assert two["faithful"]["precision"] > two["faithful_outside"]["precision"] + 0.15
    assert two["faithful"]["recall"] > 0.5
    assert two["faithful_share"] == two["faithful"]


def test_the_picture_of_figure_3_shows_the_arm(offscreen):
    study = Figure3(runs=1)
    summary = json.loads(json.dumps(study.summary(run_study(study, 1))))
    last = summary["333"]
    assert last["precision"] > 0.6
    assert 0.3 < last["recall"] < 0.6
    assert summary["0"]["recall"] == 0.0
