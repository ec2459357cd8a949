"""The recorded arm of the cases, described in other forms than a URDF: the same zeros."""

from __future__ import annotations

import json
import math
import sysconfig
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from bodyschema.cli import run
from bodyschema.export.mjcf_writer import write_mjcf
from bodyschema.export.urdf_inertials import urdf_inertials
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.kinematics import frame_poses, relative_pose
from bodyschema.model.tree import Body

Folder = Callable[[str], Path]
ZEROS = {"j2": 2.0, "j3": -3.0, "j4": 1.5, "j5": -2.5}
"""deg, of the arm in the cases; j1 and j6 go along with board and camera."""

RUN = """
robot = "{robot}"
recording = "{data}"
[frames.board]
parent = "base"
[frames.camera]
parent = "{flange}"
[[senses]]
kind = "poses"
seen_from = "board"
seen = "camera"
layout = "xyz_xyzw"
unit = "mm"
columns = ["x","y","z","qx","qy","qz","qw"]
"""


def calibrated(folder: Path, robot: str, flange: str, data: Path) -> Path:
    """The result of a run file in a folder."""
    (folder / "run.toml").write_text(RUN.format(robot=robot, flange=flange, data=data))
    assert run(["calibrate", str(folder / "run.toml"), "--out", str(folder / "out")]) == 0
    return folder / "out"


@pytest.fixture
def arm(shared_data: Folder) -> Path:
    """Its URDF; the cases lie beside the data."""
    return shared_data("ur5_artag_handeye").parents[1] / "cases" / "common" / "arm.urdf"


def assert_zeros(out: Path) -> None:
    answer = json.loads((out / "answer.json").read_text())
    assert answer["verdict"] == "calibrated"
    nominal = Body.from_file(json.loads((out / "run.json").read_text())["robot"])
    robot = Body.from_file(out / "robot.urdf")
    # Zeros are inside the placements: what is left of one is how far a link is turned.
    for joint, degrees in ZEROS.items():
        k = nominal.carriers.index(joint)
        frame = nominal.frames[k]
        R = nominal.placement[k, :3, :3].T @ robot.placement[robot.frame_index(frame), :3, :3]
        turned = math.degrees(math.acos(min(1.0, (np.trace(R) - 1) / 2)))
        assert turned == pytest.approx(abs(degrees), abs=0.1), joint


def test_an_mjcf(arm: Path, tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    (tmp_path / "arm.xml").write_bytes(write_mjcf(Body.from_urdf(arm)))
    out = calibrated(tmp_path, "arm.xml", "flange", arm.parents[1] / "D_millimetres" / "data.csv")
    assert_zeros(out)
    model = mujoco.MjModel.from_xml_path(str(out / "robot.xml"))
    data, robot = mujoco.MjData(model), Body.from_file(out / "robot.urdf")
    for q in np.random.default_rng(0).uniform(-1, 1, (5, 6)):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        T = relative_pose(robot, q, "base", "flange")
        assert data.body("flange").xpos == pytest.approx(T[:3, 3], abs=1e-14)
    changed = [
        one != other
        for one, other in zip(
            (tmp_path / "arm.xml").read_text().splitlines(),
            (out / "robot.xml").read_text().splitlines(),
            strict=True,
        )
    ]
    assert sum(changed) == len(ZEROS)


def test_an_arm_in_a_cell(arm: Path, tmp_path: Path) -> None:
    """On a pedestal that is another robot description."""
    pedestal = '<robot name="p"><link name="floor"/></robot>'
    (tmp_path / "pedestal.urdf").write_text(pedestal)
    cell = f"""[[robot]]
description = "pedestal.urdf"
[[robot]]
description = "{arm}"
parent = "floor"
xyz = [0.0, 0.0, 0.8]
"""
    (tmp_path / "cell.toml").write_text(cell)
    out = calibrated(tmp_path, "cell.toml", "flange", arm.parents[1] / "D_millimetres" / "data.csv")
    assert_zeros(out)


EXAMPLES = Path(sysconfig.get_path("purelib"), "cmeel.prefix/share/example-robot-data/robots")
ROBOTS = ("panda", "tiago", "allegro_right_hand", "ur5_robot", "hyq_no_sensors")


@pytest.mark.parametrize("name", ROBOTS)
def test_to_mjcf_and_back(name: str, tmp_path: Path) -> None:
    """URDF to MJCF to MuJoCo, to a Body, to a URDF: all 67 that are read stay within 4e-15."""
    mujoco = pytest.importorskip("mujoco")
    found = sorted(EXAMPLES.rglob(f"{name}.urdf"))
    if not found:
        pytest.skip("example-robot-data is not installed")
    body = Body.from_urdf(found[0])
    (tmp_path / "robot.xml").write_bytes(write_mjcf(body, urdf_inertials(found[0].read_bytes())))
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    data = mujoco.MjData(model)
    again = Body.from_file(tmp_path / "robot.xml")
    (tmp_path / "robot.urdf").write_bytes(write_urdf(again))
    third = Body.from_urdf(tmp_path / "robot.urdf")
    q = np.random.default_rng(0).uniform(-1, 1, (3, len(body.joints)))
    poses = frame_poses(body, q)
    for other in (again, third):
        columns = [body.joint_index(joint) for joint in other.joints]
        rows = [other.frame_index(frame) for frame in body.frames]
        assert np.abs(frame_poses(other, q[:, columns])[:, rows] - poses).max() < 4e-15
    for values, T in zip(q, poses, strict=True):
        for k in np.flatnonzero(body.driver >= 0):
            value = body.rate[k] * values[body.driver[k]] + body.shift[k]
            data.joint(body.carriers[k]).qpos[0] = value
        mujoco.mj_kinematics(model, data)
        there = np.array([data.body(frame).xpos for frame in body.frames])
        assert np.abs(T[:, :3, 3] - there).max() < 4e-15


def test_a_camera_that_the_description_has(arm: Path, tmp_path: Path) -> None:
    """Its mount, 10 mm and 0.1 rad off, is corrected in place, by export too."""
    mount = '<origin xyz="0.03 -0.05 0.07" rpy="0.1 0 0.4"/>'
    joint = (
        '<joint name="mount" type="fixed"><parent link="flange"/><child link="camera"/>{}</joint>'
    )
    added = f'<link name="camera"/>{joint.format(mount)}</robot>'
    (tmp_path / "arm.urdf").write_text(arm.read_text().replace("</robot>", added))
    data = arm.parents[1] / "D_millimetres" / "data.csv"
    known = 'parent = "flange"\nknown = "roughly"'
    text = RUN.replace('parent = "{flange}"', known).format(robot="arm.urdf", data=data)
    (tmp_path / "run.toml").write_text(text)
    out, again = tmp_path / "out", tmp_path / "again.urdf"
    assert run(["calibrate", str(tmp_path / "run.toml"), "--out", str(out)]) == 0
    body = Body.from_urdf(out / "robot.urdf")
    T = body.placement[body.frame_index("camera")]
    assert T[:3, 3] == pytest.approx([0.03, -0.05, 0.06], abs=5e-4)
    assert not (out / "transforms.yaml").read_text().count("child: camera")
    urdf = str(tmp_path / "arm.urdf")
    assert run(["export", str(out), "--robot", urdf, "--out", str(again)]) == 0
    assert again.read_bytes() == (out / "robot.urdf").read_bytes()
