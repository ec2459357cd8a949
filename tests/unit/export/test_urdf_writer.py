"""A URDF written anew: read again, it is the same body."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model.dh import DHRow, body_from_dh
from bodyschema.model.tree import Body
from bodyschema.model.urdf import parse_urdf
from bodyschema.model.variables import free_joints

Difference = Callable[[Body, Body], float]


def again(body: Body) -> Body:
    return parse_urdf(write_urdf(body), Path("again.urdf"), {})


def arm() -> Body:
    """A DH arm with a rail, limits on one side, and offsets."""
    rows = [
        DHRow("rail", d=0.3, type="prismatic", limits=(-np.inf, 0.5)),
        DHRow("waist", a=0.4, alpha=np.pi / 2, theta=0.2, limits=(-1.0, 2.0)),
        DHRow("wrist & hand", a=0.1, alpha=-0.3, d=0.05),
    ]
    body = body_from_dh(rows, "standard", tool=(0.0, 0.0, 0.1), name='a "DH" arm')
    return replace(body, offset=np.array([0.01, 0.25, -0.4]))


def test_a_dh_arm_comes_back(worst_pose: Difference) -> None:
    body = arm()
    back = again(body)
    assert (back.name, back.frames, back.joints) == (body.name, body.frames, body.joints)
    assert worst_pose(back, body) < 1e-12
    assert not back.offset.any()
    assert back.lower == pytest.approx([-1000.0, -1.0, -np.inf])
    assert back.upper == pytest.approx([0.5, 2.0, np.inf])


def test_random_chain_with_everything_wrong(worst_pose: Difference) -> None:
    rng = np.random.default_rng(1)
    body = Body.random_chain(7, rng)
    free = free_joints(body, ["offsets", "axes", "links"])
    moved = body.with_variables(free, rng.uniform(-0.3, 0.3, len(free)))
    assert worst_pose(again(moved), moved) < 1e-12


def test_mimics_and_their_limits_come_back(robot: bytes, worst_pose: Difference) -> None:
    body = parse_urdf(robot, Path("robot.urdf"), {})
    moved = replace(body, offset=np.array([0.1, 0.2, 0.3, 0.01]))
    back = again(moved)
    assert back.joints == body.joints
    assert worst_pose(back, moved) < 1e-12
    limit = ET.fromstring(write_urdf(moved)).find("joint[@name='finger_r']/limit")
    assert limit is not None
    # 0 .. 0.04 of the leader's readings, at -2 times these plus 0.003.
    assert (limit.get("lower"), limit.get("upper")) == ("-0.077", "0.003")


def test_the_columns_of_q_keep_their_order() -> None:
    body = replace(
        arm(), joints=("wrist & hand", "rail", "waist"), driver=np.array([-1, 1, 2, 0, -1])
    )
    assert again(body).joints == ("wrist & hand", "rail", "waist")


def test_the_text_is_what_a_person_would_write() -> None:
    body = body_from_dh([DHRow("turn", d=0.3, limits=(-1.0, 1.0))], name="post")
    assert write_urdf(body).decode() == (
        "<?xml version='1.0' encoding='utf-8'?>\n"
        '<robot name="post">\n'
        "  <!-- written by bodyschema; effort and velocity are not known and must be filled in -->"
        '\n  <link name="base" />\n'
        '  <link name="link_1" />\n'
        '  <link name="flange" />\n'
        '  <joint name="turn" type="revolute">\n'
        '    <parent link="base" />\n'
        '    <child link="link_1" />\n'
        '    <origin xyz="0.0 0.0 0.3" rpy="0.0 0.0 0.0" />\n'
        '    <axis xyz="0.0 0.0 1.0" />\n'
        '    <limit lower="-1.0" upper="1.0" effort="0" velocity="0" />\n'
        "  </joint>\n"
        '  <joint name="flange_joint" type="fixed">\n'
        '    <parent link="link_1" />\n'
        '    <child link="flange" />\n'
        '    <origin xyz="0.0 0.0 0.0" rpy="0.0 0.0 0.0" />\n'
        "  </joint>\n"
        "</robot>\n"
    )
