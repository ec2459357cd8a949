"""What to change in a URDF so that it describes the corrected body.

A URDF knows no joint offset: readers feed the reading q straight into the joint. Frame k moves by

    theta_k = rate_k ((1 + g) q + o) + shift_k,      T_parent_k = P_k M_k(theta_k)

and motions about one axis add up, M(a + b) = M(a) M(b). So the offset goes into the placement

    P_k M_k(rate_k o) M_k(rate_k q + shift_k)

with the corrected axis; a mimicking joint keeps its multiplier and its `<mimic offset>` shift_k.
Limits are those of the readings, which stay what they were. Where they stand for mechanical stops,
they have moved by -rate_k o with the joint's zero. The gear error g cannot be written.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.export.joint_edit import JointEdit, Vector
from bodyschema.model.kernels import PRISMATIC, REVOLUTE
from bodyschema.model.tree import Body

Array = NDArray[np.float64]

SAME = 1e-12
"""m, rad, or length of an axis: what differs by no more is not written."""


def urdf_edits(nominal: Body, corrected: Body, stops: bool = False) -> dict[str, JointEdit]:
    """New values of the joints of a URDF, by joint name.

    Args:
        nominal: the body that the URDF describes.
        corrected: the same robot; frames that it has besides are skipped.
        stops: the limits are mechanical stops, and move with the joints' zeros.

    Returns:
        Only joints and values that differ. With them in the URDF, encoder readings give the poses
        of the corrected body; but for gear errors, see `unwritable`.

    Raises:
        InputError: a frame of the nominal body is missing, or hangs on another joint.
    """
    matched = described(nominal, corrected)
    placements = baked_placements(nominal), baked_placements(matched)
    zeros = node_offsets(nominal), node_offsets(matched)
    edits = {}
    for k in range(1, len(nominal.frames)):
        before, after = placements[0][k], placements[1][k]
        turned = nominal.kind[k] in (REVOLUTE, PRISMATIC) and _differs(
            nominal.axis[k], matched.axis[k]
        )
        shift = float(zeros[0][k] - zeros[1][k])
        edit = JointEdit(
            xyz=_vector(after[:3, 3]) if _differs(before[:3, 3], after[:3, 3]) else None,
            rpy=_vector(lie.rpy_from_rotation(after[:3, :3]))
            if _differs(before[:3, :3], after[:3, :3])
            else None,
            axis=_vector(matched.axis[k]) if turned else None,
            shift_limits=shift if stops and abs(shift) > SAME else None,
        )
        if edit != JointEdit():
            edits[nominal.carriers[k]] = edit
    return edits


def unwritable(nominal: Body, corrected: Body) -> list[str]:
    """What is corrected but has no place in a URDF: a sentence for each joint with a gear error."""
    matched = described(nominal, corrected)
    return [
        f"joint '{joint}' moves {1 + gear:.6g} times as far as its encoder says, which no URDF can "
        "express: multiply its reading by that before the URDF sees it."
        for joint, gear in zip(matched.joints, matched.gear, strict=True)
        if abs(gear) > SAME
    ]


def described(nominal: Body, corrected: Body) -> Body:
    """The nominal body's tree with the corrected body's numbers; further frames are left out.

    Raises:
        InputError: a frame of the nominal body is missing, or hangs on another joint.
    """
    rows = [corrected.frame_index(frame) for frame in nominal.frames]
    columns = [corrected.joint_index(joint) for joint in nominal.joints]
    for row, frame, carrier in zip(rows, nominal.frames, nominal.carriers, strict=True):
        if corrected.carriers[row] != carrier:
            raise InputError(
                f"frame '{frame}' hangs on joint '{carrier}' in {nominal.name} and on "
                f"'{corrected.carriers[row]}' in {corrected.name}; give two bodies of one robot."
            )
    return replace(
        nominal,
        axis=corrected.axis[rows],
        placement=corrected.placement[rows],
        gear=corrected.gear[columns],
        offset=corrected.offset[columns],
    )


def node_offsets(body: Body) -> Array:
    """rate_k o of every frame, rad or m: by how much its joint stands off its zero, (n_frames,)."""
    offsets = np.zeros(len(body.frames))
    moves = body.driver >= 0
    offsets[moves] = body.rate[moves] * body.offset[body.driver[moves]]
    return offsets


def baked_placements(body: Body) -> Array:
    """P_k M_k(rate_k o), the placements with the joint offsets inside, (n_frames, 4, 4)."""
    along = node_offsets(body)[:, None] * body.axis
    turn = np.where(body.kind[:, None] == REVOLUTE, along, 0.0)
    shift = np.where(body.kind[:, None] == PRISMATIC, along, 0.0)
    moved = node_offsets(body) != 0
    placement = body.placement.copy()
    placement[moved] = placement[moved] @ lie.transform(lie.exp_so3(turn), shift)[moved]
    return placement


def _differs(before: Array, after: Array) -> bool:
    return bool(np.max(np.abs(before - after)) > SAME)


def _vector(values: Array) -> Vector:
    x, y, z = (float(value) for value in values)
    return x, y, z
