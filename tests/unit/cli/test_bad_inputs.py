"""Ten bad inputs: each ends in exit code 2, one helpful sentence, and no output left behind."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from bodyschema import Body
from bodyschema.cli import run
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.kinematics import relative_pose
from bodyschema.sources.tables import write_table

Columns = dict[str, np.ndarray]
RUN = """
{extra}
robot = "robot.urdf"
recording = "{recording}"
[frames.tracker]
parent = "base"
[frames.marker]
parent = "{hand}"
[[senses]]
kind = "points"
seen_from = "tracker"
seen = "marker"
columns = ["x", "y", "z"]
"""


@pytest.fixture
def arm() -> Body:
    return Body.random_chain(6, np.random.default_rng(3))


@pytest.fixture
def columns(arm: Body) -> Columns:
    """A good recording of 40 postures."""
    rng = np.random.default_rng(5)
    q = rng.uniform(-1.2, 1.2, size=(40, 6))
    body = arm.attach("tracker", "base").attach("marker", "tip")
    points = relative_pose(body, q, "tracker", "marker")[:, :3, 3]
    points += 1e-3 * rng.normal(size=points.shape)
    joints = {joint: q[:, j] for j, joint in enumerate(arm.joints)}
    seen = dict(zip("xyz", points.T, strict=True))
    return {"time": 0.1 * np.arange(40.0), **joints, **seen}


@pytest.fixture
def calibrate(tmp_path: Path, arm: Body) -> Callable[..., int]:
    """Write a run in a folder and calibrate it; returns the exit code."""

    def attempt(columns: Columns, *arguments: str, **changes: str) -> int:
        settings = {"recording": "data.csv", "hand": "tip", "extra": "", **changes}
        (tmp_path / "robot.urdf").write_bytes(write_urdf(arm))
        if not (tmp_path / settings["recording"]).exists():
            write_table(tmp_path / settings["recording"], columns)
        (tmp_path / "run.toml").write_text(RUN.format(**settings))
        out = str(tmp_path / "result")
        return run(["calibrate", str(tmp_path / "run.toml"), "--out", out, "--json", *arguments])

    return attempt


def refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], code: int, *words: str, out: str = "result"
) -> None:
    """Exit code 2, one sentence with these words on standard error, nothing else anywhere."""
    printed = capsys.readouterr()
    assert code == 2
    assert printed.out == ""
    assert printed.err.startswith("bodyschema: ")
    assert printed.err.count("\n") == 1, "one sentence on one line"
    for word in words:
        assert word in printed.err
    assert "Traceback" not in printed.err
    allowed = {"robot.urdf", "data.csv", "data.parquet", "run.toml", "file"}
    assert {path.name for path in tmp_path.iterdir()} <= allowed, "nothing is left behind"


def test_the_good_recording_passes(
    calibrate: Callable[..., int], columns: Columns, tmp_path: Path
) -> None:
    assert calibrate(columns) == 0
    assert (tmp_path / "result" / "robot.urdf").is_file()


def test_nan(calibrate, columns, tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    write_table(tmp_path / "data.csv", columns)
    text = (tmp_path / "data.csv").read_text().splitlines()
    cells = text[8].split(",")
    cells[-1] = "nan"
    (tmp_path / "data.csv").write_text("\n".join([*text[:8], ",".join(cells), *text[9:]]) + "\n")
    refused(tmp_path, capsys, calibrate(columns), "'z'", "row 7", "nan", "drop or repair")


def test_degrees_as_radians(calibrate, columns, tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    wrong = {k: np.degrees(v) if k.startswith("joint") else v for k, v in columns.items()}
    refused(tmp_path, capsys, calibrate(wrong), "degrees", 'unit = "deg"', "joint_1")


def test_missing_column(calibrate, columns, tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    columns["zz"] = columns.pop("z")
    refused(tmp_path, capsys, calibrate(columns), "no column 'z'")


def test_unknown_frame(calibrate, columns, tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    code = calibrate(columns, hand="tipp")
    refused(tmp_path, capsys, code, "no frame 'tipp'", "did you mean 'tip'")


@pytest.mark.parametrize(("fault", "word"), [(0.0, "repeats"), (-0.5, "goes back")])
def test_time(calibrate, columns, tmp_path, capsys, fault, word) -> None:  # type: ignore[no-untyped-def]
    columns["time"][20] = columns["time"][19] + fault
    refused(tmp_path, capsys, calibrate(columns), word, "row 20", "sort")


def test_truncated_parquet(calibrate, columns, tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "data.parquet"
    write_table(path, columns)
    path.write_bytes(path.read_bytes()[:-200])
    code = calibrate(columns, recording="data.parquet")
    refused(tmp_path, capsys, code, "data.parquet", "no whole Parquet file")


def test_other_joint_names(calibrate, columns, tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    renamed = {k.replace("joint_", "axis"): v for k, v in columns.items()}
    code = calibrate(renamed)
    refused(tmp_path, capsys, code, "no column for joint joint_1", "[joints] columns")


def test_three_samples_for_forty_parameters(calibrate, columns, tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    few = {name: values[:3] for name, values in columns.items()}
    code = calibrate(few, "--free", "offsets", "axes", "links")
    refused(tmp_path, capsys, code, "3 samples", "parameters", "record at least")


def test_all_in_one_pose(calibrate, columns, tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    still = {k: np.full_like(v, 0.3) if k.startswith("joint") else v for k, v in columns.items()}
    refused(tmp_path, capsys, calibrate(still), "one posture", "spread over the workspace")


def test_unwritable_folder(calibrate, columns, tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    (tmp_path / "file").write_text("a file, no folder")
    code = calibrate(columns, "--out", str(tmp_path / "file" / "result"))
    refused(tmp_path, capsys, code, "cannot write to", "choose a folder")


def test_unknown_key(calibrate, columns, tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    code = calibrate(columns, extra="foldz = 5")
    refused(tmp_path, capsys, code, "unknown key 'foldz'", "did you mean 'folds'")


def test_output_folder_in_use(calibrate, columns, tmp_path, capsys) -> None:  # type: ignore[no-untyped-def]
    (tmp_path / "result").mkdir()
    (tmp_path / "result" / "mine.txt").write_text("keep")
    assert calibrate(columns) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert calibrate(columns, "--overwrite") == 2
    assert "will not remove it" in capsys.readouterr().err
    assert (tmp_path / "result" / "mine.txt").read_text() == "keep"
