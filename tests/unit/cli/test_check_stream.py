"""`check` over a recording with times: when, what, how sure; and the old keys are still there."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import Body
from bodyschema.cli import run
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.kinematics import relative_pose
from bodyschema.sources.tables import write_table
from recorded_arm import RUN

Array = NDArray[np.float64]

ARM = Body.random_chain(4, np.random.default_rng(3))
BEGIN = 50.0


def record(path: Path, q: Array, zeros: Array, clock: bool, rng: np.random.Generator) -> None:
    """What is recorded of the arm at readings q, its zeros being (n, 4) rad off."""
    body = ARM.attach("tracker", "base").attach("marker", "tip")
    seen = relative_pose(body, q + zeros, "tracker", "marker")[:, :3, 3]
    seen += 1e-3 * rng.normal(size=seen.shape)
    columns = dict(zip([*ARM.joints, *"xyz"], np.hstack([q, seen]).T, strict=True))
    time = {"time": BEGIN + np.arange(len(q)) / 30} if clock else {}
    write_table(path, {**time, **columns})


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A calibrated arm, and two streams of it: as it is, and with a slip at row 300."""
    here, rng = tmp_path_factory.mktemp("watched"), np.random.default_rng(0)
    (here / "robot.urdf").write_bytes(write_urdf(ARM))
    (here / "run.toml").write_text(RUN)
    record(here / "data.csv", rng.uniform(-1.5, 1.5, (40, 4)), np.zeros((40, 4)), False, rng)
    # The robot is right as it is: that its zeros were estimated all the same is what is asked for.
    asked = ["calibrate", str(here / "run.toml"), "--out", str(here / "result"), "--json"]
    assert run([*asked, "--force"]) == 0
    t = np.arange(600)[:, None] / 30
    q = 1.3 * np.sin(2 * np.pi * t * [0.23, 0.31, 0.41, 0.53] + [0, 1, 2, 3])
    slip = (np.arange(600) >= 300)[:, None] * np.deg2rad([0.0, 0.0, 1.0, 0.0])
    record(here / "true.csv", q, np.zeros_like(q), True, rng)
    record(here / "slipped.csv", q, slip, True, rng)
    return here


def test_a_stream_of_the_same_robot(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    arguments = ["check", str(folder / "result"), "--recording", str(folder / "true.csv")]
    assert run([*arguments, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["verdict"] == "still true"
    assert answer["changes"] == []
    assert answer["watched_s"] == pytest.approx(599 / 30)


def test_a_slip_is_dated(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    arguments = ["check", str(folder / "result"), "--recording", str(folder / "slipped.csv")]
    assert run([*arguments, "--json"]) == 1
    answer = json.loads(capsys.readouterr().out)
    (change,) = answer["changes"]
    joint = ARM.joints[2]
    assert change["part"] == joint
    assert abs(change["row"] - 300) <= 3
    assert abs(change["time_s"] - (BEGIN + 10)) <= 0.1
    off = change["change"][f"{joint}.offset"] - np.deg2rad(1.0)
    assert abs(off) < 3 * change["std"][f"{joint}.offset"]
    assert {"verdict", "changed", "p_value", "suspects", "position_rms_mm", "rows"} <= set(answer)
    assert answer["suspects"][0]["part"] == joint
    assert run(arguments) == 1
    text = capsys.readouterr().out
    assert text.startswith(f"changed at {change['time_s']:.2f} s (row {change['row']}, noticed")
    assert f"{joint}: offset +" in text


def test_a_few_postures_are_not_watched(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    arguments = ["check", str(folder / "result"), "--recording", str(folder / "data.csv")]
    assert run([*arguments, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["watched_s"] is None
    assert answer["changes"] == []
