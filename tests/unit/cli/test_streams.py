"""Joints and senses in files of their own rates and clocks."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import Body, InputError
from bodyschema.cli import run as main
from bodyschema.cli.loading import load, read_senses
from bodyschema.cli.reading import streams
from bodyschema.cli.run_file import read_run_file, run_from_table
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.kinematics import relative_pose
from bodyschema.sources.recording import Recording
from bodyschema.sources.tables import write_table

Array = NDArray[np.float64]

HEAD = """
robot = "robot.urdf"
recording = ["joints.csv", "seen.csv"]
join = "time"
[frames.eye]
parent = "base"
[frames.mark]
parent = "tip"
"""
POINTS = """
[[senses]]
kind = "points"
seen_from = "eye"
seen = "mark"
columns = ["x", "y", "z"]
"""


@pytest.fixture
def arm() -> Body:
    return Body.random_chain(4, np.random.default_rng(3))


def motion(time: Array) -> Array:
    periods, phases = np.array([7.0, 5.3, 4.1, 6.2]), np.array([0.0, 1.0, 2.0, 3.0])
    return np.asarray(0.8 * np.sin(2 * np.pi * time[:, None] / periods + phases))


@pytest.fixture
def record(tmp_path: Path, arm: Body) -> Any:
    """Write both files: what is seen at a time is stamped `lag` later. Returns the run file."""

    def write(lag: float, lines: str = POINTS, head: str = HEAD) -> Path:
        rng = np.random.default_rng(1)
        joints, seen = np.arange(0, 30, 0.11), np.arange(1, 29, 0.37)
        T = relative_pose(arm, motion(seen) + np.array([0, 0.02, -0.03, 0.02]), "base", "tip")
        p = T[:, :3, 3] + 5e-4 * rng.normal(size=(len(seen), 3))
        q = dict(zip(arm.joints, motion(joints).T, strict=True))
        write_table(tmp_path / "joints.csv", {"time": joints, **q})
        columns = dict(zip("xyz", p.T, strict=True))
        write_table(tmp_path / "seen.csv", {"time": seen + lag, **columns})
        (tmp_path / "robot.urdf").write_bytes(write_urdf(arm))
        (tmp_path / "run.toml").write_text(head + lines)
        return tmp_path / "run.toml"

    return write


@pytest.mark.parametrize("lag", [-0.8, 1.7e9])
def test_the_lag_is_found(record: Any, lag: float) -> None:
    """Of both signs, and of a clock with another zero."""
    loaded = load(read_run_file(record(lag)))
    clock = loaded.body.part("clock_of_seen")
    assert clock["lag"] == 0, "what is left is for the fit"
    found = clock["joined"]
    assert found == pytest.approx(lag, abs=0.003)
    assert loaded.parts == {"clock_of_seen": ("lag",)}
    (sentence,) = loaded.body.remarks
    said = f"{1e3 * abs(found):.1f} ms early" if lag < 0 else f"{found:.3f} s late"
    assert said in sentence
    (sense,) = loaded.senses
    q = motion(sense.time - lag)
    assert np.abs(sense.q - q).max() < 0.01


def test_the_whole_way(record: Any, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = ["--out", str(tmp_path / "out"), "--free", "offsets", "--json"]
    assert main(["calibrate", str(record(0.4)), *out]) == 0
    answer = json.loads(capsys.readouterr().out)
    found = {p["name"]: p for p in answer["parameters"]}
    assert found["joint_3.offset"]["value"] == pytest.approx(-0.03, abs=0.005)
    assert found["clock_of_seen.lag"]["std"] < 0.003
    assert any(re.search(r"(399|400)\.\d ms late", note) for note in answer["notes"])
    plan = ["--out", str(tmp_path / "plan.csv"), "-n", "2", "--json"]
    assert main(["plan", str(tmp_path / "out"), *plan]) == 0
    assert not any("not read again" in n for n in json.loads(capsys.readouterr().out)["notes"])


def test_a_clock_that_is_known(record: Any, tmp_path: Path) -> None:
    """Then nothing is searched; what lies beyond the joints, or in a pause, is left out."""
    clock = '[parts.trigger]\nkind = "clock"\nknown = "exactly"\nlag_ms = 400.0\n'
    run = read_run_file(record(0.4, clock + POINTS + 'clock = "trigger"\n'))
    loaded = load(run)
    assert loaded.parts == {}
    (sense,) = loaded.senses
    assert np.abs(sense.q - motion(sense.time - 0.4)).max() < 1e-3
    assert (sense.readings(loaded.body) == sense.q).all()
    (again,) = read_senses(run, loaded.body)
    assert (again.q == sense.q).all()
    text = (tmp_path / "joints.csv").read_text().splitlines()
    (tmp_path / "joints.csv").write_text("\n".join([text[0], *text[40:200]]) + "\n")
    (fewer,) = load(run).senses
    assert fewer.time.min() - 0.4 >= 39 * 0.11
    assert len(fewer) < len(sense)


@pytest.mark.parametrize(
    ("head", "lines", "words"),
    [
        (HEAD.replace('"time"', '"tim"'), POINTS, "join = 'tim' .*did you mean 'time'"),
        (
            HEAD,
            POINTS.replace('"z"', '"zz"'),
            "no file or topic of recording has all columns of the po",
        ),
        (
            HEAD.replace('["joints.csv", "seen.csv"]', '"seen.csv"'),
            POINTS,
            "no file or topic of recording has columns of the robot's joints, 'joint_1', 'joint_2'",
        ),
        (HEAD.replace('join = "time"', ""), POINTS, 'joined by their times: join = "time"'),
        (HEAD + '[hand_eye]\neye_on = "base"\n', POINTS, r"write it into \[hand_eye\]"),
    ],
)
def test_what_cannot_be_joined_is_said(record: Any, head: str, lines: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        load(read_run_file(record(0.0, lines, head)))


def test_columns_by_a_pattern(record: Any) -> None:
    """A * stands for all columns that match, with streams and without."""
    named = load(read_run_file(record(0.0)))
    pattern = POINTS.replace('"x", "y", "z"', '"[xyz]*"')
    (sense,) = load(read_run_file(record(0.0, pattern))).senses
    assert (sense.observed == named.senses[0].observed).all()
    with pytest.raises(InputError, match=r"no file or topic of recording has all .*'none\*'"):
        load(read_run_file(record(0.0, POINTS.replace('"x", "y", "z"', '"none*"'))))


def test_joints_in_several_files_are_said() -> None:
    said = streams._no_joints(["joint_1"], 2, ["joint_1"])
    assert "2 have columns of them ('joint_1'); leave the others out" in said


def test_streams_of_different_times(record: Any, tmp_path: Path) -> None:
    """A stream without times, and one that is too short to share any with the joints."""
    path = record(0.0)
    text = (tmp_path / "seen.csv").read_text()
    (tmp_path / "seen.csv").write_text(text.replace("time", "stamp"))
    with pytest.raises(InputError, match=r"'seen.csv' has no column time"):
        load(read_run_file(path))


def test_topics_of_a_bag_are_streams(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Joints and poses of one file; what is opened is stood in for, so that no bag is needed."""
    bag, body = str(tmp_path / "rec.mcap"), Body.random_chain(2, np.random.default_rng(1))
    time = np.arange(8.0)
    tables = {
        f"{bag}#/joints": {"time": time, "joint_1": time, "joint_2": -time},
        f"{bag}#/eye/pose": {"time": time + 0.5, "x": time, "y": time, "z": time},
    }
    opened = {name: Recording(name, columns, {}) for name, columns in tables.items()}
    monkeypatch.setattr(streams, "topics_of", lambda name: tuple(tables))
    monkeypatch.setattr(streams, "open_recording", lambda names: opened[names[0]])
    table = {"robot": "a.urdf", "recording": bag, "join": "time"}
    sense = {"kind": "points", "seen_from": "base", "seen": "tip", "columns": ["x", "y", "z"]}
    run = run_from_table({**table, "senses": [sense]}, tmp_path, "run.toml")
    found = streams.Streams.open(run, body)
    assert found.run.senses[0].recording == (f"{bag}#/eye/pose",)
    assert found.clocks == ("clock_of_pose",)
    assert found.stamps_of("clock_of_pose").tolist() == (time + 0.5).tolist()
    assert found.joints((f"{bag}#/eye/pose",)).joints.q[:, 1].tolist() == (-time).tolist()


