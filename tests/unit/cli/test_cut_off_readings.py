"""Samples at the end of a motor's range say only that the joint was there or beyond."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from bodyschema.cli.loading import load
from bodyschema.cli.run_file import read_run_file
from bodyschema.sources.tables import open_recording, write_table
from recorded_arm import recorded_arm

JOINTS = '[joints]\nunit = "percent"\ncalibration = "arm.json"\n'
DEG = 180 / np.pi


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """An arm whose second motor was calibrated to 50 deg either way, and moved by 69."""
    made = recorded_arm(tmp_path)
    columns = dict(open_recording(tmp_path / "data.csv").columns)
    motors = {}
    for i, name in enumerate(("joint_1", "joint_2", "joint_3")):
        half = round((50.0 if i == 1 else 90.0) * 4095 / 360)
        motors[name] = {"id": i, "range_min": 2000 - half, "range_max": 2000 + half}
        percent = columns[name] * DEG * 4095 / 360 / half * 100
        columns[name] = np.clip(percent, -100, 100)
    (tmp_path / "arm.json").write_text(json.dumps(motors))
    write_table(tmp_path / "data.csv", columns)
    made.write_text(made.read_text() + JOINTS)
    return made


def test_rows_at_an_end_are_left_out_and_told(path: Path) -> None:
    table = open_recording(path.parent / "data.csv")
    at_end = np.abs(table.columns["joint_2"]) == 100
    assert 0 < at_end.sum() < 25
    loaded = load(read_run_file(path))
    (sense,) = loaded.senses
    assert sense.rows.tolist() == np.flatnonzero(~at_end).tolist()
    assert np.abs(sense.q[:, 1]).max() < 50 / DEG
    (remark,) = loaded.body.remarks
    assert f"joint_2 of 'data.csv': {at_end.sum()} of 25 rows stand at an end" in remark


def test_streams_leave_out_what_lies_beside_such_a_reading(path: Path) -> None:
    columns = dict(open_recording(path.parent / "data.csv").columns)
    time = np.arange(25.0)
    seen = {name: columns.pop(name) for name in "xyz"}
    write_table(path.parent / "joints.csv", {"time": time, **columns})
    write_table(path.parent / "seen.csv", {"time": time[1:-1] + 0.5, **{
        name: values[1:-1] for name, values in seen.items()}})  # fmt: skip
    text = path.read_text().replace('"data.csv"', '["joints.csv", "seen.csv"]\njoin = "time"')
    clock = '[parts.late]\nkind = "clock"\nknown = "exactly"\nlag_ms = 0.0\n'
    path.write_text(text.replace("[joints]", 'clock = "late"\n[joints]') + clock)
    (sense,) = load(read_run_file(path)).senses
    at_end = np.abs(columns["joint_2"]) == 100
    beside = at_end[1:-2] | at_end[2:-1]
    assert sense.time.tolist() == (time[1:-2] + 0.5)[~beside].tolist() + (
        [] if at_end[-2] or at_end[-1] else [23.5]
    )
