"""Bags that cannot be used: one sentence with what is there, and exit code 2."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bodyschema import Body
from bodyschema.cli import run
from bodyschema.export.urdf_writer import write_urdf
from input_writers import EYE, FORMS, JOINTS, POSE

pytest.importorskip("rosbags")

ARM = Body.random_chain(3, np.random.default_rng(3))
RUN = """
robot = "robot.urdf"
recording = {recording}
join = "time"
[frames.board]
parent = "base"
[frames.camera]
parent = "tip"
[[senses]]
kind = "poses"
seen_from = "board"
seen = "camera"
layout = "xyz_xyzw"
columns = {columns}
"""


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Twenty joint states and poses, in three forms."""
    folder = tmp_path_factory.mktemp("bags")
    rng = np.random.default_rng(1)
    columns = {joint: rng.uniform(-1, 1, 20) for joint in ARM.joints}
    columns |= dict.fromkeys(POSE[:6], np.zeros(20)) | {POSE[6]: np.ones(20)}
    for form in ("ROS 1 by rosbags", "sqlite3 by rosbags", "MCAP by rosbags"):
        FORMS[form](columns, folder)
    (folder / "robot.urdf").write_bytes(write_urdf(ARM))
    next((folder / "mcap").glob("*.mcap")).rename(folder / "rec.mcap")
    return folder


@pytest.fixture
def said(bags: Path, capsys: pytest.CaptureFixture[str]) -> Any:
    """What `calibrate` says of a recording that it refuses."""

    def refused(recording: Any, columns: Any = POSE, more: str = "") -> str:
        text = RUN.format(recording=json.dumps(recording), columns=json.dumps(list(columns)))
        (bags / "run.toml").write_text(text + more)
        capsys.readouterr()
        code = run(["calibrate", str(bags / "run.toml"), "--out", str(bags / "out"), "--json"])
        told = capsys.readouterr()
        assert code == 2
        assert told.out == ""
        assert told.err.count("\n") == 1, "one sentence on one line"
        assert not (bags / "out").exists()
        return told.err

    return refused


def test_no_stream_has_the_joints(said: Any) -> None:
    words = said(f"rec.mcap#{EYE}")
    assert "no file or topic of recording has columns of the robot's joints, 'joint_1'" in words
    assert "there are: 'time', 'x'" in words


def test_a_topic_that_is_not_there(said: Any) -> None:
    words = said("rec.mcap#/joints")
    assert "no topic '/joints' in" in words
    assert f"did you mean '{JOINTS}'" in words


def test_a_topic_without_what_was_seen(said: Any) -> None:
    words = said("rec.mcap", [*POSE[:6], "q_w"])
    assert "no file or topic of recording has all columns of the poses" in words
    assert "name the one that has what was seen" in words


@pytest.mark.parametrize(
    ("name", "way"),
    [("ros1.bag", "rosbag reindex"), ("sqlite3/sqlite3.db3", "sqlite3"), ("rec.mcap", "no topics")],
)
def test_a_bag_that_breaks_off(said: Any, bags: Path, name: str, way: str) -> None:
    whole = bags / name
    data = whole.read_bytes()
    cut = bags / f"cut{whole.suffix}"
    cut.write_bytes(data[: len(data) // 3])
    words = said(cut.name)
    assert way in words or "before any message is whole" in words
    assert "is no bag that can be read" in words


def test_what_is_no_bag(said: Any, bags: Path) -> None:
    (bags / "text.mcap").write_text("a,b\n1,2\n")
    assert "'text.mcap' is no bag that can be read" in said("text.mcap").replace(f"{bags}/", "")


def test_streams_that_share_no_time(said: Any) -> None:
    """By the lag of a clock that is known exactly."""
    clock = '[parts.late]\nkind = "clock"\nknown = "exactly"\nlag_ms = 99000.0\n'
    words = said("rec.mcap", more='clock = "late"\n' + clock)
    assert "no row of 'rec.mcap#/eye/pose' (0.000 to 0.594 s) lies within the times of" in words


def test_a_video_that_is_none(bags: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (bags / "film.mp4").write_bytes(b"not a film")
    (bags / "joints.csv").write_text("time,joint_1\n0,0\n1,1\n")
    asked = ["find-body", str(bags / "film.mp4"), "--encoders", str(bags / "joints.csv")]
    assert run([*asked, "--out", str(bags / "found")]) == 2
    words = capsys.readouterr().err
    assert "film.mp4" in words
    assert words.count("\n") == 1
