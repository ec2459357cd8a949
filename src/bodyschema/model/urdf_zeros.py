"""Zeros of joints that a description states beside their origins, for drivers that honour them.

<calibration rising> or falling of a joint is passed over by robot_state_publisher but not by all
drivers; ros2_control and transmissions have an offset of their own. Kinematics do not depend on
them: a Body only remembers how they are written.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator

CALIBRATION = ("rising", "falling", "reference_position")


def stated_zeros(robot: ET.Element) -> dict[str, str]:
    """Joint -> how its own zero is written; joints without one, or with 0, are left out."""
    found: dict[str, list[str]] = {}
    for name, written, value in _stated(robot):
        if not _is_zero(value):
            found.setdefault(name, []).append(written)
    return {name: " and ".join(written) for name, written in found.items()}


def _stated(robot: ET.Element) -> Iterator[tuple[str, str, str]]:
    """(joint, how it is written, the number) of every zero."""
    for joint in robot.findall("joint"):
        for element in joint.findall("calibration"):
            for key in CALIBRATION:
                if key in element.attrib:
                    value = element.attrib[key]
                    yield joint.get("name", ""), f'<calibration {key}="{value}">', value
    for joint in robot.findall("ros2_control/joint"):
        for element in joint.findall("param"):
            if element.get("name") == "offset":
                value = (element.text or "").strip()
                yield joint.get("name", ""), f"offset {value} in <ros2_control>", value
    for joint in robot.findall("transmission/joint"):
        value = (joint.findtext("offset") or "0").strip()
        yield joint.get("name", ""), f"<offset> {value} in <transmission>", value


def _is_zero(text: str) -> bool:
    try:
        return float(text or 0) == 0.0
    except ValueError:
        return False
