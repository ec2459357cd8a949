"""The Body itself: built from lists, extended, looked up by name, never changed in place."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model import parts
from bodyschema.model.kernels import FIXED, PRISMATIC, REVOLUTE
from bodyschema.model.kinematics import frame_poses, relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_frame, free_joints


@pytest.fixture
def arm() -> Body:
    return Body.random_chain(3, np.random.default_rng(0))


def test_random_chains_are_as_described(arm: Body) -> None:
    assert arm.frames == ("base", "link_1", "link_2", "link_3", "tip")
    assert arm.joints == ("joint_1", "joint_2", "joint_3")
    assert arm.kind.tolist() == [FIXED, REVOLUTE, REVOLUTE, REVOLUTE, FIXED]
    assert arm.parent.tolist() == [-1, 0, 1, 2, 3]
    assert np.linalg.norm(arm.axis, axis=1) == pytest.approx(np.ones(5))
    lengths = np.linalg.norm(arm.placement[1:, :3, 3], axis=1)
    assert ((lengths >= 0.05) & (lengths <= 0.3)).all()
    again = Body.random_chain(3, np.random.default_rng(0))
    assert (again.placement == arm.placement).all()
    assert (again.axis == arm.axis).all()


def test_build_orders_joints_limits_and_mimics() -> None:
    body = Body.build(
        name="gripper",
        frames=["palm", "left", "right", "wrist"],
        carriers=["", "left_joint", "right_joint", "wrist_joint"],
        parent=[-1, 0, 0, 0],
        kind=[FIXED, PRISMATIC, PRISMATIC, REVOLUTE],
        axis=[[0, 0, 1]] * 4,
        placement=[np.eye(4)] * 4,
        limits={"wrist_joint": (-1.0, 2.0)},
        mimics={"left_joint": ("right_joint", -1.0, 0.5)},
        joints=["wrist_joint", "right_joint"],
    )
    assert body.joints == ("wrist_joint", "right_joint")
    assert body.driver.tolist() == [-1, 1, 1, 0]
    assert body.rate.tolist() == [1, -1, 1, 1]
    assert body.shift.tolist() == [0, 0.5, 0, 0]
    assert body.lower.tolist() == [-1, -np.inf]
    assert body.upper.tolist() == [2, np.inf]
    z = frame_poses(body, [0.0, 0.2])[:, 2, 3]
    assert z == pytest.approx([0, 0.3, 0.2, 0])


def test_attach_hangs_a_frame_anywhere(arm: Body) -> None:
    T = lie.transform(lie.rotation_from_rpy([0.1, 0.2, 0.3]), [0.4, 0.5, 0.6])
    seeing = arm.attach("camera", "link_2", T).attach("tracker", "base")
    q = [0.3, -0.4, 0.5]
    assert relative_pose(seeing, q, "link_2", "camera") == pytest.approx(T, abs=1e-15)
    assert relative_pose(seeing, q, "base", "tracker") == pytest.approx(np.eye(4))
    assert seeing.joints == arm.joints
    assert "camera" not in arm.frames
    assert len(free_frame(seeing, "camera")) == 6
    assert (frame_poses(seeing, q)[:5] == frame_poses(arm, q)).all()


def test_with_placement_and_with_parameters_leave_the_body_alone(arm: Body) -> None:
    before = arm.placement.copy()
    moved = arm.with_placement("tip", lie.transform(np.eye(3), [1.0, 2.0, 3.0]))
    assert relative_pose(moved, np.zeros(3), "link_3", "tip")[:3, 3].tolist() == [1, 2, 3]
    variables = free_joints(arm)
    arm.with_variables(variables, np.full(len(variables), 0.1))
    assert (arm.placement == before).all()
    assert (arm.gear == 0).all()
    with pytest.raises(AttributeError):
        arm.name = "other"  # type: ignore[misc]


def test_zero_deviation_is_the_same_body(arm: Body) -> None:
    variables = free_joints(arm)
    same = arm.with_variables(variables, np.zeros(len(variables)))
    assert np.abs(same.axis - arm.axis).max() < 1e-15
    assert (same.placement == arm.placement).all()


def test_deviations_start_from_the_body_at_hand(arm: Body) -> None:
    """A body that already has offsets and gears keeps them."""
    variables = free_joints(arm, ["offsets", "gears"])
    x = 0.1 * np.arange(1.0, 7.0)
    once = arm.with_variables(variables, x)
    twice = once.with_variables(variables, x)
    assert twice.offset == pytest.approx(2 * once.offset)
    assert twice.gear == pytest.approx(2 * once.gear)


def test_tangents_complete_every_axis(arm: Body) -> None:
    triads = np.concatenate([arm.tangents, arm.axis[..., None]], axis=2)
    assert np.abs(np.swapaxes(triads, 1, 2) @ triads - np.eye(3)).max() < 1e-15


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda b: b.frame_index("tipp"), "no frame 'tipp' on random_3; did you mean 'tip'"),
        (lambda b: b.frame_index("zzz"), "no frame 'zzz' on random_3; there are: 'base', 'link_1'"),
        (lambda b: b.joint_index("joint_9"), "no joint 'joint_9' .* did you mean 'joint_"),
        (lambda b: b.attach("tip", "base"), "has a frame 'tip' already; choose another name"),
        (lambda b: b.attach("camera", "bse"), "no frame 'bse' on random_3; did you mean 'base'"),
        (lambda b: b.with_placement("tpi", np.eye(4)), "no frame 'tpi'"),
        (
            lambda b: b.attach("camera", "base", np.eye(3)),
            r"expected a 4x4 transform, got an array \(3, 3\)",
        ),
        (
            lambda b: b.with_placement("tip", np.ones(3)),
            r"expected a 4x4 transform, got an array \(3,\)",
        ),
    ],
)
def test_refusals_name_the_alternatives(arm: Body, call: object, message: str) -> None:
    assert callable(call)
    with pytest.raises(InputError, match=message):
        call(arm)


def test_a_part_and_a_frame_do_not_share_a_name() -> None:
    body = Body.random_chain(2, np.random.default_rng(0)).with_part("imu", parts.accelerometer())
    with pytest.raises(InputError, match="has a part 'imu' already"):
        body.attach("imu", "tip")
    with pytest.raises(InputError, match="has a frame 'tip'; give the clock another name"):
        body.with_part("tip", parts.clock())
