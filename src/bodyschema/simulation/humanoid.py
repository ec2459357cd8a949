"""A humanoid of 24 joints that looks at itself, as in Hersch et al. 2008, section 5.1.

The tree hangs on the pelvis: a waist joint, three neck joints with the camera behind them, two arms
of four joints and two legs of six. At zero posture all frames are parallel to the root, x forward,
y left, z up; the robot stands, upper arms and forearms stretched forward. A marker between two
limbs, such as a knee, is the origin of the joint's own frame; hands, feet and the camera are fixed
frames behind the last joints.

Dimensions and joint ranges are those of the maker's model (Fujitsu HOAP-3) without the wrists.
Right limbs are listed; left ones are mirrored at the plane y = 0, where a turn about x or z changes
its sign and a turn about y does not.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from bodyschema.model.kernels import FIXED, REVOLUTE
from bodyschema.model.skeleton import Skeleton
from bodyschema.model.tree import Body
from bodyschema.simulation import icub

Vector = tuple[float, float, float]

EYE = "camera"
"""The frame that sees."""

ENDS = ("r_hand", "l_hand", "r_foot", "l_foot")
"""Markers at the ends of the limbs."""

BETWEEN = (
    "r_elbow", "l_elbow", "r_knee", "l_knee", "r_shoulder_pitch", "l_shoulder_pitch", "waist",
)  # fmt: skip
"""Markers between the limbs: the centres of elbows, knees, shoulders and waist."""

STRAIGHT = np.pi / 2
"""rad: every joint moves this far either way where the robot's own ranges are put aside."""


class Node(NamedTuple):
    """One joint or marker."""

    name: str
    parent: str
    link: Vector
    """mm from the parent, at zero posture."""
    axis: Vector | None = None
    """Unit; None for a marker."""
    low: float = 0.0
    """deg"""
    high: float = 0.0


X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)

TRUNK = (
    Node("waist", "pelvis", (0, 0, 0), Y, 0, 35),
    Node("neck_pan", "waist", (-35, 0, 125), Z, -60, 60),
    Node("neck_tilt", "neck_pan", (15, 0, 103), (0.0, -1.0, 0.0), -45, 15),
    Node("neck_roll", "neck_tilt", (0, 0, 0), (-1.0, 0.0, 0.0), -15, 15),
    Node(EYE, "neck_roll", (60, 0, -4)),
)

RIGHT_LIMBS = (
    Node("shoulder_pitch", "waist", (-35, -111, 125), Y, -90, 140),
    Node("shoulder_roll", "shoulder_pitch", (0, 0, 0), Z, -90, 0),
    Node("arm_yaw", "shoulder_roll", (111, 0, 0), X, -90, 90),
    Node("elbow", "arm_yaw", (0, 0, 0), Y, -115, 0),
    Node("hand", "elbow", (102.8, 0, 0)),
    Node("hip_yaw", "pelvis", (-35, -39, -55), Z, -90, 30),
    Node("hip_roll", "hip_yaw", (0, 0, 0), X, -30, 20),
    Node("hip_pitch", "hip_roll", (0, 0, 0), Y, -80, 70),
    Node("knee", "hip_pitch", (0, 0, -105), Y, 5, 130),
    Node("ankle_pitch", "knee", (0, 0, -105), Y, -60, 60),
    Node("ankle_roll", "ankle_pitch", (0, 0, 0), X, -25, 25),
    Node("foot", "ankle_roll", (14, -5, -40)),
)


def humanoid(reach: float | None = None) -> Body:
    """The 24-joint humanoid.

    Args:
        reach: every joint moves by this either way, rad, such as `STRAIGHT`; None for the ranges of
            the real joints.
    """
    nodes = [*TRUNK, *_sided("r_"), *_sided("l_")]
    frames = ["pelvis", *(node.name for node in nodes)]
    placement = np.tile(np.eye(4), (len(frames), 1, 1))
    placement[1:, :3, 3] = [np.array(node.link) / 1000 for node in nodes]
    moving = [node for node in nodes if node.axis is not None]
    own = {node.name: (np.deg2rad(node.low), np.deg2rad(node.high)) for node in moving}
    return Body.build(
        name="humanoid",
        frames=frames,
        carriers=["", *(node.name for node in nodes)],
        parent=[-1, *(frames.index(node.parent) for node in nodes)],
        kind=[FIXED, *(FIXED if node.axis is None else REVOLUTE for node in nodes)],
        axis=[Z, *(node.axis or Z for node in nodes)],
        placement=placement,
        limits=own if reach is None else dict.fromkeys(own, (-reach, reach)),
    )


