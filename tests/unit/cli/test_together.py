"""Points, masks and wrenches of one arm in one run file, each from a recording of its own."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import lie
from bodyschema.cli import run
from bodyschema.model import parts
from bodyschema.model.inertia import Inertia
from bodyschema.senses.wrist_wrenches import WristWrenches
from bodyschema.sources.tables import write_table
from bodyschema.vision.contours import silhouette
from bodyschema.vision.poses import piece_poses

cv2 = pytest.importorskip("cv2")
pytest.importorskip("trimesh")

Array = NDArray[np.float64]

LINK = """<link name="{name}"><visual><origin xyz="0 0 {z}"/>
<geometry><box size="{size}"/></geometry></visual></link>"""
JOINT = """<joint name="{name}" type="revolute"><parent link="{up}"/><child link="{down}"/>
<origin xyz="0 0 {z}"/><axis xyz="{axis}"/><limit lower="-2" upper="2" effort="1" velocity="1"/>
</joint>"""
ROBOT = "\n".join(
    [
        '<robot name="boxes"><link name="base"/>',
        LINK.format(name="upper", z=0.15, size="0.06 0.09 0.3"),
        LINK.format(name="fore", z=0.1, size="0.05 0.03 0.2"),
        LINK.format(name="hand", z=0.03, size="0.05 0.05 0.06"),
        JOINT.format(name="lift", up="base", down="upper", z=0, axis="0 1 0"),
        JOINT.format(name="bend", up="upper", down="fore", z=0.3, axis="0 1 0"),
        JOINT.format(name="roll", up="fore", down="hand", z=0.2, axis="0 0 1"),
        "</robot>",
    ]
)
RUN = """
robot = "arm.urdf"
time = ""
folds = 3

[frames.tracker]
parent = "base"
xyz = [-1.0, 0.5, 0.8]
[frames.marker]
parent = "hand"
xyz = [0.04, 0.0, 0.05]
known = "roughly"
[frames.camera]
parent = "base"
xyz = [0.0, 1.2, 0.2]
rpy = [1.5707963267948966, 0.0, 0.0]
known = "roughly"
[frames.sensor]
parent = "hand"
xyz = [0.0, 0.0, 0.06]
known = "exactly"

[parts.lens]
kind = "lens"
fx = 300.0
size = [320, 240]
known = "exactly"
[parts.held]
kind = "load"
known = "no"
[parts.cell]
kind = "sensor"
channels = "force"
free = ["offset"]

[[senses]]
kind = "points"
recording = "tracker.csv"
seen_from = "tracker"
seen = "marker"
columns = ["x", "y", "z"]
unit = "mm"
std = 2.0

[[senses]]
kind = "outlines"
recording = "pictures.csv"
seen_from = "camera"
lens = "lens"
masks = "mask_{row}.png"

[[senses]]
kind = "wrenches"
recording = "wrist.csv"
seen_from = "sensor"
seen = "base"
columns = ["fx", "fy", "fz", "tx", "ty", "tz"]
sign = "on_sensor"
torque_unit = "Nmm"
loads = ["held"]
sensor = "cell"
std = [0.05, 2.0]

