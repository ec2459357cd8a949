"""The robot with eyes: it stands where its true joints say, and sees what is there."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.acting.robot import Robot
from bodyschema.errors import InputError
from bodyschema.model.kinematics import relative_pose
from bodyschema.simulation import icub
from bodyschema.simulation.seeing_icub import LEFT_LINKS, SEEN_LINKS, SeeingIcub, stereo_eyes
from bodyschema.vision.contours import silhouette
from bodyschema.vision.poses import piece_poses
from bodyschema.vision.surface import Surface
from imagined_hand import BETA, posture, shifted

pytest.importorskip("mujoco")
pytest.importorskip("icub_models")
pytest.importorskip("trimesh")

pytestmark = pytest.mark.usefixtures("offscreen")

OFFSETS = dict(zip(icub.RIGHT_ARM, BETA, strict=True))


def test_it_stands_where_reading_plus_offset_is() -> None:
    robot: Robot = SeeingIcub(OFFSETS)
    q = posture()
    robot.command(q)
    np.testing.assert_array_equal(robot.read(), q)
    assert isinstance(robot, SeeingIcub)
    expected = relative_pose(icub.nominal_icub(), shifted(q, BETA), icub.LEFT_EYE, icub.HAND)
    np.testing.assert_allclose(robot.true_pose(icub.LEFT_EYE, icub.HAND), expected, atol=1e-6)


def test_its_masks_are_those_of_the_other_renderer() -> None:
    """The kernel that imagines has no part in these images, and agrees with all their pixels."""
    robot, body = SeeingIcub(OFFSETS), icub.nominal_icub()
    surface = Surface.of(body, SEEN_LINKS, 0)
    for step in (0.0, 1.0):
        q = posture(step)
        robot.command(q)
        seen = robot.look()
        assert robot.hidden_share() == 0
        poses = piece_poses(body, shifted(q, BETA), stereo_eyes(), surface.frames)[0]
        for T, camera, picture in zip(poses, seen.cameras, seen.pictures, strict=True):
            own = silhouette(surface, T, camera)
            assert picture.sum() > 3000
            assert np.count_nonzero(own != picture) <= 0.001 * picture.sum()


def test_masks_tell_one_arm_from_the_other() -> None:
    both = SeeingIcub(OFFSETS, links=[*SEEN_LINKS, *LEFT_LINKS])
    q = posture()
    for right, left in zip(icub.RIGHT_ARM, icub.LEFT_ARM, strict=True):
        q[both.joints.index(left)] = q[both.joints.index(right)]
    q[both.joints.index("neck_yaw")] = 0.0
    both.command(q)
    looks = [both.look(links).pictures for links in (SEEN_LINKS, LEFT_LINKS, None)]
    for right, left, whole in zip(*looks, strict=True):
        assert min(right.sum(), left.sum()) > 1000
        assert not (right & left).any()
        np.testing.assert_array_equal(right | left, whole)
    both.command(posture())
    assert (both.look().pictures[0] != looks[2][0]).any()


def test_before_clutter_it_sees_colours_and_edges_that_are_not_its_own() -> None:
    robot, plain = SeeingIcub(OFFSETS, "cluttered"), SeeingIcub(OFFSETS)
    for each in (robot, plain):
        each.command(posture())
    image, mask = robot.look().pictures[0], plain.look().pictures[0]
    assert image.shape == (240, 320, 3)
    assert image.dtype == np.uint8
    behind = image[~mask].astype(float)
    assert (behind.max(axis=1) - behind.min(axis=1)).mean() > 20  # coloured
    assert behind.std() > 20
    again = robot.look()
    np.testing.assert_array_equal(again.pictures[0], image)
    assert again.time == 1


def test_bad_commands_move_nothing_and_unknown_joints_are_refused() -> None:
    robot = SeeingIcub({})
    before = robot.read()
    beyond = before.copy()
    beyond[robot.joints.index("r_elbow")] = 3.0
    with pytest.raises(InputError, match=r"'r_elbow' was sent to 3\.000"):
        robot.command(beyond)
    with pytest.raises(InputError, match="joint positions"):
        robot.command(before[:3])
    np.testing.assert_array_equal(robot.read(), before)
    with pytest.raises(InputError, match="'r_elbw'"):
        SeeingIcub({"r_elbw": 0.1})
