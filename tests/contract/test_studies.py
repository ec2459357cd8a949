"""Every study keeps the rules of its kind, on one run."""

from __future__ import annotations

import json
from dataclasses import is_dataclass, replace

import pytest

from bodyschema.studies.picture import picture_files
from bodyschema.studies.registry import PAPERS, STUDIES, study_class
from bodyschema.studies.runner import run_study, settings_of

QUICK = {("hersch2008", "figure13"): {"steps": 400}, ("nabeshima", "touch"): {"hours": 0.02}}
for _name in ("table1", "figure6", "figure7", "figure8", "figure10"):
    QUICK["vicente2016", _name] = {"frames": 3, "closed_frames": 2}
for _name in ("figure12", "figure13"):
    QUICK["vicente2016", _name] = {"particles": 20, "frames": 2, "closed_frames": 1}
for _name in ("table2", "figure9"):
    QUICK["vicente2016", _name] = {"frames": 3, "closed_frames": 1}
QUICK["vicente2016", "generalisation"] = {"frames": 3}
QUICK["nabeshima", "corners"] = {"waggle": 1.0, "seconds": 1.0}
QUICK["nabeshima", "rendered"] = {"seconds": 1.0}
QUICK["nabeshima", "life"] = {"seconds": 5.0}
QUICK["nabeshima", "find-body"] = {"motions": 1}
QUICK["nabeshima", "figure5"] = {"motions": 1}
"""Settings of studies whose one run takes long."""


@pytest.fixture(scope="module", params=STUDIES, ids=" ".join)
def done(request):
    """A study of one run, its results and its summary."""
    drawn = {("nabeshima", name) for name in ("find-body", "life", "figure3", "figure4", "figure5")}
    if request.param[0] == "vicente2016" or request.param in drawn:
        request.getfixturevalue("offscreen")
    study = study_class(*request.param)(runs=1, **QUICK.get(request.param, {}))
    results = run_study(study, 1)
    return request.param, study, results, study.summary(results)


def untimed(value):
    """A result without its clocks, which no seed decides."""
    if isinstance(value, dict):
        return {k: untimed(v) for k, v in value.items() if "second" not in k and k != "fps"}
    return value


def test_it_is_frozen_settings_under_its_own_name(done):
    (paper, figure), study, _, _ = done
    assert (study.paper, study.figure) == (paper, figure)
    assert paper in PAPERS
    assert is_dataclass(study)
    assert type(study).__dataclass_params__.frozen
    assert replace(study, seed=study.seed) == study
    assert settings_of(study)["runs"] == 1


def test_tasks_are_named_once_and_are_json(done):
    _, study, results, _ = done
    tasks = study.tasks()
    assert len({task.key for task in tasks}) == len(tasks) == len(results)
    assert all(json.loads(json.dumps(task.settings)) == dict(task.settings) for task in tasks)


def test_a_task_depends_on_itself_and_the_seed_alone(done):
    _, study, results, _ = done
    task = study.tasks()[-1]
    again = json.loads(json.dumps(study.work(task), allow_nan=False))
    assert untimed(again) == untimed(results[task.key])


def test_the_answer_can_be_read_shown_and_drawn(done):
    (paper, figure), study, results, summary = done
    summary = json.loads(json.dumps(summary, allow_nan=False))
    table = study.rows(summary)
    assert table.rows
    assert all(len(row) == len(table.headers) for row in table.rows)
    assert all(isinstance(cell, str) for row in table.rows for cell in row)
    assert all(isinstance(note, str) for note in table.notes)
    files = picture_files(f"{paper}_{figure}", lambda: study.draw(summary, results))
    assert set(files) == {"figure.png", "figure.svg"}
