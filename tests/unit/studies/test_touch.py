"""The answer of the touch study: the keys that machines read, and numbers that add up."""

from __future__ import annotations

import json

import pytest

from bodyschema.errors import InputError
from bodyschema.studies.nabeshima_touch import CONDITIONS, FORCES, SURFACES, TouchStudy


def invented(task):
    """A result of a task, with numbers that are easy to add."""
    settings = task.settings
    if settings["kind"] == "free":
        return {"hours": settings["hours"], "seconds_a_sample": 1e-5} | dict.fromkeys(CONDITIONS, 1)
    if settings["kind"] != "point":
        return {"verdicts": ["twist", "point", "moving", "twist"], "unnoticed": 1}
    part = {
        "error": [1e-3, 2e-3, 6e-3],
        "held": [True, True, False],
        "point": [True, True, True],
        "unnoticed": 1,
        "false": 0,
        "seconds_a_sample": 2e-5,
    }
    told = part | {"faithful": {"one": [0.1] * 4, "mean": [0.05] * 4}}
    speeds = {f"{speed:g}": told for speed in TouchStudy().speeds}
    within = {f"{speed:g}": told | {"error": [1e-4 * (1 + speed)] * 3}
              for speed in TouchStudy().speeds}  # fmt: skip
    compared = {"": within, "_outside": speeds}
    return dict.fromkeys(CONDITIONS, part) | {"compared": compared}


def test_every_surface_and_force_has_its_figures():
    study = TouchStudy(runs=4, hours=0.5)
    results = {task.key: invented(task) for task in study.tasks()}
    summary = json.loads(json.dumps(study.summary(results), allow_nan=False))
    for surface in SURFACES:
        for force in FORCES:
            cell = summary["better_outside"][surface][f"{force:g}"]
            assert cell["median_mm"] == pytest.approx(2.0)
            assert cell["p95_mm"] == pytest.approx(5.6)
            # Two pieces of a quarter of an hour, one false touch in each.
            assert cell["false_per_hour"] == pytest.approx(4.0)
            assert cell["coverage"] == pytest.approx(2 / 3)
            assert cell["unnoticed"] == pytest.approx(1 / 4)
            assert cell["refused"]["soft"] == pytest.approx(3 / 4)
            theirs = summary["faithful_outside"][surface][f"{force:g}"]
            assert theirs["median_mm"] == pytest.approx(100.0)
            assert theirs["readings"]["mean"]["median_mm"] == pytest.approx(50.0)
            slow = summary["better"][surface][f"{force:g}"]
            assert slow["median_mm"] == pytest.approx(0.115)
            assert slow["speeds"]["1"]["median_mm"] == pytest.approx(0.2)
    assert summary["premises"] == {
        "force_offset_n": 0.0, "torque_offset_nm": 0.0, "turn_deg": 0.0, "speed": 0.15,
    }  # fmt: skip
    assert summary["premises_outside"]["force_offset_n"] == 0.5
    assert summary["microseconds_a_sample_free"] == pytest.approx(10.0)
    assert len(study.rows(summary).rows) == 2 * len(SURFACES) * len(FORCES)


def test_hours_and_touches_are_cut_into_tasks():
    study = TouchStudy(runs=45, hours=0.6)
    tasks = [task.settings for task in study.tasks()]
    touches = [s["count"] for s in tasks if s["kind"] == "point" and s["surface"] == "rod"]
    assert sum(touches) == 45 * len(FORCES)
    hours = [s["hours"] for s in tasks if s["kind"] == "free" and s["surface"] == "rod"]
    assert sum(hours) == pytest.approx(0.6)


@pytest.mark.parametrize(
    ("settings", "named"),
    [
        ({"hours": 0.0}, "--hours"),
        ({"speed": 0.0}, "--speed"),
        ({"outside_speed": 3.0}, "--outside-speed"),
        ({"force_offset": -0.1}, "--force-offset"),
        ({"outside_turn_deg": -1.0}, "--outside-turn-deg"),
    ],
)
def test_settings_that_make_no_sense_are_refused(settings, named):
    with pytest.raises(InputError, match=f"^{named}"):
        TouchStudy(**settings).tasks()
