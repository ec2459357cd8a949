"""Figures 8 and 9 in several readings: which are run, on which streams, and what they hold."""

from __future__ import annotations

import json

import pytest

from bodyschema.errors import InputError
from bodyschema.studies.nabeshima_figure8 import Figure8
from bodyschema.studies.nabeshima_figure9 import Figure9
from bodyschema.studies.runner import run_study, settings_of
from bodyschema.studies.watched_readings import CHOOSING, FRESH, NEAREST, PRINTED


@pytest.fixture(scope="module")
def results():
    return run_study(Figure9(runs=1, seed=CHOOSING), 1)


@pytest.fixture(scope="module")
def done(results):
    study = Figure9(runs=1, seed=CHOOSING)
    return study, json.loads(json.dumps(study.summary(results), allow_nan=False))


def test_the_flags_come_first_and_no_reading_twice():
    readings = Figure9().readings
    assert readings[0] == NEAREST
    assert len(set(readings)) == len(readings) >= 4
    assert Figure9(ssd=0.1, speed=0.5).readings[0] == PRINTED
    assert len(Figure9(ssd=0.1, speed=0.5).readings) == len(readings) - 1


def test_what_was_chosen_on_one_seed_is_reported_on_another():
    assert Figure9().seed == Figure8().seed == FRESH != CHOOSING


def test_the_nearest_reading_notices_both_changes_without_a_false_alarm(done):
    _, summary = done
    assert summary["premises"]["ssd"] == NEAREST.ssd
    assert summary["faithful"]["detected"] == 1.0
    assert summary["faithful"]["false_alarms"] == 0
    assert summary["faithful"]["delay_s"]["median"] == pytest.approx(0.3, abs=0.05)


def test_figure_8_tells_the_same_runs_as_a_course(results):
    study = Figure8(runs=1, seed=CHOOSING)
    assert settings_of(study) == settings_of(Figure9(runs=1, seed=CHOOSING))
    table = study.rows(study.summary(results))
    paper, nearest, ours = table.rows[:3]
    assert paper == ["paper", "59", "76", "102", "114", "124"]
    known, rod, again = (float(cell) for cell in nearest[1:4])
    assert 8 < known < 20
    assert rod == pytest.approx(75.3, abs=0.1)
    assert 80 < again < 95
    assert float(ours[3]) < again - 5


def test_as_printed_in_fast_motion_it_raises_false_alarms_all_the_time(done):
    _, summary = done
    assert summary["faithful_outside"]["spurious_a_run"] > 5
    assert summary["faithful_outside"] == summary["readings"][PRINTED.name]["faithful"]


def test_ours_stands_beside_it_on_each_stream(done):
    study, summary = done
    for reading in study.readings:
        ours = summary["readings"][reading.name]["better"]
        assert ours["detected"] == 1.0
        assert ours["false_alarms"] == 0
    slow, fast = (summary["readings"][name]["better"]["first_known_s"]["median"]
                  for name in ("SSD 0.1, speed 0.125", PRINTED.name))  # fmt: skip
    assert slow > fast


def test_an_ssd_that_nothing_is_below_is_refused():
    study = Figure9(runs=1, ssd=0.0)
    with pytest.raises(InputError, match="got 0"):
        study.work(study.tasks()[0])
