"""The humanoid's table against the maker's robot description, reduced to the same 24 joints."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from bodyschema.estimation.identifiability import random_postures
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.simulation.humanoid import ENDS, EYE, humanoid, reduced

JOINTS = {
    "waist": "WAIST_CHEST", "neck_pan": "CHEST_H_PAN", "neck_tilt": "H_PAN_H_TILT",
    "neck_roll": "H_TILT_H_ROLL", "shoulder_pitch": "CHEST_?_SFE", "shoulder_roll": "?_SFE_?_SAA",
    "arm_yaw": "?_SAA_?_SHR", "elbow": "?_SHR_?_EB", "hip_yaw": "WAIST_?_LR",
    "hip_roll": "?_LR_?_LAA", "hip_pitch": "?_LAA_?_LFE", "knee": "?_LFE_?_KN",
    "ankle_pitch": "?_KN_?_AFE", "ankle_roll": "?_AFE_?_AAA",
}  # fmt: skip
"""Ours -> the maker's; ? is R or L."""


def makers_name(joint: str) -> str:
    side = joint[0].upper() if joint[:2] in ("r_", "l_") else ""
    plain = joint[2:] if side else joint
    return JOINTS[plain].replace("?", side) + "_joint"


@pytest.fixture(scope="module")
def makers(shared_data: Callable[[str], Path]) -> Body:
    body = Body.from_urdf(shared_data("robot_models") / "hoap3.urdf")
    markers = {marker: marker.upper() for marker in ENDS}
    names = [makers_name(joint) for joint in humanoid().joints]
    return reduced(body, names, {EYE: "EYE", **markers})


def test_the_same_robot(makers: Body) -> None:
    ours = humanoid()
    assert len(makers.frames) == len(ours.frames)
    q = random_postures(ours, 50, np.random.default_rng(0))
    for marker in ENDS:
        seen = relative_pose(makers, q, EYE, marker)[:, :3, 3]
        np.testing.assert_allclose(relative_pose(ours, q, EYE, marker)[:, :3, 3], seen, atol=1e-9)
    for joint in ours.joints:
        seen = relative_pose(makers, q, EYE, makers_name(joint))[:, :3, 3]
        np.testing.assert_allclose(relative_pose(ours, q, EYE, joint)[:, :3, 3], seen, atol=1e-9)


def test_the_same_ranges(makers: Body) -> None:
    """But for the maker's left arm yaw, which goes one degree further than the right one."""
    ours = humanoid()
    same = np.array([joint != "l_arm_yaw" for joint in ours.joints])
    np.testing.assert_allclose(ours.lower[same], makers.lower[same], atol=1e-6)
    np.testing.assert_allclose(ours.upper[same], makers.upper[same], atol=1e-6)
    assert np.rad2deg(makers.upper[~same]) == pytest.approx([91.0], abs=1e-3)
