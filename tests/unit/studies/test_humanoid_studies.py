"""The studies of the humanoid: their tasks, their answers, their pictures."""

from __future__ import annotations

import json

import numpy as np
import pytest

from bodyschema.estimation.invisible import invisible_motions
from bodyschema.learners.skeletons.shortest_links import with_shortest_links
from bodyschema.model.variables import free_skeleton
from bodyschema.simulation.humanoid import ENDS, EYE
from bodyschema.studies import hersch2008_figure11 as figure11
from bodyschema.studies.hersch2008_figure10 import Figure10
from bodyschema.studies.hersch2008_figure11 import Figure11
from bodyschema.studies.picture import picture_files
from bodyschema.studies.registry import study_class
from bodyschema.studies.runner import run_study
from bodyschema.studies.schema_comparison import compare
from bodyschema.studies.study import Result

KEYS = {"failed", "samples_median", "samples_p95", "identifiable", "parameters"}


def test_both_are_registered() -> None:
    assert study_class("hersch2008", "figure10") is Figure10
    assert study_class("hersch2008", "figure11") is Figure11


def test_figure10_counts_what_did_not_converge() -> None:
    study = Figure10(learner="online-gradient", runs=1, limit=2000)
    results = run_study(study, 1)
    answer = study.summary(results)
    assert json.loads(json.dumps(answer, allow_nan=False)) == answer
    assert set(answer) >= KEYS
    assert set(answer["alternating"]) >= KEYS
    assert (answer["failed"], answer["samples_median"]) == (1, None)
    assert (answer["identifiable"], answer["parameters"]) == (108, 135)
    assert answer["alternating"]["identifiable"] == 115
    table = study.rows(answer)
    assert all(len(row) == len(table.headers) for row in table.rows)
    assert picture_files("figure10", lambda: study.draw(answer, results))["figure.png"]


def test_figure10_sums_up_its_runs() -> None:
    study = Figure10(runs=20)
    keys = [task.key for task in study.tasks()]
    assert len(keys) == len(set(keys)) == 4
    counts = {"ends": [10, 12, -1, 14], "alternating": [20, 20, 20, 20]}
    results = {
        key: {
            "samples": counts[key.partition("_")[0]],
            "curves": [[0.1, 0.01], [0.1], [0.2, 0.1, 1e-9], [0.1]],
        }
        for key in keys
    }
    answer = study.summary(results)
    assert answer["failed"] == 2
    assert answer["samples_median"] == 12
    assert answer["samples_max"] == 14
    assert answer["alternating"]["failed"] == 0
    assert answer["alternating"]["samples_p95"] == 20
    assert study.rows(answer).rows[0][1] == "2 of 20"
    assert picture_files("figure10", lambda: study.draw(answer, results))["figure.svg"]


@pytest.fixture(scope="module")
def results() -> dict[str, Result]:
    """As if bodies had been learned exactly, but for what cannot be told."""
    study, rng = Figure11(runs=1), np.random.default_rng(0)
    found = {}
    for task in study.tasks():
        watching = study.watching(task.settings["case"])
        variables = free_skeleton(watching.body)
        hidden = [
            motion.row
            for motion in invisible_motions(watching.body, variables)
            if motion.frame not in (EYE, *watching.markers)
        ]
        slid = rng.normal(0, 0.05, len(hidden)) @ np.array(hidden)
        learned = watching.body.with_variables(variables, slid)
        plain = with_shortest_links(learned, variables, watching.looks())
        q = watching.postures(10, rng)
        found[task.key] = {"failed": False} | {
            name: {"skeleton": figure11._stored(body), **vars(compare(watching, body, q))}
            for name, body in (("learned", learned), ("shortest", plain))
        }
    return found


def test_figure11_tells_the_two_schemas_apart(results: dict[str, Result]) -> None:
    study = Figure11(runs=1)
    answer = study.summary(results)
    assert json.loads(json.dumps(answer, allow_nan=False)) == answer
    for case, rank in (("ends", 108), ("alternating", 115)):
        of = answer[case]
        assert (of["identifiable"], of["parameters"]) == (rank, 135)
        assert len(of["open"]) == 135 - rank
        assert of["failed"] == 0
        assert max(of["learned"][key] for key in ("prediction", "axes", "lines")) < 1e-9
        assert of["learned"]["centres"] > 0.05
        assert of["shortest"]["centres_mean"] < 0.5 * of["learned"]["centres_mean"]
    assert "r_knee slides along its axis" in answer["ends"]["open"]
    assert "r_knee slides along its axis" not in answer["alternating"]["open"]
    table = study.rows(answer)
    assert all(len(row) == len(table.headers) for row in table.rows)


def test_figure11_is_drawn_from_stored_skeletons(results: dict[str, Result]) -> None:
    study = Figure11(runs=1)
    stored = json.loads(json.dumps(results))
    answer = study.summary(stored)
    files = picture_files("figure11", lambda: study.draw(answer, stored))
    assert files["figure.png"].startswith(b"\x89PNG")
    again = picture_files("figure11", lambda: study.draw(answer, stored))
    assert files["figure.svg"] == again["figure.svg"]


def test_a_stored_skeleton_sees_what_the_body_saw(results: dict[str, Result]) -> None:
    watching = Figure11().watching("ends")
    stored = json.loads(json.dumps(results["ends_0"]["learned"]["skeleton"]))
    body = figure11._restored(stored, watching.body)
    q = watching.postures(5, np.random.default_rng(1))
    assert watching.errors(body, q, ENDS).max() < 1e-12
