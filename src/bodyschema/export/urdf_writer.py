"""A plain URDF of a body that did not come from one: a table, an MJCF, several robots.

Links with their visible shapes, joints, origins, axes, limits and mimics; joint offsets are inside
the origins. A body knows neither efforts nor velocities, which a URDF must state: they are written
as zero, so that nothing moves until somebody fills them in. Where a URDF needs a limit and the body
has none, UNLIMITED is written. Moving joints come first, in the order of the columns of q, which
readers keep.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.export.joint_edit import clean
from bodyschema.export.urdf_edits import baked_placements
from bodyschema.model.kernels import FIXED, PRISMATIC
from bodyschema.model.tree import Body, Visual

Array = NDArray[np.float64]

UNLIMITED = 1e3
"""rad or m, written for an end that has no limit."""

REMARK = " written by bodyschema; effort and velocity are not known and must be filled in "


def write_urdf(body: Body) -> bytes:
    """The body as a URDF file; read again, it has the same poses at the same readings.

    Args:
        body: gear errors are left out, see `urdf_edits.unwritable`.
    """
    robot = ET.Element("robot", name=body.name)
    robot.append(ET.Comment(REMARK))
    for frame in body.frames:
        link = ET.SubElement(robot, "link", name=frame)
        for visual in body.visuals:
            if visual.frame == frame:
                _add_visual(link, visual)
    placements = baked_placements(body)
    nodes = sorted(range(1, len(body.frames)), key=lambda k: _column(body, k))
    for k in nodes:
        _add_joint(robot, body, k, placements[k])
    ET.indent(robot)
    return bytes(ET.tostring(robot, encoding="utf-8", xml_declaration=True)) + b"\n"


def _leads(body: Body, k: int) -> bool:
    """Whether the joint that carries frame k has a column of q."""
    return bool(body.driver[k] >= 0) and body.joints[body.driver[k]] == body.carriers[k]


def _column(body: Body, k: int) -> int:
    return int(body.driver[k]) if _leads(body, k) else len(body.joints)


def _add_joint(robot: ET.Element, body: Body, k: int, T_parent_joint: Array) -> None:
    low, high = _limits(body, k)
    endless = not np.isfinite(low) and not np.isfinite(high)
    kind = "fixed" if body.kind[k] == FIXED else "continuous" if endless else "revolute"
    kind = "prismatic" if body.kind[k] == PRISMATIC else kind
    joint = ET.SubElement(robot, "joint", name=body.carriers[k], type=kind)
    rpy = lie.rpy_from_rotation(T_parent_joint[:3, :3])
    ET.SubElement(joint, "parent", link=body.frames[body.parent[k]])
    ET.SubElement(joint, "child", link=body.frames[k])
    ET.SubElement(joint, "origin", xyz=_text(T_parent_joint[:3, 3]), rpy=_text(rpy))
    if kind == "fixed":
        return
    ET.SubElement(joint, "axis", xyz=_text(body.axis[k]))
    if kind != "continuous":
        ends = {"lower": _text([max(low, -UNLIMITED)]), "upper": _text([min(high, UNLIMITED)])}
        ET.SubElement(joint, "limit", {**ends, "effort": "0", "velocity": "0"})
    if not _leads(body, k):
        leader = body.joints[body.driver[k]]
        rate, shift = _text([body.rate[k]]), _text([body.shift[k]])
        ET.SubElement(joint, "mimic", joint=leader, multiplier=rate, offset=shift)


def _add_visual(link: ET.Element, visual: Visual) -> None:
    element = ET.SubElement(link, "visual")
    T, sizes = visual.placement, [_text([size]) for size in visual.size]
    rpy = lie.rpy_from_rotation(T[:3, :3])
    ET.SubElement(element, "origin", xyz=_text(T[:3, 3]), rpy=_text(rpy))
    keys = {
        "mesh": {"filename": visual.mesh, "scale": " ".join(sizes)},
        "box": {"size": " ".join(sizes)},
        "cylinder": dict(zip(("radius", "length"), sizes, strict=False)),
        "sphere": {"radius": sizes[0]},
    }
    ET.SubElement(ET.SubElement(element, "geometry"), visual.shape, keys[visual.shape])


def _limits(body: Body, k: int) -> tuple[float, float]:
    """Of the joint that carries frame k, in readings."""
    j = body.driver[k]
    if j < 0:
        return 0.0, 0.0
    ends = np.array([body.lower[j], body.upper[j]])
    # A joint that mimics with rate zero stands still, wherever its leader goes.
    reached = body.shift[k] + (body.rate[k] * ends if body.rate[k] else np.zeros(2))
    return float(reached.min()), float(reached.max())


def _text(numbers: Iterable[float]) -> str:
    return " ".join(repr(clean(float(number))) for number in numbers)
