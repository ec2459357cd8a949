"""kinematics.yaml: the corrected joint frames in a form that xacro files can load.

ROS descriptions such as ur_description keep the calibration of each robot apart from its shape:

    <xacro:property name="k" value="${load_yaml('kinematics.yaml')['kinematics']}"/>
    <origin xyz="${k['elbow']['x']} ${k['elbow']['y']} ${k['elbow']['z']}"
            rpy="${k['elbow']['roll']} ${k['elbow']['pitch']} ${k['elbow']['yaw']}"/>
    <axis xyz="${k['elbow']['axis']['x']} ${k['elbow']['axis']['y']} ${k['elbow']['axis']['z']}"/>
    <limit lower="${-1.5 - k['elbow']['offset']}" upper="${1.5 - k['elbow']['offset']}" .../>

Numbers are written in full, for programs.
"""

from __future__ import annotations

from typing import Any

from bodyschema import lie
from bodyschema.export.documents import yaml_text
from bodyschema.export.joint_edit import clean
from bodyschema.export.urdf_edits import baked_placements, node_offsets
from bodyschema.model.kernels import FIXED
from bodyschema.model.tree import Body

HEADING = """\
Joint frames of the corrected robot, written by bodyschema; m and rad, rpy about fixed axes.
Load it in xacro: ${load_yaml('kinematics.yaml')['kinematics']['JOINT']['roll']}
offset: already inside roll pitch yaw (x y z for prismatic joints); subtract it from the limits."""


def kinematics_text(body: Body) -> str:
    """kinematics.yaml of a body; see `kinematics_document`."""
    return yaml_text(kinematics_document(body), HEADING)


def kinematics_document(body: Body) -> dict[str, Any]:
    """{"kinematics": {joint: {x, y, z, roll, pitch, yaw}}} with the offsets inside.

    Moving joints also have their `axis` {x, y, z} in the joint frame, and the `offset` (rad or m)
    by which their zero has moved.

    Args:
        body: all its joints are listed, fixed ones too, in the order of the tree.
    """
    placements, offsets = baked_placements(body), node_offsets(body)
    joints: dict[str, Any] = {}
    for k in range(1, len(body.frames)):
        rpy = lie.rpy_from_rotation(placements[k, :3, :3])
        entry: dict[str, Any] = _named("xyz", placements[k, :3, 3])
        entry |= _named(("roll", "pitch", "yaw"), rpy)
        if body.kind[k] != FIXED:
            entry["axis"] = _named("xyz", body.axis[k])
            entry["offset"] = clean(float(offsets[k]))
        joints[body.carriers[k]] = entry
    return {"kinematics": joints}


def _named(names: Any, values: Any) -> dict[str, float]:
    return {name: clean(float(value)) for name, value in zip(names, values, strict=True)}
