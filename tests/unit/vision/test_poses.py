"""Poses of the pieces before the cameras: those of the kinematics, for every hypothesis."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.model.camera import Camera
from bodyschema.model.kinematics import relative_pose
from bodyschema.simulation import icub
from bodyschema.vision.poses import piece_poses
from icub_arm import LINKS, eyes


def test_poses_are_those_of_the_kinematics() -> None:
    body = icub.nominal_icub()
    q = np.random.default_rng(0).uniform(-0.5, 0.5, size=(5, len(body.joints)))
    T = piece_poses(body, q, eyes(), LINKS)
    assert T.shape == (5, 2, 3, 4, 4)
    for c, camera in enumerate(eyes()):
        for b, link in enumerate(LINKS):
            expected = relative_pose(body, q, camera.frame, link)
            np.testing.assert_allclose(T[:, c, b], expected, atol=1e-14)


def test_a_camera_may_ride_on_what_it_sees_or_stand_in_the_world() -> None:
    body = icub.nominal_icub()
    q = np.random.default_rng(1).uniform(-0.5, 0.5, size=(3, len(body.joints)))
    for frame in ("r_forearm", body.frames[0]):
        camera = Camera.from_fov("c", frame, 32, 24, 1.0)
        T = piece_poses(body, q, [camera], ["r_hand"])
        np.testing.assert_allclose(T[:, 0, 0], relative_pose(body, q, frame, "r_hand"), atol=1e-14)


def test_a_single_row_is_one_hypothesis() -> None:
    body = icub.nominal_icub()
    assert piece_poses(body, np.zeros(len(body.joints)), eyes(), LINKS).shape == (1, 2, 3, 4, 4)


def test_wrong_shapes_and_names_are_refused() -> None:
    body = icub.nominal_icub()
    with pytest.raises(InputError, match="expected joint positions"):
        piece_poses(body, np.zeros((2, 3)), eyes(), LINKS)
    with pytest.raises(InputError, match="'r_hand'"):
        piece_poses(body, np.zeros(len(body.joints)), eyes(), ["r_hnd"])
