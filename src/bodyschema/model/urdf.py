"""Reading a URDF (or xacro) into a Body: links, joints, limits, mimics and visible shapes.

Writing back is `bodyschema.export.urdf_patch`, which changes the user's own file byte by byte.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from pathlib import Path
from xml.parsers import expat

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.documents import file_bytes
from bodyschema.errors import InputError, did_you_mean
from bodyschema.model.kernels import FIXED, PRISMATIC, REVOLUTE
from bodyschema.model.meshes import Packages, resolve_mesh
from bodyschema.model.tree import Body, Visual
from bodyschema.model.urdf_xacro import expanded
from bodyschema.model.urdf_xml import xml_root
from bodyschema.model.urdf_zeros import stated_zeros

Array = NDArray[np.float64]

KINDS = {
    "revolute": REVOLUTE,
    "continuous": REVOLUTE,
    "prismatic": PRISMATIC,
    "fixed": FIXED,
    "floating": FIXED,
    "planar": FIXED,
}
MOST_LINKS = 10_000
"""Of one robot: the largest that are known have three hundred."""

HELD = ("floating", "planar")
"""Joints that no encoder reads: they are held at their origins, and the body says so."""


def read_urdf(path: Path, packages: Packages, arguments: Mapping[str, str] | None = None) -> Body:
    """Read a robot description.

    Args:
        path: a .urdf file, or a .xacro file (needs the extra `xacro`).
        packages: folder of each ROS package that meshes name by package://.
        arguments: of a xacro file, by name.

    Raises:
        InputError: the file is missing, is no URDF, or describes no tree.
    """
    return parse_urdf(urdf_text(path, packages, arguments), path, packages)


def is_text(description: object) -> bool:
    """Whether this is the text of a URDF and not the name of a file."""
    return isinstance(description, str) and "<robot" in description


def body_of_text(text: str, packages: Packages) -> Body:
    """The body of a URDF that is no file, such as what /robot_description holds.

    Words before it, such as "String value is:" of `ros2 param get`, are passed over.

    Raises:
        InputError: it is no URDF, or describes no tree.
    """
    return parse_urdf(text[text.index("<") :].encode(), Path("robot_description"), packages)


def urdf_text(path: Path, packages: Packages, arguments: Mapping[str, str] | None = None) -> bytes:
    """The URDF as bytes, xacro expanded with its arguments."""
    text = file_bytes(path, f"no robot description at '{path}'; give the path of a URDF file.")
    if path.suffix != ".xacro":
        # Saved from `ros2 param get`, it begins with words.
        said = text.find(b"<")
        return text[said:] if text[: max(said, 0)].rstrip().endswith(b":") else text
    return expanded(path, packages, arguments or {})


def parse_urdf(text: bytes, path: Path, packages: Packages) -> Body:
    """The body described by the text; `path` names it in messages and anchors mesh paths."""
    try:
        robot = xml_root(text)
    except (expat.ExpatError, LookupError, ValueError) as error:  # the XML, or its encoding
        raise InputError(f"'{path}' is not well-formed XML: {error}.") from None
    if robot.tag != "robot":
        hint = " Body.from_mjcf reads it." if robot.tag == "mujoco" else ""
        raise InputError(f"'{path}' is no URDF: its root is <{robot.tag}>, expected <robot>.{hint}")
    joints, links = _by_name(robot, "joint", path), list(_by_name(robot, "link", path))
    if len(links) > MOST_LINKS:
        raise InputError(f"'{path}' has {len(links)} links; at most {MOST_LINKS} are read.")
    order = _sorted_joints(joints, links, path)
    movers = [name for name, joint in joints.items() if KINDS[_kind(joint)] != FIXED]
    followers = [name for name in movers if joints[name].find("mimic") is not None]
    mimics = {name: _mimic(joints[name], movers, path) for name in followers}
    mimics = {name: _leader(name, mimics, path) for name in mimics}
    frames = [order[0], *(_child(joints[name]) for name in order[1:])]
    place = {frame: k for k, frame in enumerate(frames)}
    return Body.build(
        name=robot.get("name", path.stem),
        frames=frames,
        carriers=["", *order[1:]],
        parent=[-1, *(place[_parent(joints[name])] for name in order[1:])],
        kind=[FIXED, *(KINDS[_kind(joints[name])] for name in order[1:])],
        axis=[[0.0, 0.0, 1.0], *(_axis(joints[name], path) for name in order[1:])],
        placement=[np.eye(4), *(_origin(joints[name], path) for name in order[1:])],
        limits={name: _limits(joints[name], path) for name in movers},
        mimics=mimics,
        joints=[name for name in movers if name not in mimics],
        visuals=_visuals(robot, path, packages),
        remarks=[_held(name, joints[name]) for name in order[1:] if _kind(joints[name]) in HELD],
        stated_zeros=stated_zeros(robot),
    )


def _held(name: str, joint: ET.Element) -> str:
    """What to know of a joint without an encoder."""
    return (
        f"Joint '{name}' is {_kind(joint)} and has no encoder, so '{_child(joint)}' was held at "
        f"its origin on '{_parent(joint)}'; if it moved during the recording, see it from a frame "
        "on the robot's side of that joint."
    )


def _kind(joint: ET.Element) -> str:
    return joint.get("type", "")


def _by_name(robot: ET.Element, tag: str, path: Path) -> dict[str, ET.Element]:
    """The robot's links or joints, each with a name of its own."""
    found: dict[str, ET.Element] = {}
    for element in robot.findall(tag):
        name = element.get("name")
        if not name:
            raise InputError(f"'{path}' has a <{tag}> without a name.")
        if name in found:
            raise InputError(f"'{path}' has two {tag}s named '{name}'; rename one.")
        found[name] = element
    return found