def test_recordings_of_two_days_with_clocks_of_their_own(record: Any, tmp_path: Path) -> None:
    """Each is joined to its own joints, at its own lag; a board that was moved is one of each."""
    days = []
    for day, lag in (("mon", 0.3), ("tue", -0.2)):
        record(lag)
        (tmp_path / day).mkdir()
        for name in ("joints.csv", "seen.csv"):
            (tmp_path / name).rename(tmp_path / day / name)
        days.append([f"{day}/joints.csv", f"{day}/seen.csv"])
    head = HEAD.replace('["joints.csv", "seen.csv"]', json.dumps(days[0]))
    head = head.replace('parent = "base"', 'parent = "base"\nper_recording = true')
    path = tmp_path / "run.toml"
    path.write_text(f"append = [{json.dumps(days[1])}]\n" + head + POINTS)
    run = read_run_file(path)
    loaded = load(run)
    lags = [loaded.body.part(name)["joined"] for name in ("clock_of_seen", "clock_of_seen_2")]
    assert lags == pytest.approx([0.3, -0.2], abs=0.003)
    assert {"eye_1", "eye_2"} <= {*loaded.frames}
    first, second = loaded.senses
    assert (first.seen_from, second.seen_from) == ("eye_1", "eye_2")
    assert min(second.rows) > max(first.rows), "rows are numbered through"
    for sense, lag in zip(loaded.senses, (0.3, -0.2), strict=True):
        assert np.abs(sense.q - motion(sense.time - lag)).max() < 0.01
    again = read_senses(run, loaded.body)
    assert [len(sense) for sense in again] == [len(sense) for sense in loaded.senses]


def test_a_day_without_joints_is_said(record: Any, tmp_path: Path) -> None:
    record(0.0)
    (tmp_path / "other.csv").write_text((tmp_path / "seen.csv").read_text())
    text = 'append = [["seen.csv", "other.csv"]]\n' + HEAD + POINTS
    (tmp_path / "run.toml").write_text(text.replace('recording = ["joints.csv", "seen.csv"]', ""))
    with pytest.raises(InputError, match="no file or topic of recording has columns of the robot"):
        load(read_run_file(tmp_path / "run.toml"))


def test_days_without_a_frame_that_moved_are_said(record: Any, tmp_path: Path) -> None:
    record(0.0)
    for name in ("joints.csv", "seen.csv"):
        (tmp_path / f"other_{name}").write_text((tmp_path / name).read_text())
    text = 'append = [["other_joints.csv", "other_seen.csv"]]\n' + HEAD + POINTS
    (tmp_path / "run.toml").write_text(text)
    with pytest.raises(InputError, match="may have moved between, per_recording = true"):
        load(read_run_file(tmp_path / "run.toml"))
    (tmp_path / "run.toml").write_text("append = [[]]\n" + HEAD + POINTS)
    with pytest.raises(InputError, match=r"append in 'run\.toml' has a recording of no files"):
        read_run_file(tmp_path / "run.toml")
