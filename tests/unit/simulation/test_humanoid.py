"""The humanoid: its tree, its ranges, its mirror symmetry, and the reduction of other bodies."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.estimation.identifiability import random_postures
from bodyschema.model.kinematics import frame_poses, relative_pose
from bodyschema.model.skeleton import zero_rotations
from bodyschema.model.tree import Body
from bodyschema.simulation.humanoid import (
    BETWEEN,
    ENDS,
    EYE,
    STRAIGHT,
    humanoid,
    icub_humanoid,
    reduced,
)

Array = NDArray[np.float64]


def test_the_tree_is_that_of_the_paper() -> None:
    body = humanoid()
    groups = {
        "neck": 3, "waist": 1, "r_shoulder": 2, "r_arm": 1, "r_elbow": 1,
        "l_shoulder": 2, "l_arm": 1, "l_elbow": 1, "r_hip": 3, "r_knee": 1, "r_ankle": 2,
        "l_hip": 3, "l_knee": 1, "l_ankle": 2,
    }  # fmt: skip
    counted = {name: sum(j.startswith(name) for j in body.joints) for name in groups}
    assert counted == groups
    assert len(body.joints) == 24
    assert set(ENDS) | set(BETWEEN) | {EYE} <= set(body.frames)


def test_all_frames_are_parallel_at_zero() -> None:
    R0 = zero_rotations(humanoid())
    np.testing.assert_array_equal(R0, np.tile(np.eye(3), (len(R0), 1, 1)))


def test_right_and_left_mirror_each_other() -> None:
    body = humanoid()
    rng = np.random.default_rng(0)
    q = random_postures(body, 20, rng)
    mirrored = q.copy()
    flip = np.diag([1.0, -1.0, 1.0])
    for j, joint in enumerate(body.joints):
        side = {"r_": "l_", "l_": "r_"}.get(joint[:2], joint[:2])
        other = body.joint_index(side + joint[2:])
        axis = body.axis[body.frame_index(joint)]
        # A mirror turns a rotation about a vector a into one about -M a.
        sign = 1.0 if abs(axis[1]) == 1 else -1.0
        mirrored[:, other] = sign * q[:, j]
    assert (mirrored >= body.lower - 1e-12).all()
    assert (mirrored <= body.upper + 1e-12).all()
    for marker in ENDS:
        other = {"r": "l", "l": "r"}[marker[0]] + marker[1:]
        here = relative_pose(body, q, "pelvis", marker)[:, :3, 3]
        there = relative_pose(body, mirrored, "pelvis", other)[:, :3, 3]
        np.testing.assert_allclose(there, here @ flip, atol=1e-12)


def test_the_ranges_may_be_put_aside() -> None:
    body = humanoid(STRAIGHT)
    np.testing.assert_array_equal(body.upper, np.full(24, np.pi / 2))
    np.testing.assert_array_equal(body.lower, -body.upper)


def test_it_stands_on_its_feet() -> None:
    poses = frame_poses(humanoid(), np.zeros(24))[:, :3, 3]
    feet = [humanoid().frame_index(foot) for foot in ("r_foot", "l_foot")]
    assert set(np.argsort(poses[:, 2])[:2]) == set(feet)


def turned(body: Body, rng: np.random.Generator) -> Body:
    """The same robot with the frames of its joints turned, as in most URDFs."""
    placement = body.placement.copy()
    R = lie.exp_so3(rng.normal(size=(len(placement), 3)))
    R[0] = np.eye(3)
    above = R[np.maximum(body.parent, 0)]
    placement[:, :3, :3] = np.swapaxes(above, 1, 2) @ R
    placement[:, :3, 3] = np.einsum("kji,kj->ki", above, body.placement[:, :3, 3])
    axis = np.einsum("kji,kj->ki", R, body.axis)
    return Body.build(
        "turned", body.frames, body.carriers, body.parent.tolist(), body.kind.tolist(), axis,
        placement, dict(zip(body.joints, zip(body.lower, body.upper, strict=True), strict=True)),
    )  # fmt: skip


def test_a_reduced_body_sees_what_the_whole_one_sees() -> None:
    """The joints left out stand at zero; what the eye sees is turned by its own frame."""
    rng = np.random.default_rng(1)
    whole = turned(humanoid(), rng)
    kept = [joint for joint in whole.joints if "ankle" not in joint and joint != "neck_roll"]
    small = reduced(whole, kept, {EYE: EYE, **{marker: marker for marker in ENDS}})
    assert len(small.frames) == 1 + 19 + 5
    q = np.zeros((10, 24))
    columns = [whole.joint_index(joint) for joint in kept]
    q[:, columns] = random_postures(small, 10, rng)
    R_zero = zero_rotations(whole)[whole.frame_index(EYE)]
    for marker in ENDS:
        seen = relative_pose(whole, q, EYE, marker)[:, :3, 3]
        again = relative_pose(small, q[:, columns], EYE, marker)[:, :3, 3]
        np.testing.assert_allclose(again, seen @ R_zero.T, atol=1e-12)


def test_a_reduced_body_keeps_ranges_order_and_mimics() -> None:
    body = Body.build(
        "fingers", ["palm", "a", "b", "tip"], ["", "j_a", "j_b", "tip_joint"], [-1, 0, 1, 2],
        [0, 1, 1, 0], [[0, 0, 1]] * 4, np.tile(np.eye(4), (4, 1, 1)),
        limits={"j_a": (-1.0, 2.0)}, mimics={"j_b": ("j_a", 0.5, 0.1)},
    )  # fmt: skip
    small = reduced(body, ["j_a"], {"tip": "tip"})
    assert small.joints == ("j_a",)
    assert small.frames == ("palm", "j_a", "j_b", "tip")
    assert (small.lower[0], small.upper[0]) == (-1.0, 2.0)
    np.testing.assert_array_equal(small.rate[1:3], [1.0, 0.5])
    np.testing.assert_array_equal(small.shift[1:3], [0.0, 0.1])


def test_a_wrong_name_is_met_with_the_right_one() -> None:
    with pytest.raises(InputError, match="'r_knee'"):
        reduced(humanoid(), ["r_kne"], {})
    with pytest.raises(InputError, match="'camera'"):
        reduced(humanoid(), ["r_knee"], {"eye": "camra"})


def test_the_icub_has_the_same_markers() -> None:
    pytest.importorskip("icub_models")
    body = icub_humanoid()
    assert len(body.joints) == 32
    assert {EYE, *ENDS, *BETWEEN} <= set(body.frames)
