"""`bodyschema inspect`: what is in a recording, and a run file that works."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from bodyschema.cli import run
from bodyschema.cli.run_file import read_run_file
from bodyschema.sources.tables import write_table
from lerobot_folder import VERSION_3, write_info, write_rows

RECORDING = {"csv": "recording.csv", "bag": "recording", "lerobot": "dataset"}


@pytest.mark.parametrize("form", RECORDING)
def test_what_it_suggests_calibrates(
    form: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("rosbags")
    home, text = tmp_path / "arm", tmp_path / "arm" / "begin.toml"
    made = ["simulate", "--scene", "wrist-camera", "--form", form, "--samples", "15"]
    assert run([*made, "--out", str(home)]) == 0
    asked = ["inspect", str(home / RECORDING[form]), "--robot", str(home / "arm.urdf")]
    capsys.readouterr()
    assert run([*asked, "--write", str(text), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert text.read_text() == found["suggested"]
    assert len(found["joints"]) == 6
    assert found["joint_unit"] == ("deg" if form == "lerobot" else "rad")
    rates = [stream["rate_hz"] for stream in found["streams"]]
    expected = {"csv": [None], "bag": [50, 10], "lerobot": [10]}[form]
    assert [rate and round(rate, 3) for rate in rates] == expected
    out = tmp_path / "out"
    assert run(["calibrate", str(text), "--out", str(out), "--free", "offsets", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["verdict"] == "calibrated"
    truth = json.loads((home / "truth.json").read_text())["offsets_rad"]
    told = {p["name"].partition(".")[0]: p for p in answer["parameters"] if "offset" in p["name"]}
    for joint in ("shoulder_lift", "elbow", "wrist_1", "wrist_2"):
        assert abs(told[joint]["value"] - truth[joint]) < 4 * told[joint]["std"]


def test_a_file_that_is_there_stays(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_table(tmp_path / "a.csv", {"j1": [1.0, 2.0], "x": [1.0, 2.0]})
    (tmp_path / "run.toml").write_text("mine")
    assert run(["inspect", str(tmp_path / "a.csv"), "--write", str(tmp_path / "run.toml")]) == 2
    assert "inspect never replaces a file" in capsys.readouterr().err
    assert (tmp_path / "run.toml").read_text() == "mine"


def test_poses_without_joints_are_for_hand_eye(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    columns = {f"{k}_{i}{j}": [0.1, 0.2] for k in "AB" for i in range(3) for j in range(4)}
    write_table(tmp_path / "pairs.csv", columns)
    text = tmp_path / "run.toml"
    assert run(["inspect", str(tmp_path / "pairs.csv"), "--write", str(text)]) == 0
    asked = read_run_file(text, "hand-eye")
    assert [entry.columns[0] for entry in asked.senses] == ["A_00", "B_00"]
    said = capsys.readouterr().out
    assert "may be poses in m: A_00" in said
    assert "2 samples, no clock" in said


def test_ticks_names_and_clocks_go_into_the_run_file(tmp_path: Path) -> None:
    time = 1.7e18 + 1e8 * np.arange(5)
    table = {"t_ns": time, "m1.pos": np.linspace(100, 3000, 5), "tip_x": 900 + np.arange(5.0)}
    write_table(tmp_path / "a.csv", table | {"tip_y": np.arange(5.0), "tip_z": np.arange(5.0)})
    text = tmp_path / "run.toml"
    assert run(["inspect", str(tmp_path / "a.csv"), "--write", str(text)]) == 0
    asked = read_run_file(text)
    entry = asked.joints.of("m1")
    assert (entry.column, entry.unit, entry.zero) == ("m1.pos", "", 2048)
    assert asked.joints.unit == "deg"
    assert entry.scale == pytest.approx(360 / 4096)
    assert asked.time == "t_ns"
    assert (asked.senses[0].kind, asked.senses[0].unit) == ("points", "mm")


def test_the_calibration_of_a_data_set_in_percent(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """LeRobot's file beside it says what one percent is."""
    state = {"dtype": "float32", "shape": [2], "names": ["shoulder.pos", "elbow.pos"]}
    write_info(tmp_path / "set", VERSION_3, features={"observation.state": state})
    place = {"chunk_index": 0, "file_index": 0}
    rows = np.linspace([-100, 0], [100, 50], 12).astype(np.float32)
    write_rows(tmp_path / "set" / VERSION_3["data_path"].format(**place), rows, [0])
    motor = {"id": 1, "drive_mode": 0, "homing_offset": 0, "range_min": 0, "range_max": 9}
    (tmp_path / "so101.json").write_text(json.dumps({"elbow": motor}))
    text = tmp_path / "run.toml"
    assert run(["inspect", str(tmp_path / "set"), "--write", str(text), "--json"]) == 0
    joints = read_run_file(text).joints
    assert (joints.unit, joints.motors["elbow"].range_max) == ("percent", 9)
    assert 'calibration = "so101.json"' in text.read_text()