[free]
groups = ["offsets"]
"""
OFFSETS = np.deg2rad([3.0, -4.0, 5.0])
HELD = Inertia(0.5, np.array([0.04, -0.02, 0.05]), np.diag([2e-3, 2e-3, 1e-3]))


def true_arm(folder: Path) -> bs.Body:
    """The arm as it is, with all frames and parts."""
    body = bs.Body.from_urdf(folder / "arm.urdf")
    body = body.attach("tracker", "base", lie.transform(lie.exp_so3([0.4, 1, 0.2]), [-1, 0.4, 0.9]))
    eye = lie.transform(lie.rotation_from_rpy([np.pi / 2, 0.01, 0.0]), [0.01, 1.21, 0.2])
    body = body.attach("camera", "base", eye)
    body = body.attach("marker", "hand", lie.transform(np.eye(3), [0.045, 0.003, 0.05]))
    body = body.attach("sensor", "hand", lie.transform(np.eye(3), [0.0, 0.0, 0.06]))
    bias = np.array([3.0, -2.0, 1.0, 0.2, -0.1, 0.3, *np.zeros(6)])
    sensor = bs.Part("sensor", parts.force_sensor().names, ("1",) * 12, bias, np.ones(12))
    body = body.with_part("held", parts.load(HELD)).with_part("cell", sensor)
    return body.with_variables(bs.free_joints(body, ["offsets"]), OFFSETS)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The robot, three recordings, and the pictures of one of them."""
    here, rng = tmp_path_factory.mktemp("together"), np.random.default_rng(3)
    (here / "arm.urdf").write_text(ROBOT)
    (here / "run.toml").write_text(RUN)
    body = true_arm(here)
    few, views, held = (rng.uniform(-0.9, 0.9, (n, 3)) for n in (15, 6, 20))
    seen = bs.Points.make(few, np.zeros((15, 3)), "tracker", "marker").predict(body)
    seen = 1e3 * seen + 2.0 * rng.normal(size=seen.shape)
    record(here / "tracker.csv", few, dict(zip("xyz", seen.T, strict=True)))
    record(here / "pictures.csv", views, {})
    lens = np.array([[300, 0, 159.5], [0, 300, 119.5], [0, 0, 1]])
    camera, surface = bs.Camera("camera", "camera", 320, 240, lens), bs.Surface.of(body)
    for i, pose in enumerate(piece_poses(body, views, [camera], surface.frames)[:, 0]):
        mask = silhouette(surface, pose, camera).astype(np.uint8) * 255
        cv2.imwrite(str(here / f"mask_{i}.png"), mask)
    wrist = WristWrenches.make(
        held, np.zeros((20, 6)), "sensor", "base", loads=("held",), sensor="cell"
    )
    felt = wrist.predict(body) + rng.normal(size=(20, 6)) * np.repeat([0.05, 2e-3], 3)
    names = ("fx", "fy", "fz", "tx", "ty", "tz")
    pull = -felt * np.repeat([1.0, 1e3], 3)
    record(here / "wrist.csv", held, dict(zip(names, pull.T, strict=True)))
    return here


def record(path: Path, q: Array, columns: dict[str, Array]) -> None:
    joints = {name: q[:, j] for j, name in enumerate(("lift", "bend", "roll"))}
    write_table(path, {**joints, **columns})


@pytest.fixture(scope="module")
def answer(folder: Path) -> dict[str, Any]:
    """What calibrate prints of all of them."""
    out = ["--out", str(folder / "out"), "--json"]
    with pytest.MonkeyPatch.context() as patched:
        lines: list[str] = []
        patched.setattr("builtins.print", lambda *words, **_: lines.append(" ".join(words)))
        assert run(["calibrate", str(folder / "run.toml"), *out]) == 0
    found = json.loads(lines[-1])
    assert isinstance(found, dict)
    return found


def test_all_senses_tell_all_zeros(answer: dict[str, Any]) -> None:
    kept = ("verdict", "nominal", "held_out", "unidentifiable", "parameters", "outliers", "seconds")
    assert {*kept} <= {*answer}
    assert answer["verdict"] == "calibrated"
    found = {entry["name"]: entry for entry in answer["parameters"]}
    for name, true in zip(("lift", "bend", "roll"), OFFSETS, strict=True):
        entry = found[f"{name}.offset"]
        assert abs(entry["value"] - true) < 4 * entry["std"]
        assert entry["std"] < np.deg2rad(0.4)
    assert answer["held_out"]["position_mm"]["rms"] < 8
    assert not answer["outliers"]


def test_the_load_and_the_rows_are_told(answer: dict[str, Any], folder: Path) -> None:
    (load,) = answer["loads"]
    assert load["mass"] == pytest.approx(0.5, abs=0.02)
    assert answer["first_rows"] == {
        "'tracker.csv'": 0,
        "'pictures.csv'": 15,
        "'wrist.csv'": 21,
    }
    record_ = json.loads((folder / "out" / "run.json").read_text())
    hashed = {Path(name).name for name in record_["sha256"]}
    assert {"arm.urdf", "tracker.csv", "pictures.csv", "wrist.csv", "mask_5.png"} <= hashed


def test_check_plan_and_report_take_the_folder(
    answer: dict[str, Any], folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = str(folder / "out")
    assert run(["report", out]) == 0
    capsys.readouterr()
    check = ["check", out, "--json", "--recording"]
    assert run([*check, str(folder / "tracker.csv")]) == 2
    assert "recording of their own; give a run file" in capsys.readouterr().err
    assert run([*check, str(folder / "run.toml")]) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == "still true"
    plan = ["plan", out, "-n", "2", "--out", str(tmp_path / "plan.csv"), "--candidates", "60"]
    assert run(plan) == 0
    assert (tmp_path / "plan.csv").is_file()
