"""The URDF patch on real robots: one line changes, and in it only what was asked."""

from __future__ import annotations

import difflib
import math
import sysconfig
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.export.urdf_edits import urdf_edits
from bodyschema.export.urdf_patch import JointEdit, patch_urdf
from bodyschema.model.kinematics import frame_poses
from bodyschema.model.urdf import parse_urdf
from bodyschema.model.variables import free_joints

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


def check_corrections(path: Path) -> int:
    """Turn the zero of every second joint: two lines of a diff each, and the poses of the fit."""
    source = path.read_bytes()
    nominal = parse_urdf(source, path, {})
    rng = np.random.default_rng(0)
    free = free_joints(nominal, ["offsets"], nominal.joints[::2])
    corrected = nominal.with_variables(free, 0.3 * rng.uniform(-1, 1, len(free)) * free.prior_std)
    edits = urdf_edits(nominal, corrected)
    patched = patch_urdf(source, edits)
    joints = {joint.get("name"): joint for joint in parse(source).findall("joint")}
    stated = sum(joints[name].find("origin") is not None for name in edits)
    assert changed_lines(source, patched) == (stated, len(edits))
    again = parse_urdf(patched, path, {})
    q = rng.uniform(-2, 2, (10, len(nominal.joints)))
    assert np.abs(frame_poses(again, q) - frame_poses(corrected, q)).max(initial=0.0) < 1e-9
    assert comments(patched) == comments(source)
    for name in edits:
        moved = parse(patched).find(f"joint[@name='{name}']")
        assert moved is not None
        before, (r, p, y) = (origin_numbers(joint, "rpy") for joint in (joints[name], moved))
        turned = [r + math.pi, math.pi - p, y + math.pi]  # the same rotation, said otherwise
        other = [
            a - math.tau * round((a - b) / math.tau) for a, b in zip(turned, before, strict=True)
        ]
        assert math.dist((r, p, y), before) <= math.dist(other, before), f"{name}: {before}"
    return len(edits)


def comments(source: bytes) -> list[str | None]:
    """All that is said in comments, in order."""
    return [element.text for element in parse(source).iter() if callable(element.tag)]


@pytest.mark.parametrize("path", EXAMPLE_FILES, ids=lambda path: path.stem)
def test_corrected_zeros_of_an_example_robot(path: Path) -> None:
    try:
        check_corrections(path)
    except InputError as error:  # two of 69: a mimic of nobody, a robot without links
        pytest.skip(str(error))


@pytest.mark.parametrize(
    "name",
    [
        "robot_models/hoap3",
        "robot_models/nao_v40",
        "robot_models/nao_v50",
        "roboreg_med7_zed2i/lbr_med7_r800",
        "figaroh_tiago_mocap/tiago_arm_chain",
        "figaroh_tx40_dynamics/tx40_nomesh",
        "figaroh_talos_contact/talos_left_arm_chain",
    ],
)
def test_corrected_zeros_of_a_measured_robot(name: str, shared_data: Callable[[str], Path]) -> None:
    folder, _, robot = name.partition("/")
    assert check_corrections(shared_data(folder) / f"{robot}.urdf") > 2


@pytest.mark.parametrize("path", EXAMPLE_FILES, ids=lambda path: path.stem)
def test_one_joint_of_an_example_robot(path: Path) -> None:
    check_robot(path)


@pytest.mark.parametrize("name", ["hoap3", "nao_v40", "nao_v50"])
def test_one_joint_of_a_humanoid(name: str, shared_data: Callable[[str], Path]) -> None:
    check_robot(shared_data("robot_models") / f"{name}.urdf")