def _parent(joint: ET.Element) -> str:
    element = joint.find("parent")
    return "" if element is None else element.get("link", "")


def _child(joint: ET.Element) -> str:
    element = joint.find("child")
    return "" if element is None else element.get("link", "")


def _sorted_joints(joints: Mapping[str, ET.Element], links: Sequence[str], path: Path) -> list[str]:
    """The root link, then the joints so that parents come before children."""
    below: dict[str, list[str]] = {link: [] for link in links}
    children = set()
    for name, joint in joints.items():
        if joint.get("type") not in KINDS:
            raise InputError(
                f"joint '{name}' in '{path}' is of type '{joint.get('type')}'; "
                f"expected one of {', '.join(KINDS)}."
            )
        for link in (_parent(joint), _child(joint)):
            if link not in below:
                raise InputError(f"joint '{name}' names link '{link}'{did_you_mean(link, links)}")
        if _child(joint) in children:
            raise InputError(f"link '{_child(joint)}' has two parents; a body must be a tree.")
        children.add(_child(joint))
        below[_parent(joint)].append(name)
    roots = [link for link in links if link not in children]
    if len(roots) != 1:
        raise InputError(f"'{path}' must have one root link, it has {len(roots)}: {roots[:5]}.")
    order: list[str] = []
    waiting = list(reversed(below[roots[0]]))
    while waiting:
        name = waiting.pop()
        order.append(name)
        waiting += reversed(below[_child(joints[name])])
    if len(order) != len(joints):
        lost = sorted(set(joints) - set(order))
        raise InputError(f"joints {lost[:5]} in '{path}' form a loop apart from the root.")
    return [roots[0], *order]


def _numbers(text: str | None, count: int, what: str, path: Path) -> list[float]:
    try:
        values = [float(word) for word in (text or "").split()]
    except ValueError:
        values = []
    if len(values) != count or not all(math.isfinite(value) for value in values):
        raise InputError(f"{what} in '{path}' should be {count} numbers, it is '{text}'.")
    return values


