"""`bodyschema study`: text, JSON, files and refusals."""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

import pytest

from bodyschema import cli
from bodyschema.cli.study import RunStudy
from bodyschema.errors import InputError
from bodyschema.studies.registry import PAPERS, STUDIES
from tiny_study import TinyStudy


def test_json_prints_one_object_and_writes_nothing(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert RunStudy(TinyStudy(), workers=1, json=True).run() == 0
    captured = capsys.readouterr()
    assert len(json.loads(captured.out)["means"]) == 4
    assert captured.out.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_text_shows_the_table_and_writes_the_folder(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert RunStudy(TinyStudy(seed=7), workers=1).run() == 0
    shown = capsys.readouterr().out
    folder = Path("studies/nobody1900_figure1_seed-7")
    for words in ("mean", "paper", "Nothing is learned.", str(folder)):
        assert words in shown
    names = {"figure.png", "figure.svg", "study.json", "summary.json", "tasks.jsonl"}
    names |= {".bodyschema.json"}
    assert {path.name for path in folder.iterdir()} == names
    assert len(json.loads((folder / "summary.json").read_text())["means"]) == 4


def test_the_same_study_gives_the_same_bytes(tmp_path):
    for name in ("a", "b"):
        assert RunStudy(TinyStudy(), workers=1, out=tmp_path / name, json=True).run() == 0
    for path in (tmp_path / "a").iterdir():
        assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes(), path.name


def test_without_matplotlib_only_the_picture_is_missing(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert RunStudy(TinyStudy(), workers=1, out=tmp_path / "out").run() == 0
    captured = capsys.readouterr()
    assert "bodyschema[report]" in captured.err
    assert not (tmp_path / "out" / "figure.png").exists()
    assert (tmp_path / "out" / "summary.json").exists()


@pytest.mark.parametrize("wrong", [{"study": TinyStudy(runs=0)}, {"workers": 0}])
def test_nothing_to_do_is_refused(wrong):
    with pytest.raises(InputError, match="1 or more"):
        RunStudy(**{"study": TinyStudy(), **wrong}).run()


def test_settings_that_are_no_numbers_are_refused():
    with pytest.raises(InputError, match="--pause is nan; give a finite number"):
        RunStudy(TinyStudy(pause=float("nan")), workers=1).run()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["hersch2008", "figure3", "--reach-deg", "-5"], "give numbers above zero"),
        (["nabeshima", "figure9", "--ramp-s", "-1"], "takes no time or some; got -1 s"),
        (["nabeshima", "hand-eye", "--points", "0"], "at least one point of the rod; got 0"),
        (["nabeshima", "hand-eye", "--speed", "0"], "speed above zero; got 0"),
        (["vicente2016", "table1", "--particles", "0"], "--particles is 0; give 2 or more"),
        (["vicente2016", "figure12", "--particles", "1"], "--particles is 1; give 2 or more"),
    ],
)
def test_impossible_settings_are_refused(arguments, message, capsys):
    assert cli.run(["study", *arguments, "--runs", "1", "--workers", "1", "--json"]) == 2
    assert re.search(message, " ".join(capsys.readouterr().err.split()))


def test_all_studies_are_listed(capsys):
    assert cli.run(["study"]) == 0
    shown = capsys.readouterr().out
    assert all(word in shown for pair in STUDIES for word in pair)
    assert all(describes in shown for describes in PAPERS.values())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["hersh2008"], "no paper 'hersh2008'.*did you mean 'hersch2008'"),
        (["hersch2008"], "name a figure of hersch2008"),
        (["hersch2008", "figure33"], "no study 'figure33' of hersch2008"),
    ],
)
def test_unknown_studies_are_refused_with_what_there_is(arguments, message, capsys):
    assert cli.run(["study", *arguments]) == 2
    assert re.search(message, capsys.readouterr().err)
