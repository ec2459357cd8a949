"""docs/board_photographs.md, executed on pictures of a board that were drawn here."""

from __future__ import annotations

import csv
import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import bodyschema as bs
from board_folder import write_board_folder
from bodyschema.cli import run
from bodyschema.model.kinematics import relative_pose
from bodyschema.simulation.wrist_camera import arm_body

pytest.importorskip("cv2")

PAGE = (Path(__file__).parents[2] / "docs" / "board_photographs.md").read_text(encoding="utf-8")


def test_the_page_goes_from_photographs_to_the_camera(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    truth = write_board_folder(tmp_path, n=15)
    whole, *_ = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "run.toml").write_text(whole)
    monkeypatch.chdir(tmp_path)
    for command in re.findall(r"^```sh\n(.*?)\n```", PAGE, re.DOTALL | re.MULTILINE):
        assert run([*shlex.split(command)[1:], "--json"]) == 0
    answer = json.loads(capsys.readouterr().out.splitlines()[-1])
    assert (tmp_path / "board.pdf").read_bytes().startswith(b"%PDF")
    assert (tmp_path / "camera" / "robot.urdf").is_file()
    found = {p["name"]: p for p in answer["parameters"]}
    elbow = found["elbow.offset"]
    assert abs(elbow["value"] - truth.offsets[2]) < 4 * elbow["std"] + 1e-4


def test_flange_poses_alone_are_a_hand_that_flies(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    truth = write_board_folder(tmp_path, n=12)
    arm = arm_body()
    with (tmp_path / "joints.csv").open() as file:
        q = np.array([[float(row[j]) for j in arm.joints] for row in csv.DictReader(file)])
    T = relative_pose(arm, q + truth.offsets, "base", "flange")
    seven = np.hstack([T[:, :3, 3], Rotation.from_matrix(T[:, :3, :3]).as_quat()])
    names = ("x", "y", "z", "qx", "qy", "qz", "qw")
    np.savetxt(
        tmp_path / "flange_poses.csv", seven, delimiter=",", header=",".join(names), comments=""
    )
    monkeypatch.chdir(tmp_path)
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    exec(code, {})
    text = (tmp_path / "run.toml").read_text()
    text = text.replace('"arm.urdf"', '"hand.urdf"').replace('"joints.csv"', '"hand_joints.csv"')
    (tmp_path / "run.toml").write_text(text + "[free]\ngroups = []\n")
    assert run(["calibrate", "run.toml", "--out", "out"]) == 0
    capsys.readouterr()
    found = relative_pose(bs.load("out").body, np.zeros((1, 6)), "flange", "camera")[0, :3, 3]
    assert found == pytest.approx(truth.T_link_camera[:3, 3], abs=1e-3)
