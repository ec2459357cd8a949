"""The keys of ur_description, against the body: its macro written out again, without xacro."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from bodyschema import lie
from bodyschema.export.ur_kinematics import LINKS, ur_kinematics_text
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.urdf import parse_urdf
from bodyschema.model.variables import free_joints

UR30 = """kinematics:
  shoulder: {x: 0, y: 0, z: 0.2363, roll: -0, pitch: 0, yaw: -0}
  upper_arm: {x: 0, y: 0, z: 0, roll: 1.570796327, pitch: 0, yaw: -0}
  forearm: {x: -0.637, y: 0, z: 0, roll: -0, pitch: 0, yaw: -0}
  wrist_1: {x: -0.5037, y: 0, z: 0.201, roll: -0, pitch: 0, yaw: -0}
  wrist_2: {x: 0, y: -0.1593, z: 0, roll: 1.570796327, pitch: 0, yaw: -0}
  wrist_3: {x: 0, y: 0.1543, z: -3.16e-11, roll: 1.5707963265, pitch: 3.14159265, yaw: 3.14159265}
  hash: calib_4890363623803256388
"""
"""config/ur30/default_kinematics.yaml of Universal_Robots_ROS2_Description."""

JOINTS = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")


def ur_description(text: str, prefix: str = "") -> Body:
    """The chain of urdf/ur_macro.xacro for a file of kinematics: every axis is z."""
    kinematics = yaml.safe_load(text)["kinematics"]
    assert kinematics["hash"].startswith("calib_")
    joints, links, above = [], ["base_link", "base_link_inertia"], "base_link_inertia"
    joints.append(("base_link-base_link_inertia", "fixed", "base_link", above, "0 0 0", "0 0 3.14"))
    for key, joint in zip(LINKS, JOINTS, strict=True):
        k = kinematics[key]
        xyz, rpy = f"{k['x']} {k['y']} {k['z']}", f"{k['roll']} {k['pitch']} {k['yaw']}"
        joints.append((f"{joint}_joint", "revolute", above, f"{key}_link", xyz, rpy))
        above = f"{key}_link"
        links.append(above)
    joints.append(("wrist_3-flange", "fixed", above, "flange", "0 0 0", "0 -1.57 -1.57"))
    robot = "".join(f'<link name="{prefix}{link}"/>' for link in [*links, "flange"])
    for name, kind, parent, child, xyz, rpy in joints:
        robot += (
            f'<joint name="{prefix}{name}" type="{kind}"><parent link="{prefix}{parent}"/>'
            f'<child link="{prefix}{child}"/><origin xyz="{xyz}" rpy="{rpy}"/><axis xyz="0 0 1"/>'
            '<limit lower="-6" upper="6"/></joint>'
        )
    return parse_urdf(f'<robot name="ur">{robot}</robot>'.encode(), Path("ur.urdf"), {})


@pytest.mark.parametrize("prefix", ["", "left_"])
def test_what_was_read_is_written(prefix: str) -> None:
    body = ur_description(UR30, prefix)
    before, after = (yaml.safe_load(t)["kinematics"] for t in (UR30, ur_kinematics_text(body)))
    assert {*after} == {*before}
    q = np.random.default_rng(0).uniform(-3, 3, (5, 6))
    again = ur_description(ur_kinematics_text(body), prefix)
    one, other = (relative_pose(b, q, b.frames[0], f"{prefix}flange") for b in (body, again))
    assert np.abs(one - other).max() < 2e-15


@pytest.mark.parametrize("groups", [["offsets"], ["offsets", "links"]])
def test_the_corrected_arm_is_loaded_whole(groups: list[str]) -> None:
    nominal = ur_description(UR30)
    free = free_joints(nominal, groups)
    x = np.random.default_rng(1).uniform(-0.02, 0.02, len(free))
    corrected = nominal.with_variables(free, x)
    text = ur_kinematics_text(corrected)
    assert "rpy=" not in text
    again = ur_description(text)
    q = np.random.default_rng(0).uniform(-3, 3, (5, 6))
    one, other = (relative_pose(b, q, "base_link", "flange") for b in (corrected, again))
    assert np.abs(one - other).max() < 4e-15


def test_the_rest_of_a_last_axis_is_said() -> None:
    nominal = ur_description(UR30)
    free = free_joints(nominal, ["offsets", "axes", "links"])
    x = np.random.default_rng(1).uniform(-0.02, 0.02, len(free))
    corrected = nominal.with_variables(free, x)
    text = ur_kinematics_text(corrected)
    rpy = [float(word) for word in text.split('rpy="')[1].split('"')[0].split()]
    again = ur_description(text)
    rest = lie.transform(lie.rotation_from_rpy(rpy), np.zeros(3))
    q = np.random.default_rng(0).uniform(-3, 3, (5, 6))
    wanted = relative_pose(corrected, q, "base_link", "wrist_3_link")
    found = relative_pose(again, q, "base_link", "wrist_3_link") @ rest
    assert np.abs(wanted - found).max() < 1e-9
    assert np.abs(rest - np.eye(4)).max() > 1e-3


def test_other_arms_have_none() -> None:
    assert ur_kinematics_text(Body.random_chain(6, np.random.default_rng(0))) == ""
    older = parse_urdf(
        b'<robot name="r"><link name="base_link_inertia"/></robot>', Path("r.urdf"), {}
    )
    assert ur_kinematics_text(older) == ""
