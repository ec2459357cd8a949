"""Corrections in the user's own MJCF: the same poses in MuJoCo, and no other byte."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.export.mjcf_edits import edited_mjcf
from bodyschema.judging.places import FramePlace
from bodyschema.model.kinematics import frame_poses
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_joints

mujoco = pytest.importorskip("mujoco")

Array = NDArray[np.float64]

ARM = """<mujoco model="arm">
  <compiler angle="degree"/> <!-- degrees -->
  <default><joint damping="1"/></default>
  <worldbody>
    <body name="upper" pos="0.1 0.2 0.3" euler='5 -10 20'>
      <joint name="yaw" axis="0 0 1" ref="20" range="-90 90"/>
      <geom size="0.1"/>
      <body name="fore" pos="0.4 0 0">
        <joint
            name="pitch" axis="0 2 0" pos="0 0.05 0.1"/>
        <geom size="0.1"/>
        <body name="sled"><joint name="slide" type="slide" axis="1 0 1" ref="0.1" pos="0.3 0 0"/>
          <geom size="0.1"/><site name="tool" pos="0 0 0.1"/></body>
      </body>
    </body>
  </worldbody>
  <equality><joint name="yaw" joint1="slide" joint2="yaw" active="false"/></equality>
</mujoco>
"""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    file = tmp_path / "arm.xml"
    file.write_text(ARM)
    return file


def moved(nominal: Body, groups: list[str], seed: int = 0) -> Body:
    free = free_joints(nominal, groups)
    x = np.random.default_rng(seed).uniform(-0.1, 0.1, len(free))
    return nominal.with_variables(free, x)


def poses_of(model: object, q: Array, names: tuple[str, ...]) -> Array:
    data = mujoco.MjData(model)
    found = np.tile(np.eye(4), (len(q), len(names), 1, 1))
    for i, values in enumerate(q):
        data.qpos[:] = values
        mujoco.mj_kinematics(model, data)
        for k, name in enumerate(names):
            site = name in ("tool", "marker")
            row = data.site(name) if site else data.body(name)
            found[i, k, :3, 3] = row.xpos
            found[i, k, :3, :3] = row.xmat.reshape(3, 3)
    return found


@pytest.mark.parametrize("groups", [["offsets"], ["offsets", "axes", "links"], ["axes"]])
def test_mujoco_has_the_corrected_poses(path: Path, groups: list[str]) -> None:
    nominal = Body.from_file(path)
    corrected = moved(nominal, groups)
    text, changed = edited_mjcf(path, nominal, corrected)
    assert changed == ["pitch", "slide", "yaw"]
    model = mujoco.MjModel.from_xml_string(text.decode())
    q = np.random.default_rng(1).uniform(-1, 1, (10, 3))
    names = ("upper", "fore", "sled", "tool")
    expected = frame_poses(corrected, q)[:, [corrected.frame_index(n) for n in names]]
    assert np.abs(poses_of(model, q, names) - expected).max() < 4e-15


def test_zeros_are_ref_and_nothing_else_changes(path: Path) -> None:
    nominal = Body.from_file(path)
    free = free_joints(nominal, ["offsets"])
    corrected = nominal.with_variables(free, [np.deg2rad(3.0), 0.0, 0.02])
    text, changed = edited_mjcf(path, nominal, corrected)
    assert changed == ["slide", "yaw"]
    expected = ARM.replace('ref="20"', 'ref="17.0"').replace('ref="0.1"', 'ref="0.08"')
    assert text.decode() == expected
    corrected = nominal.with_variables(free, [0.0, 0.1, 0.0])
    text, _ = edited_mjcf(path, nominal, corrected)
    (degrees,) = [w for w in text.decode().split() if w.startswith('ref="-5.7')]
    assert float(degrees.split('"')[1]) == pytest.approx(-np.rad2deg(0.1), abs=1e-12)
    assert edited_mjcf(path, nominal, nominal) == (ARM.encode(), [])


def test_frames_are_sites(path: Path) -> None:
    nominal = Body.from_file(path)
    T = lie.transform(lie.rotation_from_rpy([0.1, 0.2, 0.3]), [0.1, 0.2, 0.3])
    place = FramePlace("fore", "marker", T, np.zeros(6), 0.0, 0.0)
    text, _ = edited_mjcf(path, nominal, nominal, [place])
    model = mujoco.MjModel.from_xml_string(text.decode())
    q = np.array([[0.3, 0.2, 0.1]])
    fore, marker = poses_of(model, q, ("fore", "marker"))[0]
    assert marker == pytest.approx(fore @ T, abs=1e-15)
    twice = path.with_name("twice.xml")
    twice.write_bytes(text)
    with pytest.raises(InputError, match="has a site 'marker' already"):
        edited_mjcf(twice, nominal, nominal, [place])


def test_a_corrected_fixed_frame(path: Path) -> None:
    nominal = Body.from_file(path)
    T = lie.transform(lie.rotation_from_rpy([0.1, 0.2, 0.3]), [0.1, 0.2, 0.3])
    text, _ = edited_mjcf(path, nominal, nominal.with_placement("tool", T))
    again = path.with_name("again.xml")
    again.write_bytes(text)
    body = Body.from_file(again)
    assert body.placement[body.frame_index("tool")] == pytest.approx(T, abs=1e-15)


def test_meshes_and_inclusions_are_found_from_elsewhere(tmp_path: Path) -> None:
    (tmp_path / "here" / "assets").mkdir(parents=True)
    (tmp_path / "there").mkdir()
    obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    (tmp_path / "here" / "assets" / "m.obj").write_text(obj)
    more = '<mujoco><asset><mesh name="m" file="{}m.obj"/></asset></mujoco>'
    body = (
        '<worldbody><body name="b"><joint name="j"/><geom type="mesh" mesh="m"/></body></worldbody>'
    )
    for compiler, folder in (('<compiler meshdir="assets"/>', ""), ("", "assets/")):
        (tmp_path / "here" / "more.xml").write_text(more.format(folder))
        path = tmp_path / "here" / "arm.xml"
        path.write_text(f'<mujoco>{compiler}<include file="more.xml"/>{body}</mujoco>')
        nominal = Body.from_file(path)
        corrected = nominal.with_variables(free_joints(nominal, ["offsets"]), [0.1])
        text, _ = edited_mjcf(path, nominal, corrected, elsewhere=True)
        (tmp_path / "there" / "arm.xml").write_bytes(text)
        again = Body.from_file(tmp_path / "there" / "arm.xml")
        assert again.remarks == ()
        assert again.visuals[0].mesh == nominal.visuals[0].mesh


def test_what_has_no_place_is_refused(path: Path) -> None:
    path.write_text(ARM.replace('ref="20" range="-90 90"/>', '/><joint name="roll" axis="1 0 0"/>'))
    nominal = Body.from_file(path)
    _, changed = edited_mjcf(path, nominal, moved(nominal, ["offsets"]))
    assert "roll" in changed
    with pytest.raises(InputError, match="its body has several joints"):
        edited_mjcf(path, nominal, moved(nominal, ["axes"]))
    framed = ARM.replace('<body name="fore"', '<frame><body name="fore"', 1)
    path.write_text(framed.replace("</body>\n    </body>", "</body></frame>\n    </body>", 1))
    nominal = Body.from_file(path)
    with pytest.raises(InputError, match="stands in a <frame>"):
        edited_mjcf(path, nominal, moved(nominal, ["links"]))
    path.write_text(ARM.replace('name="pitch"', ""))
    nominal = Body.from_file(path)
    with pytest.raises(InputError, match="has no name"):
        edited_mjcf(path, nominal, moved(nominal, ["offsets"]))