def _sided(side: str) -> Iterator[Node]:
    """The limbs of one side, "r_" or "l_"."""
    limb = {node.name for node in RIGHT_LIMBS}
    for name, parent, (x, y, z), axis, low, high in RIGHT_LIMBS:
        above = side + parent if parent in limb else parent
        if side == "l_":
            y = -y
            if axis != Y:
                low, high = -high, -low
        yield Node(side + name, above, (x, y, z), axis, low, high)


def reduced(body: Body, joints: Sequence[str], markers: Mapping[str, str]) -> Body:
    """The skeleton of a body with some of its joints; the others stand at zero.

    Args:
        body: any body, such as a humanoid read from a URDF.
        joints: names of the joints that stay, in the order of the columns of q.
        markers: names of the fixed frames wanted, each with the frame of the body that it is.

    Returns:
        A body with the root, one frame named after each joint that stays, and the markers, all
        parallel to the root at zero posture.

    Raises:
        InputError: no such joint or frame.
    """
    chosen = [body.joint_index(joint) for joint in joints]
    nodes = [k for k in range(len(body.frames)) if k == 0 or body.driver[k] in chosen]
    carried = [(frame, body.frame_index(seen)) for frame, seen in markers.items()]
    skeleton = Skeleton.of(body)
    at = np.zeros((len(body.frames), 3))
    for k in range(1, len(at)):
        at[k] = at[body.parent[k]] + skeleton.links[k]
    above = [-1, *(_kept_above(body, nodes, int(body.parent[k])) for k in nodes[1:])]
    above += [_kept_above(body, nodes, k) for _, k in carried]
    rows = [*nodes, *(k for _, k in carried)]
    placement = np.tile(np.eye(4), (len(rows), 1, 1))
    placement[1:, :3, 3] = [at[k] - at[nodes[p]] for k, p in zip(rows[1:], above[1:], strict=True)]
    carriers = [body.carriers[k] for k in nodes]
    follow = [k for k in nodes[1:] if body.carriers[k] not in body.joints]
    return Body.build(
        name=body.name,
        frames=[body.frames[0], *carriers[1:], *markers],
        carriers=[*carriers, *(f"{frame}_joint" for frame in markers)],
        parent=above,
        kind=[*body.kind[nodes], *[FIXED] * len(markers)],
        axis=[*skeleton.axes[nodes], *[Z] * len(markers)],
        placement=placement,
        limits={body.joints[j]: (body.lower[j], body.upper[j]) for j in chosen},
        mimics={
            body.carriers[k]: (body.joints[body.driver[k]], body.rate[k], body.shift[k])
            for k in follow
        },
        joints=joints,
    )


def _kept_above(body: Body, nodes: Sequence[int], k: int) -> int:
    """Row in `nodes` of the nearest one at or above frame k."""
    while k not in nodes:
        k = int(body.parent[k])
    return list(nodes).index(k)


def icub_humanoid() -> Body:
    """The iCub of icub-models as a skeleton of 32 joints, with the markers of `humanoid`.

    Its arms have three wrist joints and its waist three joints more than HOAP-3 has; marker
    "waist" is the centre of the third.

    Raises:
        MissingExtraError: icub-models is not installed.
    """
    body = icub.nominal_icub()
    markers = {EYE: icub.LEFT_EYE, "waist": "chest"}
    for side in ("r_", "l_"):
        markers[f"{side}hand"] = f"{side}hand_dh_frame"
        markers[f"{side}foot"] = f"{side}sole"
    return reduced(body, body.joints, markers)
