"""`bodyschema compare`: words, one JSON object, and the exit code."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from bodyschema.cli import run
from bodyschema.sources.tables import open_recording, write_table
from recorded_arm import recorded_arm


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Results of one arm: as it was, and after its third joint slipped by 1 deg."""
    here = tmp_path_factory.mktemp("compared")
    path = recorded_arm(here)
    assert run(["calibrate", str(path), "--out", str(here / "before"), "--json"]) == 0
    columns = dict(open_recording(here / "data.csv").columns)
    columns["joint_3"] = columns["joint_3"] - np.deg2rad(1.0)
    write_table(here / "data.csv", columns)
    assert run(["calibrate", str(path), "--out", str(here / "after"), "--json"]) == 0
    return here


def test_the_same(folders: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert run(["compare", str(folders / "before"), str(folders / "before")]) == 0
    said = capsys.readouterr().out
    assert said.startswith("the same: what differs is no more than chance brings; p = 1")
    assert "marker in tracker: 0.00 mm" in said


def test_a_joint_that_slipped(folders: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    asked = ["compare", str(folders / "before"), str(folders / "after")]
    assert run(asked) == 1
    said = capsys.readouterr().out
    assert said.startswith("different: joint_3")
    (row,) = [line for line in said.splitlines() if line.startswith("* ")]
    assert "offset +1.0" in row
    assert run([*asked, "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["differs"] == ["joint_3"]
    assert found["parts"][0]["moves_mm_95"] > found["pairs"][0]["unexplained_mm_95"]
    low, high = found["parts"][0]["moves_mm_between"]
    assert low < found["parts"][0]["moves_mm_95"] < high


def test_what_is_no_result(folders: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["compare", str(folders), str(folders / "before")]) == 2
    assert "no answer.json in" in capsys.readouterr().err
    wrong = ["compare", *[str(folders / "before")] * 2, "--false-alarm", "2"]
    assert run(wrong) == 2
    assert "a probability" in capsys.readouterr().err
