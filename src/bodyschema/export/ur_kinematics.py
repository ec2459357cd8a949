"""ur_kinematics.yaml: a corrected UR arm in the keys that ur_description loads.

ur_description turns every joint about z of its frame and keeps the six placements in a file,

    kinematics: {shoulder: {x, y, z, roll, pitch, yaw}, upper_arm: ..., hash: calib_...}

which `ur.urdf.xacro` takes as `kinematics_params`. Where an axis a_k was corrected, its frame is
turned by the smallest rotation A_k that takes z to it, which changes no motion:

    P_k M(a_k, q) = (P_k A_k) M(z, q) A_k^T,        P_k' = A_(k-1)^T P_k A_k

What is left, A_6^T, turns wrist_3_link itself, for which ur_description has no key.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.export.documents import yaml_text
from bodyschema.export.joint_edit import clean
from bodyschema.export.urdf_edits import baked_placements
from bodyschema.model.kernels import REVOLUTE
from bodyschema.model.tree import Body

Array = NDArray[np.float64]

LINKS = ("shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3")
"""Keys of the file; each is the link `KEY_link`."""

FIRST = "base_link_inertia"
"""The link that the first joint hangs on since ur_description has such files."""

UPRIGHT = 0.1
"""rad by which a corrected axis may miss z: in older descriptions axes are others altogether."""

SEEN = 1e-7
"""rad: a rest of wrist_3_link that is worth a sentence."""

HEADING = """\
The corrected arm for ur_description, written by bodyschema: kinematics_params:=ur_kinematics.yaml
hash: put that of the robot's own calibration here, which the driver compares."""


def ur_kinematics_text(body: Body) -> str:
    """ur_kinematics.yaml of a body; "" for one that is no arm of ur_description."""
    rows = _rows(body)
    if rows is None:
        return ""
    placements, before = baked_placements(body), np.eye(3)
    kinematics: dict[str, object] = {}
    for key, k in zip(LINKS, rows, strict=True):
        turn = _from_z(body.axis[k])
        xyz = before.T @ placements[k, :3, 3]
        rpy = lie.rpy_from_rotation(before.T @ placements[k, :3, :3] @ turn)
        named = zip(("x", "y", "z", "roll", "pitch", "yaw"), (*xyz, *rpy), strict=True)
        kinematics[key] = {name: clean(float(value)) for name, value in named}
        before = turn
    kinematics["hash"] = "calib_0"
    return yaml_text({"kinematics": kinematics}, HEADING + _rest(before))


def _rows(body: Body) -> list[int] | None:
    """Rows of the six links, one hanging on the other from FIRST."""
    for start in (f for f in body.frames if f.endswith(FIRST)):
        prefix, above, rows = start.removesuffix(FIRST), body.frames.index(start), []
        for key in LINKS:
            name = f"{prefix}{key}_link"
            k = body.frames.index(name) if name in body.frames else -1
            upright = k > 0 and body.axis[k, 2] > np.cos(UPRIGHT)
            if not upright or body.parent[k] != above or body.kind[k] != REVOLUTE:
                break
            rows.append(k)
            above = k
        if len(rows) == len(LINKS):
            return rows
    return None


def _from_z(axis: Array) -> Array:
    """The smallest rotation that takes z to an axis near it."""
    across = np.cross([0.0, 0.0, 1.0], axis)
    sine = float(np.linalg.norm(across))
    if not sine:
        return np.eye(3)
    return lie.exp_so3(across / sine * np.arctan2(sine, axis[2]))


def _rest(turn: Array) -> str:
    rpy = lie.rpy_from_rotation(turn.T)
    if np.abs(rpy).max() < SEEN:
        return ""
    said = " ".join(f"{angle:.9g}" for angle in rpy)
    return (
        "\nThe last axis was corrected: wrist_3_link of robot.urdf lies in that of ur_description "
        f'by rpy="{said}";\nput it before what hangs on wrist_3_link.'
    )