def _origin(element: ET.Element, path: Path) -> Array:
    """T_parent_child of an <origin>, identity where there is none."""
    origin = element.find("origin")
    if origin is None:
        return np.eye(4)
    what = f"<origin> of '{element.get('name', element.tag)}'"
    xyz = _numbers(origin.get("xyz", "0 0 0"), 3, what, path)
    rpy = _numbers(origin.get("rpy", "0 0 0"), 3, what, path)
    return lie.transform(lie.rotation_from_rpy(rpy), xyz)


def _axis(joint: ET.Element, path: Path) -> list[float]:
    element = joint.find("axis")
    text = "1 0 0" if element is None else element.get("xyz", "1 0 0")
    axis = np.array(_numbers(text, 3, f"<axis> of '{joint.get('name')}'", path))
    length = np.linalg.norm(axis)
    if length < 1e-9:
        if KINDS[_kind(joint)] == FIXED:
            return [1.0, 0.0, 0.0]
        raise InputError(f"<axis> of joint '{joint.get('name')}' in '{path}' has no length.")
    return [float(value) for value in axis / length]


def _limits(joint: ET.Element, path: Path) -> tuple[float, float]:
    limit = joint.find("limit")
    if limit is None or joint.get("type") == "continuous":
        return -np.inf, np.inf
    what = f"<limit> of '{joint.get('name')}'"
    low = _numbers(limit.get("lower", "0"), 1, what, path)[0]
    high = _numbers(limit.get("upper", "0"), 1, what, path)[0]
    return low, high


def _mimic(joint: ET.Element, movers: Sequence[str], path: Path) -> tuple[str, float, float]:
    """(joint followed, multiplier, offset)."""
    name, element = joint.get("name"), joint.find("mimic")
    given = {} if element is None else element.attrib
    leader = given.get("joint", "")
    if leader not in movers:
        known = did_you_mean(leader, movers)
        raise InputError(f"joint '{name}' mimics '{leader}', which is no moving joint{known}")
    rate = _numbers(given.get("multiplier", "1"), 1, f"<mimic> of '{name}'", path)
    shift = _numbers(given.get("offset", "0"), 1, f"<mimic> of '{name}'", path)
    return leader, rate[0], shift[0]


def _leader(
    name: str, mimics: Mapping[str, tuple[str, float, float]], path: Path
) -> tuple[str, float, float]:
    """Follow a chain of mimics to the joint that is not one itself."""
    leader, rate, shift = mimics[name]
    for _ in mimics:
        if leader not in mimics:
            return leader, rate, shift
        above, above_rate, above_shift = mimics[leader]
        leader, rate, shift = above, rate * above_rate, rate * above_shift + shift
    raise InputError(f"joint '{name}' in '{path}' mimics itself through others.")


def _visuals(robot: ET.Element, path: Path, packages: Packages) -> list[Visual]:
    found = []
    for link in robot.findall("link"):
        for visual in link.findall("visual"):
            geometry = visual.find("geometry")
            for shape in [] if geometry is None else list(geometry):
                made = _visual(link.get("name", ""), _origin(visual, path), shape, path, packages)
                found += [made] if made else []
    return found


def _visual(
    frame: str, placement: Array, shape: ET.Element, path: Path, packages: Packages
) -> Visual | None:
    what = f"<{shape.tag}> of link '{frame}'"
    if shape.tag == "mesh":
        scale = tuple(_numbers(shape.get("scale", "1 1 1"), 3, what, path))
        mesh = resolve_mesh(shape.get("filename", ""), path, packages)
        return Visual(frame, placement, "mesh", scale, mesh)
    keys = {"box": ["size"], "cylinder": ["radius", "length"], "sphere": ["radius"]}.get(shape.tag)
    if keys is None:
        return None
    words = " ".join(shape.get(key, "") for key in keys)
    size = _numbers(words, 3 if shape.tag == "box" else len(keys), what, path)
    return Visual(frame, placement, shape.tag, tuple(size))
