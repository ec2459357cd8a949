"""Every kind of sense through calibrate, check, plan and report; outlines in test_together and
boards in test_board_senses.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import lie
from bodyschema.cli import run
from bodyschema.cli.loading import blank_senses, load
from bodyschema.cli.reading.sense_kinds import KINDS
from bodyschema.cli.run_file import read_run_file
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.sense import Sense
from bodyschema.sources.tables import write_table

Array = NDArray[np.float64]

HEAD = """
robot = "robot.urdf"
recording = "data.csv"
folds = 2
[free]
groups = ["offsets"]
joints = ["joint_2", "joint_3"]
[frames.eye]
parent = "base"
xyz = [0.1, 0.2, -1.5]
known = "exactly"
[frames.tool]
parent = "tip"
xyz = [0.02, 0.04, 0.05]
known = "exactly"
[parts.lens]
kind = "lens"
fx = 600.0
size = [640, 480]
known = "exactly"
[parts.held]
kind = "load"
mass_kg = 1.5
com_m = [0.02, 0.01, 0.05]
known = "exactly"
[[senses]]
kind = "{kind}"
seen_from = "{ends[0]}"
seen = "{ends[1]}"
"""
SEEN = ("eye", "tool")
LINES = {
    "points": (SEEN, 'columns = ["a0", "a1", "a2"]'),
    "poses": (SEEN, 'columns = ["a0", "a1", "a2", "a3", "a4", "a5"]\nlayout = "xyz_rotvec"'),
    "touches": (SEEN, 'columns = ["a0", "a1", "a2"]\ntouching = [0.0, 0.0, 0.03]'),
    "pixels": (SEEN, 'columns = ["a0", "a1"]\nlens = "lens"'),
    "distances": (SEEN, 'columns = ["a0"]'),
    "planes": (SEEN, 'columns = ["a0"]'),
    "gravity": (("tool", "base"), 'columns = ["a0", "a1", "a2"]'),
    "wrenches": (
        ("tool", "base"),
        'columns = ["a0", "a1", "a2", "a3", "a4", "a5"]\nsign = "on_object"\nloads = ["held"]',
    ),
    "torques": (
        ("base", "base"),
        'columns = ["a0", "a1", "a2", "a3"]\nloads = { link_4 = "held" }',
    ),
}
OFFSETS = np.deg2rad([2.0, -3.0])


def columns(sense: Sense, body: bs.Body, rng: np.random.Generator) -> dict[str, Array]:
    """What a sense would record of a body, with a tenth of its believed noise."""
    seen = sense.predict(body)
    if sense.observed.shape[1:] == (4, 4):
        seen = np.hstack([seen[:, :3, 3], lie.log_so3(seen[:, :3, :3])])
    noise = 0.1 * np.sqrt(np.diag(sense.covariance)) * rng.normal(size=seen.shape)
    return {f"a{i}": values for i, values in enumerate((seen + noise).T)}


def record(path: Path, folder: Path, body: bs.Body, true: bs.Body, n: int, seed: int) -> None:
    """A recording of a robot that is `true`, for the run file of a folder."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1, 1, (n, 4))
    asked = read_run_file(folder / "run.toml")
    # What touches is told with each sample, so that a batch without one has none.
    touches = asked.senses[0].kind == "touches"
    (blank,) = load(asked).senses if touches else blank_senses(asked, body)
    joints = {joint: q[:, j] for j, joint in enumerate(body.joints)}
    write_table(path, {**joints, **columns(blank.imagined(body, q), true, rng)})


@pytest.mark.parametrize("kind", sorted(LINES))
def test_a_kind_through_every_verb(
    kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ends, lines = LINES[kind]
    arm = bs.Body.random_chain(4, np.random.default_rng(11))
    (tmp_path / "robot.urdf").write_bytes(write_urdf(arm))
    text = HEAD.format(kind=kind, ends=ends) + lines
    (tmp_path / "run.toml").write_text(text)
    # The body of the run file, whose recording is still to be made.
    dummy = {joint: np.linspace(0, 1, 3) for joint in arm.joints}
    dummy |= {f"a{i}": np.ones(3) for i in range(6)}
    write_table(tmp_path / "data.csv", dummy)
    plain = text.replace(f'kind = "{kind}"', 'kind = "planes"').split("columns")[0]
    (tmp_path / "plain.toml").write_text(plain)
    body = load(read_run_file(tmp_path / "plain.toml")).body
    wrong = bs.free_joints(body, ["offsets"], ["joint_2", "joint_3"])
    true = body.with_variables(wrong, OFFSETS)
    record(tmp_path / "data.csv", tmp_path, body, true, 40, 1)

    out = str(tmp_path / "out")
    assert run(["calibrate", str(tmp_path / "run.toml"), "--out", out, "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["verdict"] == "calibrated"
    found = {entry["name"]: entry for entry in answer["parameters"]}
    for name, offset in zip(wrong.names, OFFSETS, strict=True):
        assert abs(found[name]["value"] - offset) < max(4 * found[name]["std"], 1e-6)

    record(tmp_path / "same.csv", tmp_path, body, true, 20, 2)
    knock = true.with_variables(bs.free_joints(true, ["offsets"], ["joint_3"]), [0.02])
    record(tmp_path / "knocked.csv", tmp_path, body, knock, 20, 3)
    for name, code in (("same", 0), ("knocked", 1)):
        check = ["check", out, "--recording", str(tmp_path / f"{name}.csv"), "--json"]
        assert run(check) == code, name
    capsys.readouterr()

    plan = ["plan", out, "-n", "2", "--candidates", "80", "--json"]
    assert run([*plan, "--out", str(tmp_path / "plan.csv")]) == 0
    assert len(json.loads(capsys.readouterr().out)["poses"]) == 2
    (tmp_path / "data.csv").unlink()
    assert run([*plan, "--out", str(tmp_path / "blind.csv")]) == 0
    assert "not read again" in json.loads(capsys.readouterr().out)["notes"][0]
    assert run(["report", out]) == 0
    assert "calibrated" in capsys.readouterr().out
    assert (tmp_path / "out" / "report.html").is_file()


def test_no_kind_is_left_out() -> None:
    assert {*LINES, "outlines", "board"} == {*KINDS}


def test_the_eye_sees_the_tool() -> None:
    """Else the pixels of this file would show nothing."""
    arm = bs.Body.random_chain(4, np.random.default_rng(11))
    eye, tool = np.eye(4), np.eye(4)
    eye[:3, 3], tool[:3, 3] = (0.1, 0.2, -1.5), (0.02, 0.04, 0.05)
    body = arm.attach("eye", "base", eye).attach("tool", "tip", tool)
    q = np.random.default_rng(1).uniform(-1, 1, (40, 4))
    assert (relative_pose(body, q, "eye", "tool")[:, 2, 3] > 0.3).all()
