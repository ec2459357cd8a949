"""Entries of a payload file that are often written wrongly, and what else they may be."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

from bodyschema.cli.wrist.payload_file import PayloadFile

ALTERNATIVES: dict[str, dict[str, tuple[str, ...]]] = {
    "wrench": {"frame": ("sensor", "base"), "about": ("base",), "torque_unit": ("Nm", "Nmm")},
    "pose": {"unit": ("m", "mm"), "angle_unit": ("rad", "deg")},
}
"""Entries that are often written wrongly, and what else they may be."""

SWAPPED = {
    "xyz_xyzw": "xyz_wxyz", "xyz_wxyz": "xyz_xyzw", "xyzw": "wxyz", "wxyz": "xyzw",
    "xyz_rpy": "xyz_rotvec", "xyz_rotvec": "xyz_rpy", "rpy": "rotvec", "rotvec": "rpy",
}  # fmt: skip
"""Layouts that are taken for each other."""


def other_entries(run: PayloadFile) -> dict[str, PayloadFile]:
    """Words for one changed entry -> the run with it, most likely first."""
    trials = dict[str, PayloadFile]()
    for key, words in ALTERNATIVES["wrench"].items():
        for word in (word for word in words if word != getattr(run.wrench, key)):
            change: dict[str, Any] = {key: word}
            wrench = replace(run.wrench, **change)
            trials[f'{key} = "{word}"'] = replace(run, wrench=wrench)
    if run.pose is not None:
        changes: list[tuple[str, Any]] = [("inverse", not run.pose.inverse)]
        changes += [("layout", SWAPPED[run.pose.layout])] if run.pose.layout in SWAPPED else []
        for key, words in ALTERNATIVES["pose"].items():
            changes += [(key, word) for word in words if word != getattr(run.pose, key)]
        for key, value in changes:
            pose = replace(run.pose, **{key: value})
            trials[f"{key} = {json.dumps(value)} under [pose]"] = replace(run, pose=pose)
    turned = replace(run, sensor=replace(run.sensor, known="no"))
    trials['known = "no" under [sensor]'] = turned
    return trials
