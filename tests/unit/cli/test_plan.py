"""`bodyschema plan`: a result folder in, poses for the robot out."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from bodyschema import Body
from bodyschema.cli import run
from bodyschema.cli.plan_answer import _columns
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.kinematics import relative_pose
from bodyschema.sources.tables import open_recording, write_table

RUN = """
robot = "robot.urdf"
recording = "data.csv"
[frames.tracker]
parent = "base"
[frames.marker]
parent = "tip"
[[senses]]
kind = "points"
seen_from = "tracker"
seen = "marker"
columns = ["x", "y", "z"]
[free]
groups = ["offsets"]
"""


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a run, its recording and its result."""
    folder = tmp_path_factory.mktemp("plan")
    rng = np.random.default_rng(3)
    arm = Body.random_chain(4, rng)
    q = rng.uniform(-1.2, 1.2, size=(20, 4))
    seen = arm.attach("tracker", "base").attach("marker", "tip")
    points = relative_pose(seen, q + 0.05, "tracker", "marker")[:, :3, 3]
    points += 1e-3 * rng.normal(size=points.shape)
    columns = {joint: q[:, j] for j, joint in enumerate(arm.joints)}
    write_table(folder / "data.csv", columns | dict(zip("xyz", points.T, strict=True)))
    (folder / "robot.urdf").write_bytes(write_urdf(arm))
    (folder / "run.toml").write_text(RUN)
    out = ["--out", str(folder / "result"), "--force", "--json"]
    assert run(["calibrate", str(folder / "run.toml"), *out]) == 0
    return folder


@pytest.fixture
def folder(calibrated: Path, tmp_path: Path) -> Path:
    """A copy of it, so that a test may break things; the run still names the original files."""
    shutil.copytree(calibrated, tmp_path / "copy")
    return tmp_path / "copy"


def plan(folder: Path, *arguments: str) -> int:
    out = ["--out", str(folder / "plan.csv"), "--candidates", "300"]
    return run(["plan", str(folder / "result"), *out, *arguments])


