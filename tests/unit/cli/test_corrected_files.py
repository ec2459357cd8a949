"""`export --recording` and `--calibration`: what was recorded, with the zeros that were found."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import bodyschema as bs
from bodyschema.cli import run
from bodyschema.cli.reading.joints import read_joints
from bodyschema.cli.run_file import read_run_file
from bodyschema.sources.motors import read_motors
from bodyschema.sources.tables import open_recording, write_table
from recorded_arm import recorded_arm

MOTOR = {"id": 1, "drive_mode": 0, "homing_offset": 12, "range_min": 500, "range_max": 3500}


@pytest.fixture(scope="module")
def here(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A result, of an arm recorded in percent of the ranges of its motors."""
    folder = tmp_path_factory.mktemp("corrected")
    path = recorded_arm(folder)
    columns = dict(open_recording(folder / "data.csv").columns)
    for name in ("joint_1", "joint_2", "joint_3"):
        columns[f"{name}.pos"] = np.rad2deg(columns.pop(name)) * 4095 / 360 * 200 / 3000
    columns["joint_2.pos"] *= -1
    write_table(folder / "data.csv", columns)
    (folder / "arm.json").write_text(json.dumps({f"joint_{i}": {**MOTOR, "id": i}
                                                 for i in (1, 2, 3)}))  # fmt: skip
    joints = """
[joints]
unit = "percent"
calibration = "arm.json"
columns = { joint_1 = "joint_1.pos", joint_3 = "joint_3.pos" }
joint_2 = { column = "joint_2.pos", sign = -1 }
"""
    path.write_text(path.read_text() + joints)
    assert run(["calibrate", str(path), "--out", str(folder / "result"), "--json"]) == 0
    return folder


def readings(here: Path, recording: Path, calibration: Path | None = None) -> Any:
    """(n, 3) rad as the run reads them."""
    asked = read_run_file(here / "run.toml")
    joints = asked.joints
    if calibration is not None:
        from dataclasses import replace

        joints = replace(joints, motors=read_motors(calibration))
    body = bs.Body.from_urdf(here / "robot.urdf")
    return read_joints(body, open_recording(recording), joints)


def cells(path: Path) -> list[list[str]]:
    return [line.split(",") for line in path.read_text().splitlines()]


def written_offset(here: Path) -> float:
    from bodyschema.export.corrections import joint_corrections

    found = joint_corrections(bs.load(here / "result"))
    assert {*found} == {"joint_2.offset"}
    return found["joint_2.offset"]


def test_a_text_table(here: Path, tmp_path: Path) -> None:
    """Cells that are not corrected stay as they are written, texts too."""
    rows = cells(here / "data.csv")
    source, out = tmp_path / "more.csv", tmp_path / "out.csv"
    with source.open("w", newline="") as file:
        csv.writer(file).writerows(
            [[*rows[0], "who"], *([*row, f"Ann {i}"] for i, row in enumerate(rows[1:]))]
        )
    asked = ["export", str(here / "result"), "--recording", str(source), "--out", str(out)]
    assert run(asked) == 0
    again = cells(out)
    at = rows[0].index("joint_2.pos")
    for before, after in zip(cells(source), again, strict=True):
        assert before[:at] + before[at + 1 :] == after[:at] + after[at + 1 :]
    more = readings(here, out) - readings(here, source)
    assert more[:, 1] == pytest.approx(written_offset(here), abs=1e-12)
    assert run(asked) == 2, "a file that is there stays"


def test_other_kinds_of_tables(here: Path, tmp_path: Path) -> None:
    table = open_recording(here / "data.csv").columns
    for kind in ("npz", "parquet"):
        source, out = tmp_path / f"in.{kind}", tmp_path / f"{kind}.parquet"
        if kind == "npz":
            np.savez(source, **{k: np.asarray(v) for k, v in table.items()})
        else:
            pq.write_table(pa.table({**table, "who": ["Ann"] * len(table["x"])}), source)
        asked = ["export", str(here / "result"), "--recording", str(source), "--out", str(out)]
        assert run(asked) == 0
        more = readings(here, out) - readings(here, source)
        assert more[:, 1] == pytest.approx(written_offset(here), abs=1e-12)
        assert ("who" in pq.read_table(out).column_names) == (kind == "parquet")


def test_the_calibration_of_lerobot(
    here: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The same ticks read with the new file are the corrected readings, in the same units."""
    out = tmp_path / "new.json"
    capsys.readouterr()
    asked = ["export", str(here / "result"), "--calibration", str(here / "arm.json")]
    assert run([*asked, "--out", str(out), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["motors"] == ["joint_2"]
    old, new = json.loads((here / "arm.json").read_text()), json.loads(out.read_text())
    assert new["joint_1"] == old["joint_1"]
    assert new["joint_2"]["homing_offset"] == 12
    assert new["joint_2"]["range_max"] - new["joint_2"]["range_min"] == 3000
    ticks = np.array([600.0, 2000.0])
    moved = []
    for file in (old, new):
        low, high = file["joint_2"]["range_min"], file["joint_2"]["range_max"]
        percent = (ticks - low) / (high - low) * 200 - 100
        write_table(tmp_path / "t.csv", {"joint_2.pos": percent, "joint_1.pos": [0, 0],
                                         "joint_3.pos": [0, 0]})  # fmt: skip
        moved.append(readings(here, tmp_path / "t.csv")[:, 1])
    half_a_tick = np.pi / 4095
    assert moved[1] - moved[0] == pytest.approx(written_offset(here), abs=1.01 * half_a_tick)


def test_what_cannot_be_corrected(
    here: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    result = ["export", str(here / "result")]
    other, stranger = tmp_path / "other.csv", tmp_path / "other.json"
    other.write_text("a,b\n1,2\n")
    stranger.write_text(json.dumps({"wheel": MOTOR}))
    for flags, words in (
        ([], "one of them"),
        (["--recording", str(other)], "has no column of the joints that are corrected"),
        (["--calibration", str(stranger)], "no motor of the joints that are corrected"),
        (["--recording", str(other), "--out", str(tmp_path / "o.xlsx")], "ending in .csv or"),
        (["--recording", str(other), "--robot", str(here / "robot.urdf")], "one of them"),
    ):
        assert run([*result, *flags]) == 2
        assert words in capsys.readouterr().err
