"""MJCF against MuJoCo's own kinematics: several joints a body, points off the origin, `ref`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.model.kinematics import frame_poses
from bodyschema.model.meshes import triangles_of
from bodyschema.model.tree import Body

mujoco = pytest.importorskip("mujoco")

Array = NDArray[np.float64]

ARM = """
<mujoco model="arm">
  <compiler angle="degree"/>
  <worldbody>
    <camera name="eye" pos="1 0 1" euler="10 20 30"/>
    <body name="base" pos="0 0 0.3" euler="5 -10 20">
      <geom type="box" size="0.1 0.2 0.3" pos="0 0 0.05"/>
      <body name="upper" pos="0.1 0.2 0.3" quat="0.9 0.1 0.3 -0.2">
        <joint name="yaw" axis="0 0 1" ref="20" range="-90 90"/>
        <joint name="pitch" axis="0 1 1" pos="0 0.05 0.1" ref="-35" range="-100 80"/>
        <geom type="sphere" size="0.1"/>
        <body name="fore" pos="0.4 0 0">
          <joint name="slide" type="slide" axis="1 0 1" ref="0.1" pos="0.3 0 0" range="-1 1"/>
          <geom type="cylinder" size="0.05 0.2" contype="0" conaffinity="0"/>
          <geom type="box" size="1 1 1"/>
          <site name="tool" pos="0 0 0.1" euler="0 90 0"/>
          <body name="finger" pos="0 0 0.2">
            <joint name="grip" axis="1 0 0"/>
            <geom size="0.02"/>
          </body>
          <body name="thumb" pos="0 0.1 0.2">
            <joint name="thumb" axis="1 0 0" ref="10"/>
            <geom type="capsule" size="0.02 0.1"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <equality><joint joint1="thumb" joint2="grip" polycoef="0.1 -2 0 0 0"/></equality>
</mujoco>
"""


def read(tmp_path: Path, text: str = ARM) -> tuple[Body, Any]:
    path = tmp_path / "arm.xml"
    path.write_text(text)
    return Body.from_file(path), mujoco.MjModel.from_xml_path(str(path))


def pose(data: Any, kind: str, row: int) -> Array:
    T = np.eye(4)
    places = {"body": ("xpos", "xmat"), "site": ("site_xpos", "site_xmat")}
    at, turn = (getattr(data, name)[row] for name in places[kind])
    T[:3, :3], T[:3, 3] = turn.reshape(3, 3), at
    return T


def worst(body: Body, model: Any, q: Array) -> float:
    """Largest difference of any number of any pose of a body or site that both have, (n, k) q."""
    data, apart = mujoco.MjData(model), 0.0
    poses = frame_poses(body, q)
    for values, T in zip(q, poses, strict=True):
        data.qpos[:] = model.qpos0
        for name, value in zip(body.joints, values, strict=True):
            data.joint(name).qpos[0] = value
        for k in np.flatnonzero(body.driver >= 0):
            if body.carriers[k] not in body.joints:
                leader = values[body.driver[k]]
                data.joint(body.carriers[k]).qpos[0] = body.rate[k] * leader + body.shift[k]
        mujoco.mj_kinematics(model, data)
        for kind, count in (("body", model.nbody), ("site", model.nsite)):
            for row in range(1 if kind == "body" else 0, count):
                name = getattr(model, kind)(row).name
                difference = T[body.frame_index(name)] - pose(data, kind, row)
                apart = max(apart, float(np.abs(difference).max()))
    return apart


def test_kinematics_are_those_of_mujoco(tmp_path: Path) -> None:
    body, model = read(tmp_path)
    assert body.name == "arm"
    assert body.joints == ("yaw", "pitch", "slide", "grip")
    assert body.lower[:3] == pytest.approx([*np.deg2rad([-90, -100]), -1])
    assert body.upper[3] == np.inf
    q = np.random.default_rng(1).uniform(-1.5, 1.5, (20, 4))
    assert worst(body, model, q) < 2e-15


def test_an_equality_is_a_mimic_as_mujoco_has_it(tmp_path: Path) -> None:
    body, model = read(tmp_path)
    data = mujoco.MjData(model)
    data.joint("grip").qpos[0] = 0.3
    thumb = body.carriers.index("thumb")
    data.joint("thumb").qpos[0] = body.rate[thumb] * 0.3 + body.shift[thumb]
    mujoco.mj_forward(model, data)
    assert data.efc_pos[0] == pytest.approx(0, abs=1e-15)


def test_cameras_look_along_z(tmp_path: Path) -> None:
    body, model = read(tmp_path)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    eye = frame_poses(body, np.zeros(4))[body.frame_index("eye")]
    assert eye[:3, 2] == pytest.approx(-data.cam_xmat[0].reshape(3, 3)[:, 2])
    assert eye[:3, 1] == pytest.approx(-data.cam_xmat[0].reshape(3, 3)[:, 1])


def test_shapes(tmp_path: Path) -> None:
    """Of a body with shapes that collide with nothing those alone; a capsule has no form."""
    body, _ = read(tmp_path)
    assert [(v.frame, v.shape, v.size) for v in body.visuals] == [
        ("base", "box", (0.2, 0.4, 0.6)),
        ("upper", "sphere", (0.1,)),
        ("fore", "cylinder", (0.05, 0.4)),
        ("finger", "sphere", (0.02,)),
    ]


MESH = """
<mujoco><compiler meshdir="assets"/>
  <asset><mesh name="m" file="m.obj" scale="2 3 4"/></asset>
  <worldbody><body name="b" euler="0 0 40"><joint name="j"/>
    <geom type="mesh" mesh="m" pos="1 2 3" euler="10 20 30"/></body></worldbody></mujoco>
