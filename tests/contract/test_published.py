"""Stored results of the studies: small runs find them again, a number that moved is told."""

from __future__ import annotations

import copy
import json

import pytest

from bodyschema.studies.registry import STUDIES
from published import check
from published.entries import ENTRIES
from published.spread import half_width, inside, numbers, spread
from published.store import read_stored, stored

QUICK = ("hersch2008_theorem1", "hersch2008_figure11", "nabeshima_figure3", "nabeshima_figure10")
NAME, KEY = QUICK[0], "ranges.90.0.fixed_starts_caught"
STORED = read_stored()


def test_every_study_can_be_stored():
    names = {f"{paper}_{figure}" for paper, figure in STUDIES}
    assert set(ENTRIES) == names
    assert set(STORED) <= names


@pytest.mark.parametrize("name", ENTRIES)
def test_settings_of_an_entry_are_those_of_its_study(name):
    entry = ENTRIES[name]
    for settings in (entry.small, entry.full):
        assert entry.study(settings, seed=3).seed == 3


@pytest.mark.parametrize("name", STORED)
def test_a_stored_result_says_what_was_run_and_holds_what_is_told(name):
    document, entry = STORED[name], ENTRIES[name]
    assert document["command"].startswith(f"bodyschema study {entry.paper} {entry.figure} --runs")
    assert document["cpu_seconds"] > 0
    assert document["version"]
    assert document["date"]
    assert document["seed"] not in document["small"]["seeds"]
    assert document["settings"]["runs"] == document["runs"]
    assert {*entry.told} <= {*document["figures"]}
    assert any("mean" in one for one in document["figures"].values())


def test_small_runs_find_what_is_stored(capsys, offscreen):
    assert check.main(["--only", *QUICK, "--json"]) == 0
    studies = json.loads(capsys.readouterr().out)["studies"]
    assert set(studies) == set(QUICK)
    assert all(row["ok"] and row["numbers"] and not row["outside"] for row in studies.values())


@pytest.mark.parametrize("by", [-1.01, 1.01])
def test_a_number_outside_its_spread_is_not_ok(monkeypatch, capsys, by):
    found = {k: one["mean"] for k, one in STORED[NAME]["figures"].items() if "mean" in one}
    moved = copy.deepcopy(STORED[NAME])
    moved["figures"][KEY]["mean"] += by * half_width(moved["figures"][KEY])
    row = check.judged(moved["figures"], [found])
    assert not row["ok"]
    assert list(row["outside"]) == [KEY]
    monkeypatch.setattr(check, "read_stored", lambda: {NAME: moved})
    monkeypatch.setattr(check, "run_study", lambda study, workers: {})
    monkeypatch.setattr(type(ENTRIES[NAME].study({})), "summary", lambda self, results: found)
    assert check.main(["--only", NAME, "--json"]) == 1
    assert not json.loads(capsys.readouterr().out)["studies"][NAME]["ok"]


def test_a_number_that_never_came_is_not_ok():
    figures = STORED[NAME]["figures"]
    found = {k: one["mean"] for k, one in figures.items() if "mean" in one and k != KEY}
    assert list(check.judged(figures, [found])["outside"]) == [KEY]
    assert not check.judged({"a": {"value": 1.0}}, [{"a": 1.0}])["ok"]


def test_a_study_that_fails_is_told(monkeypatch, capsys):
    def fail(study, workers):
        raise RuntimeError("out of luck")

    monkeypatch.setattr(check, "run_study", fail)
    assert check.main(["--only", QUICK[0], "--json"]) == 1
    row = json.loads(capsys.readouterr().out)["studies"][QUICK[0]]
    assert row == {"ok": False, "failure": "RuntimeError: out of luck"}


def test_unknown_names_and_what_is_not_stored_are_refused(monkeypatch):
    with pytest.raises(SystemExit, match="no study 'figure99'"):
        check.main(["--only", "figure99"])
    monkeypatch.setattr(check, "read_stored", dict)
    with pytest.raises(SystemExit, match=f"check.py --store {QUICK[0]}"):
        check.main(["--only", QUICK[0]])


def test_the_spread_is_that_of_single_runs_and_narrows_with_more():
    around = spread([1.0, 2.0, 3.0, 2.0])
    assert around["mean"] == 2.0
    assert half_width(around, 1) > half_width(around, 4)
    assert inside(2.0 + 0.99 * half_width(around), around)
    assert not inside(2.0 + 1.01 * half_width(around), around)
    assert not inside(None, around)
    assert inside(4.9, {"mean": 2.0, "sd": 0.0, "n": 4, "least": 3.0})
    assert not inside(2.1, {"mean": 2.0, "sd": 0.0, "n": 4})
    assert spread([1.0, None]) is None


def test_numbers_are_named_with_dots_and_text_is_left_out():
    summary = {"a": {"b": 1, "c": None}, "d": "text", "e": [1, 2], "f": True}
    assert dict(numbers(summary)) == {"a.b": 1.0, "a.c": None, "f": 1.0}


def test_storing_goes_on_where_it_stopped(tmp_path):
    entry = ENTRIES["hersch2008_figure4"]
    quick = type(entry)(
        entry.paper, entry.figure, {"runs": 1, "samples": 50}, {"runs": 2, "samples": 50}, copies=2,
        keys=("not_converged",),
    )  # fmt: skip
    first = stored(quick, tmp_path, 1)
    lines = (tmp_path / "hersch2008_figure4" / "full" / "tasks.jsonl").read_bytes()
    again = stored(quick, tmp_path, 1)
    assert first["figures"] == again["figures"] == {
        "not_converged": {"value": 2.0, "mean": 1.0, "sd": 0.0, "n": 2}
    }  # fmt: skip
    assert (tmp_path / "hersch2008_figure4" / "full" / "tasks.jsonl").read_bytes() == lines
    assert first["command"] == "bodyschema study hersch2008 figure4 --runs 2 --samples 50 --seed 0"
