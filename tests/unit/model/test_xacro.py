"""Reading xacro without ROS: expansion, packages, and what cannot be expanded."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.model import xacro_process
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body

XACRO = """<?xml version="1.0"?>
<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:property name="reach" value="${0.1 * 3}"/>
  <xacro:macro name="segment" params="parent child">
    <link name="${child}"/>
    <joint name="${child}_joint" type="revolute">
      <parent link="${parent}"/><child link="${child}"/>
      <origin xyz="0 0 ${reach}" rpy="0 0 ${pi / 2}"/>
      <axis xyz="0 1 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
    </joint>
  </xacro:macro>
  <link name="base"/>
  <xacro:segment parent="base" child="upper"/>
  <xacro:segment parent="upper" child="lower"/>
</robot>
"""


def test_xacro_is_expanded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "arm.urdf.xacro"
    path.write_text(XACRO)
    with monkeypatch.context() as patch:
        patch.setitem(sys.modules, "xacrodoc", None)
        with pytest.raises(MissingExtraError, match=r"pip install 'bodyschema\[xacro\]'"):
            Body.from_urdf(path)
    pytest.importorskip("xacrodoc")
    body = Body.from_urdf(path)
    assert body.frames == ("base", "upper", "lower")
    assert body.joints == ("upper_joint", "lower_joint")
    tip = relative_pose(body, [0.0, 0.0], "base", "lower")
    assert tip[:3, 3] == pytest.approx([0, 0, 0.6])
    assert tip[:3, :3] == pytest.approx(np.diag([-1.0, -1.0, 1.0]), abs=1e-15)
    assert body.lower.tolist() == [-1, -1]


def test_xacro_packages_are_given_or_refused(tmp_path: Path) -> None:
    pytest.importorskip("xacrodoc")
    path, parts = tmp_path / "arm.xacro", tmp_path / "elsewhere"
    parts.mkdir()
    (parts / "link.xacro").write_text(
        '<robot><link name="base"><visual><geometry><mesh filename="package://lost/a.stl"/>'
        "</geometry></visual></link></robot>"
    )
    path.write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:include filename="$(find bodyschema_parts)/link.xacro"/></robot>'
    )
    with pytest.raises(InputError, match=r"no xacro that can be .* not found: bodyschema_parts"):
        Body.from_urdf(path)
    body = Body.from_urdf(path, packages={"bodyschema_parts": parts})
    assert body.frames == ("base",)
    assert body.visuals[0].mesh == "package://lost/a.stl"
    path.write_text(XACRO.replace("0.1 * 3", "reech"))
    with pytest.raises(InputError, match=r"name 'reech' is not defined"):
        Body.from_urdf(path)


def test_arguments_of_xacro(tmp_path: Path) -> None:
    """With and without a default; numbers as words; a commented one asks for nothing."""
    pytest.importorskip("xacrodoc")
    path = tmp_path / "arm.xacro"
    path.write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'
        '<xacro:arg name="reach"/><xacro:arg name="side" default="0.2"/>'
        '<!-- <xacro:arg name="gone"/> --><link name="base"/><link name="hand"/>'
        '<joint name="j" type="fixed"><parent link="base"/><child link="hand"/>'
        '<origin xyz="$(arg side) 0 $(arg reach)"/></joint></robot>'
    )
    assert Body.from_urdf(path, arguments={"reach": 0.3}).placement[1, :3, 3].tolist() == [
        0.2, 0, 0.3,
    ]  # fmt: skip
    body = Body.from_urdf(path, arguments={"reach": "0.3", "side": "0.1"})
    assert body.placement[1, :3, 3].tolist() == [0.1, 0, 0.3]
    assert body.arguments == {"reach": "0.3", "side": "0.1"}
    with pytest.raises(InputError, match=r"needs the xacro argument 'reach'; .*robot_arguments"):
        Body.from_urdf(path)
    path.write_text(path.read_text().replace("$(arg side)", "$(arg dof)"))
    with pytest.raises(InputError, match=r"needs the xacro argument 'dof'"):
        Body.from_urdf(path, arguments={"reach": 0.3})


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("${'a' * 10**11}", "when evaluating expression"),
        ("${__import__('os').system('touch PWNED')}", "is no xacro that can be expanded: ."),
    ],
)
def test_programs_in_a_xacro_file_do_no_harm(tmp_path: Path, name: str, message: str) -> None:
    path = tmp_path / "a.xacro"
    path.write_text(
        f'<robot name="a" xmlns:xacro="http://ros.org/wiki/xacro"><link name="{name}"/></robot>'
    )
    with pytest.raises(InputError, match=message):
        Body.from_urdf(path)
    assert not Path("PWNED").exists()


def test_a_xacro_file_that_never_ends(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(xacro_process, "SECONDS", 1.0)
    path = tmp_path / "a.xacro"
    path.write_text(
        '<robot name="a" xmlns:xacro="http://ros.org/wiki/xacro"><link name="${9**9**9}"/></robot>'
    )
    with pytest.raises(InputError, match="it takes more than 1 s"):
        Body.from_urdf(path)
