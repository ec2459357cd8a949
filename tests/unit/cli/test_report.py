"""`bodyschema report`, and the report that `calibrate` leaves."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
import yaml

from bodyschema.cli import run
from bodyschema.cli.calibrate import Calibrate
from bodyschema.report import page
from recorded_arm import recorded_arm


@pytest.fixture(scope="module")
def run_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded_arm(tmp_path_factory.mktemp("run"))


@pytest.fixture(scope="module")
def result(run_file: Path) -> Path:
    out = run_file.parent / "result"
    assert run(["calibrate", str(run_file), "--out", str(out), "--json"]) == 0
    return out


def test_calibrate_leaves_a_report(result: Path, run_file: Path) -> None:
    text = (result / "report.html").read_text(encoding="utf-8")
    document = yaml.safe_load((result / "calibration.yaml").read_text())
    assert document["explanation"] in text
    assert f"bodyschema calibrate {run_file}" in text
    recorded = json.loads((result / "run.json").read_text())
    for digest in recorded["sha256"].values():
        assert digest in text


def test_the_terminal_says_what_calibrate_said(
    result: Path, run_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = run_file.parent / "again"
    assert run(["calibrate", str(run_file), "--out", str(out)]) == 0
    said = capsys.readouterr().out
    assert str(out / "report.html") in said.replace("\n", "")
    assert (out / "report.html").read_bytes() == (result / "report.html").read_bytes()
    assert run(["report", str(out)]) == 0
    again = capsys.readouterr().out
    assert said[: said.index("Corrected robot:")].rstrip() in again
    assert str(out / "report.html") in again.replace("\n", "")
    assert "joint_2.offset" in again


def test_json(result: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["report", str(result), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == yaml.safe_load((result / "calibration.yaml").read_text())


def test_without_a_page(result: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("answer.json", "run.json"):
        (tmp_path / name).write_bytes((result / name).read_bytes())
    assert run(["report", str(tmp_path / "answer.json")]) == 0
    assert "bodyschema[report]" in capsys.readouterr().out.replace("\n", "")


@pytest.mark.parametrize("text", [None, '{"verdict": "yes"}', "[1]", "{", "12\n"])
def test_no_result(text: str | None, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    if text is not None:
        (tmp_path / "answer.json").write_text(text)
    assert run(["report", str(tmp_path)]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("bodyschema: ")
    assert printed.err.count("\n") == 1


def test_an_incomplete_result(
    result: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    document = json.loads((result / "answer.json").read_text())
    del document["held_out"]
    (tmp_path / "answer.json").write_text(json.dumps(document))
    (tmp_path / "run.json").write_text("{}")
    assert run(["report", str(tmp_path)]) == 2
    assert "lacks 'held_out'" in capsys.readouterr().err


def test_calibrate_without_the_extra(
    run_file: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Everything but the page is written, and one line says how to get it."""
    page._environment.cache_clear()
    monkeypatch.setitem(sys.modules, "jinja2", None)
    out = tmp_path / "result"
    assert run(["calibrate", str(run_file), "--out", str(out)]) == 0
    printed = capsys.readouterr()
    assert printed.err.count("bodyschema[report]") == 1
    assert "Report:" not in printed.out
    assert not (out / "report.html").exists()
    assert (out / "robot.urdf").is_file()


def test_the_command_is_repeated_without_its_defaults() -> None:
    asked = Calibrate(Path("a run.toml"), Path("out"), ("offsets", "axes"), overwrite=True)
    assert asked.command() == "bodyschema calibrate 'a run.toml' --free offsets axes"
    flags = Calibrate(joint_unit="deg", force=True, columns=("x", "y", "z"))
    assert flags.command() == ("bodyschema calibrate --columns x y z --joint-unit deg --force")