def test_table_file_and_picture(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert plan(folder, "-n", "4") == 0
    text = capsys.readouterr().out
    for words in ("4 poses", "95 %", "error mm", "Self-collision was not checked", "plan.csv"):
        assert words in " ".join(text.split())
    table = open_recording(folder / "plan.csv")
    assert list(table.columns) == [f"joint_{i}" for i in (1, 2, 3, 4)]
    assert len(table) == 4
    assert (folder / "plan.png").read_bytes().startswith(b"\x89PNG")


def test_json_says_the_same_as_the_file(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert plan(folder, "-n", "3", "--unit", "deg", "--json") == 0
    answer = json.loads(capsys.readouterr().out)
    table = open_recording(folder / "plan.csv")
    values = table.matrix(answer["joints"], "1")[0]
    poses = np.rad2deg(np.array(answer["poses"]))[answer["file_order"]]
    np.testing.assert_allclose(values, poses, atol=1e-5)
    assert len(answer["error_95_mm"]) == 4
    assert answer["error_95_mm"][-1] < answer["error_95_mm"][0]
    assert answer["tool"] == [{"seen_from": "tracker", "seen": "marker"}]
    assert answer["picture"].endswith("plan.png")


def test_same_seed_same_file(folder: Path) -> None:
    assert plan(folder, "--seed", "5", "--json") == 0
    first = (folder / "plan.csv").read_bytes()
    assert plan(folder, "--seed", "5", "--json", "--overwrite") == 0
    assert (folder / "plan.csv").read_bytes() == first
    assert plan(folder, "--seed", "6", "--json", "--overwrite", "--order", "telling") == 0
    assert (folder / "plan.csv").read_bytes() != first


def test_more_may_be_wrong_than_was_corrected(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert plan(folder, "--free", "offsets", "axes", "links", "--json") == 0
    out = capsys.readouterr().out.splitlines()[-1]
    assert json.loads(out)["parameters"] == 4 * 6 + 6 + 3


def test_a_lost_recording_is_said_and_borne(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = folder / "result" / "run.json"
    document = json.loads(path.read_text())
    path.write_text(json.dumps(document | {"recording": ["/nowhere/data.csv"]}))
    capsys.readouterr()
    assert plan(folder, "--json") == 0
    notes = json.loads(capsys.readouterr().out)["notes"]
    assert any("recording was not read again" in note and "nowhere" in note for note in notes)


def test_a_lost_robot_is_said_and_borne(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = folder / "result" / "run.json"
    document = json.loads(path.read_text())
    path.write_text(json.dumps(document | {"robot": "/nowhere/robot.urdf"}))
    capsys.readouterr()
    assert plan(folder, "--json") == 0
    notes = json.loads(capsys.readouterr().out)["notes"]
    assert any("robot description was not read again" in note for note in notes)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["-n", "0"], "--poses 0"),
        (["--candidates", "0"], "--candidates 0"),
        (["-n", "400"], "only 300 postures"),
        (["--tool", "markr"], "did you mean 'marker'"),
        (["--seen-from", "nowhere"], "no frame 'nowhere'"),
        (["--robot", "lost.urdf"], "no robot description at 'lost.urdf'"),
        (["--out", "plan.txt"], "neither .csv nor .parquet"),
    ],
)
def test_bad_requests(
    calibrated: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str],
    arguments: list[str], words: str,
) -> None:  # fmt: skip
    capsys.readouterr()
    out = ["--out", str(tmp_path / "plan.csv"), "--candidates", "300"]
    assert run(["plan", str(calibrated / "result"), *out, *arguments]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.count("\n") == 1
    assert words in printed.err
    assert list(tmp_path.iterdir()) == []


def test_no_result_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["plan", str(tmp_path)]) == 2
    assert "no answer.json" in capsys.readouterr().err


def test_files_are_not_replaced_unasked(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "plan.png").write_text("mine")
    assert plan(folder) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert (folder / "plan.png").read_text() == "mine"
    assert not (folder / "plan.csv").exists()
    # Only the table was named: the picture beside it is replaced if it is one of ours.
    assert plan(folder, "--overwrite") == 2
    assert "is not one that bodyschema drew; move it away" in capsys.readouterr().err
    assert (folder / "plan.png").read_text() == "mine"
    assert not (folder / "plan.csv").exists()


def test_inputs_and_results_are_never_replaced(
    folder: Path, calibrated: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    recording = (calibrated / "data.csv").read_bytes()
    for out in (calibrated / "data.csv", folder / "result" / "plan.csv"):
        assert run(["plan", str(folder / "result"), "--out", str(out), "--overwrite"]) == 2
        assert "inputs are never touched" in capsys.readouterr().err
    assert (calibrated / "data.csv").read_bytes() == recording
    (folder / "link.csv").symlink_to(folder / "data.csv")
    words = ["plan", str(folder / "result"), "--overwrite"]
    assert run([*words, "--out", str(folder / "link.csv")]) == 2
    assert "links are never written through" in capsys.readouterr().err
    robot = (calibrated / "robot.urdf").read_bytes()
    words = ["export", str(folder / "result"), "--robot", str(folder / "robot.urdf"), "--overwrite"]
    for out in (calibrated / "robot.urdf", folder / "robot.urdf", folder / "result" / "robot.urdf"):
        assert run([*words, "--out", str(out)]) == 2
        said = capsys.readouterr().err
        assert "inputs are never touched" in said or "belongs to the result" in said
    assert (calibrated / "robot.urdf").read_bytes() == robot


def test_a_run_without_senses(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = folder / "result" / "run.json"
    document = json.loads(path.read_text())
    path.write_text(json.dumps(document | {"senses": []}))
    assert plan(folder) == 2
    assert "does not say what was seen" in capsys.readouterr().err


def test_the_columns_are_named_where_the_table_has_numbers() -> None:
    joints = ("shoulder_pan_joint", "arm [a] joint")
    assert _columns(joints) == r"Columns: 1 shoulder_pan_joint, 2 arm \[a] joint."
