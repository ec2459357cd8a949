"""The verbs on a simulated robot: simulate, calibrate, check, export, and their JSON."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from bodyschema import Body
from bodyschema.cli import run
from bodyschema.sources.tables import open_recording, write_table


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("robot") / "simulated"
    assert run(["simulate", "--out", str(folder), "--samples", "60", "--seed", "3"]) == 0
    return folder


@pytest.fixture(scope="module")
def result(simulated: Path) -> Path:
    out = simulated.parent / "calibrated"
    code = run(["calibrate", str(simulated / "run.toml"), "--out", str(out), "--free", "offsets"])
    assert code == 0
    return out


def printed(capsys: pytest.CaptureFixture[str]) -> dict[str, object]:
    out = capsys.readouterr().out
    assert out.count("\n") == 1, "one JSON object and nothing else"
    found = json.loads(out)
    assert isinstance(found, dict)
    return found


def test_calibrate_prints_one_json_object(
    simulated: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["calibrate", str(simulated / "run.toml"), "--out", str(tmp_path / "out"), "--json"]
    assert run([*arguments, "--free", "offsets"]) == 0
    answer = printed(capsys)
    assert answer["verdict"] == "calibrated"
    for key in ("nominal", "held_out"):
        assert set(answer[key]["position_mm"]) == {"rms", "median", "max"}  # type: ignore[index]
    assert answer["held_out"]["position_mm"]["rms"] < 5 < answer["nominal"]["position_mm"]["rms"]  # type: ignore[index]
    assert {"name", "value", "std", "unit"} <= set(answer["parameters"][0])  # type: ignore[index]
    assert any("neck_yaw.offset" in sentence for sentence in answer["unidentifiable"])  # type: ignore[attr-defined]
    assert answer["outliers"]
    assert answer["seconds"] > 0  # type: ignore[operator]


def test_the_same_run_gives_the_same_bytes(simulated: Path, result: Path, tmp_path: Path) -> None:
    out = tmp_path / "again"
    assert run(["calibrate", str(simulated / "run.toml"), "-o", str(out), "--free", "offsets"]) == 0
    for name in ("robot.urdf", "kinematics.yaml", "transforms.yaml", "answer.json"):
        assert (out / name).read_bytes() == (result / name).read_bytes()


def test_check_of_the_same_robot(
    simulated: Path, result: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code = run(["check", str(result), "--recording", str(simulated / "recording.csv"), "--json"])
    assert code == 0
    answer = printed(capsys)
    assert answer["verdict"] == "still true"


def test_check_of_a_knocked_robot(
    simulated: Path, result: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recording = open_recording(simulated / "recording.csv")
    columns = dict(recording.columns)
    columns["r_elbow"] = columns["r_elbow"] - np.deg2rad(1.0)
    write_table(tmp_path / "knocked.csv", columns)
    arguments = ["check", str(result), "--recording", str(tmp_path / "knocked.csv")]
    assert run(arguments) == 1
    text = capsys.readouterr().out
    assert text.startswith("changed")
    assert "r_elbow: offset +1.0" in text or "r_elbow: offset +0.9" in text
    assert "Next:" in text
    assert run([*arguments, "--json"]) == 1
    assert "r_elbow" in [suspect["part"] for suspect in printed(capsys)["suspects"]]  # type: ignore[attr-defined]


def test_check_refuses_what_it_cannot_use(
    simulated: Path, result: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with (simulated / "recording.csv").open(newline="") as file:
        rows = list(csv.reader(file))
    (tmp_path / "two.csv").write_text("\n".join(",".join(row) for row in rows[:3]) + "\n")
    assert run(["check", str(result), "--recording", str(tmp_path / "two.csv")]) == 2
    assert "at least 3" in capsys.readouterr().err
    assert run(["check", str(tmp_path), "--recording", str(simulated / "recording.csv")]) == 2
    assert "name a folder that bodyschema wrote" in capsys.readouterr().err


def test_export_into_the_original(
    simulated: Path, result: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "corrected.urdf"
    arguments = ["export", str(result), "--robot", str(simulated / "robot.urdf"), "--out", str(out)]
    assert run(arguments) == 0
    first = Body.from_urdf(out)
    second = Body.from_urdf(result / "robot.urdf")
    assert first.placement == pytest.approx(second.placement, abs=1e-8)
    assert run(arguments) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert run([*arguments, "--overwrite"]) == 0
    arguments[-1] = str(simulated / "robot.urdf")
    assert run([*arguments, "--overwrite"]) == 2
    assert "belongs to the result in" in capsys.readouterr().err


@pytest.mark.parametrize("verb", ["calibrate", "simulate", "check", "export", "plan", "report"])
def test_every_verb_explains_itself(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        run([verb, "--help"])
    assert stop.value.code == 0
    assert "--json" in capsys.readouterr().out


def test_a_flag_that_does_not_exist_is_bad_input(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        run(["calibrate", "--robott", "x"])
    assert stop.value.code == 2
