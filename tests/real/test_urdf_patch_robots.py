"""The URDF patch on real robots: one line changes, and in it only what was asked."""

from __future__ import annotations

import difflib
import sysconfig
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

import pytest

from bodyschema.export.urdf_patch import JointEdit, patch_urdf

EXAMPLES = Path(sysconfig.get_path("purelib"), "cmeel.prefix", "share", "example-robot-data")
EXAMPLE_FILES = sorted(EXAMPLES.rglob("*.urdf"))
SHIFT = 0.00125
"""A plausible correction, metres and rad."""


def parse(source: bytes) -> ET.Element:
    """Parse with an XML reader that the patch does not use, comments included."""
    return ET.fromstring(source, ET.XMLParser(target=ET.TreeBuilder(insert_comments=True)))


def origin_numbers(joint: ET.Element, attribute: str) -> tuple[float, ...]:
    """Read xyz (metres) or rpy (rad) of a joint; what is not written is zero."""
    origin = joint.find("origin")
    text = "0 0 0" if origin is None else origin.get(attribute, "0 0 0")
    return tuple(float(word) for word in text.split())


def without_origin(root: ET.Element, joint: ET.Element) -> list[tuple[object, ...]]:
    """Flatten the tree in file order, leaving out the origin of one joint."""
    origin = joint.find("origin")
    return [
        (element.tag, list(element.attrib.items()), (element.text or "").strip())
        for element in root.iter()
        if element is not origin
    ]


def changed_lines(before: bytes, after: bytes) -> tuple[int, int]:
    """Count the removed and the added lines, as `git diff` would."""
    old, new = before.decode().split("\n"), after.decode().split("\n")
    lines = list(difflib.unified_diff(old, new, n=0, lineterm=""))[2:]
    return sum(line[0] == "-" for line in lines), sum(line[0] == "+" for line in lines)


def check_robot(path: Path) -> None:
    """Move the first, the middle and the last joint, one at a time, and read everything back."""
    source = path.read_bytes()
    names = [joint.attrib["name"] for joint in parse(source).findall("joint")]
    for index in sorted({0, len(names) // 2, len(names) - 1}) if names else ():
        before = parse(source)
        joint = before.findall("joint")[index]
        xyz, rpy = (
            tuple(number + SHIFT for number in origin_numbers(joint, attribute))
            for attribute in ("xyz", "rpy")
        )
        patched = patch_urdf(source, {names[index]: JointEdit(xyz, rpy)})  # type: ignore[arg-type]
        removed, added = changed_lines(source, patched)
        assert removed <= 2, f"{path.name}, {names[index]}: {removed} lines removed"
        assert 1 <= added <= 2, f"{path.name}, {names[index]}: {added} lines added"
        after = parse(patched)
        moved = after.findall("joint")[index]
        assert origin_numbers(moved, "xyz") == pytest.approx(xyz, rel=0.0, abs=1e-9)
        assert origin_numbers(moved, "rpy") == pytest.approx(rpy, rel=0.0, abs=1e-9)
        assert without_origin(after, moved) == without_origin(before, joint)


def test_the_example_robots_are_there() -> None:
    robots = sum(b"<joint" in path.read_bytes() for path in EXAMPLE_FILES)
    assert robots >= 60, f"{robots} robots with joints in {EXAMPLES}: install example-robot-data"


@pytest.mark.parametrize("path", EXAMPLE_FILES, ids=lambda path: path.stem)
def test_one_joint_of_an_example_robot(path: Path) -> None:
    check_robot(path)


@pytest.mark.parametrize("name", ["hoap3", "nao_v40", "nao_v50"])
def test_one_joint_of_a_humanoid(name: str, shared_data: Callable[[str], Path]) -> None:
    check_robot(shared_data("robot_models") / f"{name}.urdf")
