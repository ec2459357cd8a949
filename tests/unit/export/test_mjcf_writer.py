"""Bodies as MJCF: MuJoCo loads them with the same poses, and they come back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.export.mjcf_writer import write_mjcf
from bodyschema.export.urdf_inertials import urdf_inertials
from bodyschema.model.kinematics import frame_poses
from bodyschema.model.tree import Body
from bodyschema.model.urdf import parse_urdf
from bodyschema.model.variables import free_joints

mujoco = pytest.importorskip("mujoco")

Array = NDArray[np.float64]


def apart(body: Body, path: Path, n: int = 20) -> float:
    """Largest difference of any number of any pose of a frame between a body and MuJoCo."""
    model = mujoco.MjModel.from_xml_path(str(path))
    data, worst = mujoco.MjData(model), 0.0
    q = np.random.default_rng(0).uniform(-2, 2, (n, len(body.joints)))
    for values, poses in zip(q, frame_poses(body, q), strict=True):
        for k in np.flatnonzero(body.driver >= 0):
            value = body.rate[k] * values[body.driver[k]] + body.shift[k]
            data.joint(body.carriers[k]).qpos[0] = value
        mujoco.mj_kinematics(model, data)
        for frame, T in zip(body.frames, poses, strict=True):
            row = data.body(frame)
            worst = max(worst, np.abs(T[:3, 3] - row.xpos).max())
            worst = max(worst, np.abs(T[:3, :3] - row.xmat.reshape(3, 3)).max())
    return float(worst)


def test_a_urdf_with_everything(robot: bytes, tmp_path: Path) -> None:
    """Rails, mimics of mimics, an endless joint; the readings' poses are those of the body."""
    nominal = parse_urdf(robot, Path("arm.urdf"), {})
    free = free_joints(nominal, ["offsets", "axes", "links"])
    x = np.random.default_rng(2).uniform(-0.1, 0.1, len(free))
    corrected = nominal.with_variables(free, x)
    path = tmp_path / "robot.xml"
    path.write_bytes(write_mjcf(corrected))
    # Joint offsets are inside the placements: what MuJoCo is given are readings.
    assert apart(corrected, path) < 2e-14
    again = Body.from_file(path)
    q = np.random.default_rng(1).uniform(-1, 1, (5, len(again.joints)))
    columns = [again.joints.index(joint) for joint in corrected.joints]
    rows = [again.frame_index(frame) for frame in corrected.frames]
    there = frame_poses(corrected, q[:, columns])
    assert np.abs(frame_poses(again, q)[:, rows] - there).max() < 2e-14
    bounded = np.isfinite(corrected.upper)
    mine = [again.upper[again.joint_index(joint)] for joint in corrected.joints]
    assert np.array(mine)[bounded] == pytest.approx(corrected.upper[bounded])


HEAVY = """<robot name="r"><link name="world"/><link name="arm"><inertial>
<origin xyz="0.1 0.2 0.3" rpy="0.3 0.2 0.1"/><mass value="2.5"/>
<inertia ixx="0.02" ixy="0.001" ixz="-0.002" iyy="0.03" iyz="0.003" izz="0.015"/></inertial>
<visual><origin xyz="0 0 0.5"/><geometry><box size="0.1 0.2 0.3"/></geometry></visual>
<visual><geometry><cylinder radius="0.1" length="0.4"/></geometry></visual></link>
<link name="hand"><inertial><mass value="1"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0"
izz="0"/></inertial><visual><geometry><mesh filename="none.stl"/></geometry></visual></link>
<joint name="j" type="revolute"><parent link="world"/><child link="arm"/><axis xyz="0 0 1"/>
<limit lower="0" upper="0"/></joint>
<joint name="k" type="continuous"><parent link="arm"/><child link="hand"/></joint></robot>"""


def test_masses_shapes_and_limits_of_no_width(tmp_path: Path) -> None:
    body, path = Body.from_urdf(HEAVY), tmp_path / "r.xml"
    path.write_bytes(write_mjcf(body, urdf_inertials(HEAVY.encode())))
    model = mujoco.MjModel.from_xml_path(str(path))
    assert model.body("arm").mass[0] == 2.5
    assert model.body("arm").ipos == pytest.approx([0.1, 0.2, 0.3])
    own = np.array([[0.02, 0.001, -0.002], [0.001, 0.03, 0.003], [-0.002, 0.003, 0.015]])
    assert np.sort(model.body("arm").inertia) == pytest.approx(np.linalg.eigvalsh(own))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    turned = data.ximat[model.body("arm").id].reshape(3, 3)
    from bodyschema import lie

    R = lie.rotation_from_rpy([0.3, 0.2, 0.1])
    expected = R @ own @ R.T
    assert turned @ np.diag(model.body("arm").inertia) @ turned.T == pytest.approx(expected)
    assert model.ngeom == 2
    assert [(v.shape, v.size) for v in Body.from_file(path).visuals] == [
        ("box", (0.1, 0.2, 0.3)),
        ("cylinder", (0.1, 0.4)),
    ]
    assert not model.jnt_limited.any()
    mujoco.mj_step(model, data)


def test_a_bare_chain(tmp_path: Path) -> None:
    body = Body.random_chain(7, np.random.default_rng(3))
    path = tmp_path / "chain.xml"
    path.write_bytes(write_mjcf(body))
    assert apart(body, path) < 2e-15
