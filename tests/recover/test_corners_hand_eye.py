"""From pictures of a hand to where the camera stands: corners, then the learner of hand and eye."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("cv2")

from bodyschema import lie
from bodyschema.learners.hand_eye.belief import theta_of
from bodyschema.learners.hand_eye.points import HandEyePoints
from bodyschema.learners.hand_eye.stereo_points import StereoPoints
from bodyschema.vision.corners import CornerTracker
from seen_patch import PLATE, STEREO, sights, world_camera


def test_the_camera_is_found_from_pictures_alone():
    tracker, state, learner, belief = CornerTracker(count=8), None, None, None
    for sight in sights(1, 150):
        if state is None:
            state = tracker.start(sight.left, sight.mask, sight.right)
            learner = HandEyePoints(STEREO, points=len(state.place))
            belief = learner.start()
        else:
            state = tracker.step(state, sight.left, sight.right)
        belief, _ = learner.step(
            belief, (StereoPoints(sight.time, sight.T_world_hand, state.pixels),)
        )
    theta, truth = theta_of(belief), world_camera(1)
    turn = np.linalg.norm(lie.log_so3(theta.T_world_cam[:3, :3].T @ truth[:3, :3]))
    away = np.linalg.norm(theta.T_world_cam[:3, 3] - truth[:3, 3])
    bounds = learner.certificate(belief).bounds
    assert np.rad2deg(turn) < 0.1
    assert away < 1e-3
    assert turn < bounds["rotation"]
    assert away < bounds["camera"]
    np.testing.assert_allclose(theta.points[:, 2], PLATE[2], atol=2e-3)
