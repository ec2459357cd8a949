"""What was asked for, in words: where frames are, how well that is known, and lines to copy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from bodyschema.units import significant

MOST_NAMED = 2
"""Pairs of frames that a sentence names."""

Entry = Mapping[str, Any]
"""One of `export.static_transforms.place_entries`."""


def position(entry: Entry) -> str:
    """x y z, mm."""
    return _numbers(entry["xyz_mm"], 2)


def angles(entry: Entry) -> str:
    """Roll pitch yaw about fixed axes, deg."""
    return _numbers(entry["rpy_deg"], 3)


def quaternion(entry: Entry) -> str:
    """x y z w."""
    return _numbers(entry["quaternion_xyzw"], 6)


def known(entry: Entry) -> str:
    """How well a place is known, or what it goes along with and where it is known instead."""
    if not entry["not_determined"]:
        return f"within {bounds(entry)} (95 %){posture(entry)}"
    said = f"not determined: {entry['not_determined']}"
    told = entry["determined_in"]
    if told is None:
        return said
    return f"{said}; in {told['parent']} within {bounds(told)} (95 %){posture(told)}"


def bounds(entry: Entry) -> str:
    """What position and rotation stay below with 95 %."""
    sizes = ((entry["within_mm_95"], "mm"), (entry["within_deg_95"], "deg"))
    found = [f"{significant(size, 2)} {unit}" for size, unit in sizes if size is not None]
    return ", ".join(found) + ("" if len(found) == 2 else ", its rotation as given")


def posture(entry: Entry) -> str:
    """Where the joints between both frames are."""
    if not entry["joints_at"]:
        return ""
    if len(entry["joints_at"]) > 2:
        return ", all joints at zero or their nearest limit"
    at = (f"{joint} at {value:.4g}" for joint, value in entry["joints_at"].items())
    return f", {' and '.join(at)}"


def far_off(document: Mapping[str, Any]) -> str:
    """How far off what was asked for still is; "" where nothing says, or it is not to be used."""
    size = document["predicted_95_mm"]
    if size is None or document["tone"] == "bad":
        return ""
    seen = [(entry["seen_from"], entry["seen"]) for entry in document["predicted"]]
    pairs = dict.fromkeys(tuple(pair) for pair in document["wanted"] or seen)
    what = " and ".join(f"{seen} in {looks}" for looks, seen in pairs)
    what = "" if not pairs else f"{what} " if len(pairs) <= MOST_NAMED else "what was seen "
    where = " over the joint ranges recorded" if document.get("uncertainty") else ""
    return f"{what}off by less than {significant(size, 2)} mm (95 %){where}"


def _numbers(values: Sequence[float | None], decimals: int) -> str:
    return " ".join("-" if v is None else f"{v + 0.0:.{decimals}f}" for v in values)
