"""Touching begins by itself: each method says when it is sure of the load, and is right then."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("mujoco")

from bodyschema.studies.nabeshima_figure10 import Figure10
from bodyschema.studies.nabeshima_figure11 import Figure11
from bodyschema.studies.runner import run_study
from bodyschema.studies.sure_load import MEASURED, published_load, sure_load
from bodyschema.studies.touch_runs import Wrist, draw_wrist
from bodyschema.studies.wrist_premises import WristPremises

WITHIN, OUTSIDE = WristPremises().within, WristPremises().outside


def waved(case, seconds=15.0):
    rng = np.random.default_rng(5)
    wrist: Wrist = draw_wrist("box", "identified", case.speed, rng, case)
    return wrist, wrist.move(seconds, rng)


def test_within_the_premises_both_are_sure_in_time_and_right():
    wrist, samples = waved(WITHIN)
    theirs, ours = published_load(samples), sure_load(samples, wrist)
    truth = wrist.held.load
    assert 1.0 < theirs.satisfied < 12.0
    assert theirs.mass == pytest.approx(truth.mass, rel=0.01)
    assert theirs.com == pytest.approx(truth.com, abs=2e-3)
    assert MEASURED <= ours.certified < 12.0
    phi = ours.search.load.phi
    assert phi[0] == pytest.approx(truth.mass, rel=0.01)
    assert phi[1:4] / phi[0] == pytest.approx(truth.com, abs=1e-3)


def test_outside_the_published_rule_ends_as_early_with_a_wrong_load():
    wrist, samples = waved(OUTSIDE)
    theirs, ours = published_load(samples), sure_load(samples, wrist)
    truth = wrist.held.load
    assert theirs.satisfied < 8.0
    assert np.linalg.norm(theirs.com - truth.com) > 2e-3
    assert ours.certified == pytest.approx(MEASURED, abs=0.5)
    assert ours.search.load.phi[0] == pytest.approx(truth.mass, rel=0.01)


def test_a_motion_that_is_too_short_to_be_sure_is_used_as_it_is():
    wrist, samples = waved(WITHIN, MEASURED - 0.1)
    assert sure_load(samples, wrist).certified is None


def test_figure10_tells_both_cases_and_the_readings_of_the_limit():
    study = Figure10(runs=1)
    answer = study.summary(run_study(study, 1))
    assert answer["premises"] == WITHIN.stated()
    assert answer["faithful"]["at"]["10"]["com_mm"] < 1.5
    assert answer["faithful_outside"]["at"]["20"]["com_mm"] > 1.0
    assert answer["better_outside"]["at"]["20"]["com_mm"] < 0.1
    stops = [found["satisfied_s"] for found in answer["faithful"]["readings"].values()]
    assert 0 < stops[0] < stops[1] < stops[2] < 20


def test_figure11_begins_by_itself_and_touches_the_table():
    study = Figure11(runs=1, touches=6)
    answer = study.summary(run_study(study, 1))
    assert answer["faithful"]["begins_s"] < 20
    assert answer["better"]["begins_s"] < 20
    assert answer["faithful"]["error_mm"]["median"] < 8
    for key in ("better", "better_outside"):
        assert answer[key]["noticed"] == 1
        assert answer[key]["off_table_mm"]["median"] < 2
