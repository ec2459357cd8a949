"""A small arm of boxes before a camera, for tests of `bodyschema track`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import bodyschema as bs

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
        JOINT.format(name="lift", up="base", down="upper", z=0, axis="0 1 0"),
        JOINT.format(name="bend", up="upper", down="fore", z=0.3, axis="0 1 0"),
        "</robot>",
    ]
)
TRACK = """
robot = "arm.urdf"
recording = "joints.csv"
hand = "fore"
[free]
joints = ["lift", "bend"]
[cameras.eye]
parent = "base"
xyz = [0.0, 1.2, 0.2]
rpy = [1.5707963267948966, 0.0, 0.0]
size = [320, 240]
lens = [300.0, 300.0, 159.5, 119.5]
images = "image_{row:03}.png"
masks = "mask_{row:03}.png"
"""
WRONG = np.deg2rad([4, -6])
"""Offsets of lift and bend, rad."""

POSTURES = np.array([[-0.5, 0.9], [0.1, 0.5], [0.6, -1.0], [0.3, 1.2]])
"""Encoder readings, rad."""

CAMERA = bs.Camera("eye", "eye", 320, 240, np.array([[300, 0, 159.5], [0, 300, 119.5], [0, 0, 1]]))


def write_arm(folder: Path) -> bs.Body:
    """Write arm.urdf; returns the body with its eye."""
    (folder / "arm.urdf").write_text(ROBOT)
    T = np.array([[1, 0, 0, 0], [0, 0, -1, 1.2], [0, 1, 0, 0.2], [0, 0, 0, 1.0]])
    return bs.Body.from_urdf(folder / "arm.urdf").attach("eye", "base", T)