"""


def test_meshes_lie_where_mujoco_has_them(tmp_path: Path) -> None:
    (tmp_path / "assets").mkdir()
    corners = ("0 0 0", "1 0 0", "0 1 0", "0 0 1")
    faces = ("1 3 2", "1 2 4", "1 4 3", "2 3 4")
    obj = "".join([*(f"v {v}\n" for v in corners), *(f"f {f}\n" for f in faces)])
    (tmp_path / "assets" / "m.obj").write_text(obj)
    body, model = read(tmp_path, MESH)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    expected = model.mesh_vert @ data.geom_xmat[0].reshape(3, 3).T + data.geom_xpos[0]
    vertices, _ = triangles_of(body.visuals[0])
    T = frame_poses(body, np.zeros(1))[body.frame_index("b")]
    mine = vertices @ T[:3, :3].T + T[:3, 3]
    apart = np.linalg.norm(mine[:, None] - expected[None], axis=2).min(axis=1)
    assert apart.max() < 1e-6  # MuJoCo keeps vertices in single precision


def test_meshes_may_be_missing(tmp_path: Path) -> None:
    path = tmp_path / "arm.xml"
    path.write_text(MESH)
    body = Body.from_mjcf(path)
    assert body.joints == ("j",)
    (remark,) = body.remarks
    assert "without its shapes" in remark


def test_what_no_encoder_reads_is_held(tmp_path: Path) -> None:
    text = """<mujoco><worldbody><body name="torso" pos="0 0 1"><freejoint name="root"/>
    <geom size="0.1"/><body name="head" pos="0 0 0.2"><joint name="neck" type="ball"/>
    <joint name="nod" axis="0 1 0"/><geom size="0.1"/></body></body></worldbody></mujoco>"""
    path = tmp_path / "robot.xml"
    path.write_text(text.replace('<joint name="nod" axis="0 1 0"/>', ""))
    body = Body.from_mjcf(path)
    assert body.joints == ()
    assert [remark[:20] for remark in body.remarks] == [
        "Joint 'root' is free",
        "Joint 'neck' is ball",
    ]
    assert frame_poses(body, np.zeros(0))[-1][:3, 3] == pytest.approx([0, 0, 1.2])


def test_a_curved_equality_is_a_joint_of_its_own(tmp_path: Path) -> None:
    body, _ = read(tmp_path, ARM.replace("0.1 -2 0 0 0", "0.1 -2 0.3 0 0"))
    assert body.joints[-1] == "thumb"
    assert any("no line" in remark for remark in body.remarks)


def test_names_that_are_missing_or_used_twice(tmp_path: Path) -> None:
    text = ARM.replace('name="tool"', 'name="fore"').replace('<joint name="yaw"', "<joint")
    body, _ = read(tmp_path, text)
    assert "joint_1" in body.joints
    assert "fore_site" in body.frames


def test_what_is_no_mjcf_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "arm.xml"
    with pytest.raises(InputError, match="no robot description at"):
        Body.from_mjcf(path)
    path.write_text("<mujoco><worldbdy/></mujoco>")
    with pytest.raises(InputError, match=r"is no MJCF that MuJoCo compiles: .*worldbdy"):
        Body.from_file(path)
    path.write_text(ARM)
    with pytest.raises(InputError, match=r"root is <mujoco>.*Body\.from_mjcf reads it"):
        Body.from_urdf(path)


def test_without_mujoco(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "arm.xml"
    path.write_text(ARM)
    monkeypatch.setitem(__import__("sys").modules, "mujoco", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'bodyschema\[sim\]'"):
        Body.from_file(path)
