"""The key figures: a registry that is whole, and a rule for what counts as worse."""

from __future__ import annotations

import importlib
import json

import pytest

import figures
from key_figures.figure import Figure, Outcome, Part, measure
from key_figures.registry import PARTS

KEYS = [key for part in PARTS for key in part.keys]
ALONE = Part("alone", "nowhere:nothing", (Figure("size", "mm", "lower", 0.1, "a test"),))


def test_names_are_unique():
    assert len(set(KEYS)) == len(KEYS)
    assert len({part.name for part in PARTS}) == len(PARTS)


@pytest.mark.parametrize("part", PARTS, ids=lambda part: part.name)
def test_a_part_can_be_measured_and_its_figures_say_what_they_are(part):
    module, name = part.function.split(":")
    assert callable(getattr(importlib.import_module(f"key_figures.{module}"), name))
    for figure in part.figures:
        assert figure.unit
        assert figure.reason
        assert figure.tolerance >= 0


def test_every_figure_is_frozen_and_nothing_else():
    assert sorted(figures.read_frozen()) == sorted(KEYS)


@pytest.mark.parametrize(
    ("better", "value", "ok"),
    [
        ("lower", 10.5, True), ("lower", 11.5, False), ("lower", 1.0, True),
        ("higher", 9.5, True), ("higher", 8.5, False), ("higher", 99.0, True),
        ("equal", 10.5, True), ("equal", 11.5, False), ("equal", 8.5, False),
    ],
)  # fmt: skip
def test_worse_than_the_tolerance_is_not_ok(better, value, ok):
    assert Figure("a", "mm", better, 1.0, "").ok(value, 10.0) is ok
    assert Figure("a", "mm", better, 0.1, "", relative=True).ok(value, 10.0) is ok


@pytest.mark.parametrize("value", [None, float("nan"), float("inf")])
def test_what_never_came_is_not_ok(value):
    assert not Figure("a", "mm", "lower", 1.0, "").ok(value, 10.0)
    assert not Figure("a", "mm", "lower", 1.0, "").ok(10.0, None)


def test_a_failure_costs_its_own_part_only(tmp_path):
    failed = measure(ALONE, tmp_path)
    assert "ModuleNotFoundError" in failed.failure
    assert failed.values == {}


def test_a_missing_data_set_is_skipped_with_a_word_by_a_worker(tmp_path, capfd):
    part = Part("alone", "nowhere:nothing", ALONE.figures, needs=("arm",))
    [outcome] = figures.measured([part], tmp_path)
    assert "needs the data set arm" in outcome.skipped
    assert "1/1 alone" in capfd.readouterr().err


@pytest.fixture
def told(monkeypatch, tmp_path, capsys):
    """Runs the command on what parts came to, and returns exit code and standard output."""
    monkeypatch.setattr(figures, "FROZEN", tmp_path / "figures.json")
    other = Part("other", "nowhere:nothing", ALONE.figures)
    monkeypatch.setattr(figures, "PARTS", (ALONE, other))

    def run(outcomes, *flags):
        monkeypatch.setattr(figures, "measured", lambda parts, data: iter(outcomes))
        code = figures.main(list(flags))
        return code, capsys.readouterr().out

    return run


def test_the_command_freezes_and_compares(told):
    one = Outcome("alone", 1.0, {"alone.size": 2.0})
    gone = Outcome("other", 1.0, skipped="needs a thing")
    assert told([one, gone], "--freeze")[0] == 0
    code, out = told([one, gone], "--json")
    expected = {"alone.size": {"value": 2.0, "frozen": 2.0, "unit": "mm", "ok": True}}
    assert (code, json.loads(out)) == (0, {"figures": expected})
    code, out = told([Outcome("alone", 1.0, {"alone.size": 2.2}), gone])
    assert code == 1
    assert "other was skipped: needs a thing" in out


def test_a_failed_part_is_null_and_not_ok(told):
    failed = Outcome("alone", 1.0, failure="a traceback")
    code, out = told([failed], "--only", "alone.size", "--json")
    row = {"value": None, "frozen": None, "unit": "mm", "ok": False}
    assert (code, json.loads(out)) == (1, {"figures": {"alone.size": row}})


def test_an_unknown_name_is_refused(told):
    with pytest.raises(SystemExit, match="no figure 'alone_length'"):
        told([], "--only", "alone_length")
