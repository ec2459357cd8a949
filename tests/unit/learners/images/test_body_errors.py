"""What beta means: shifted joints, or a transform at the hand."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.learners.published.body_errors import ARM, CartesianError, JointOffsets
from bodyschema.model.kinematics import relative_pose
from bodyschema.simulation import icub
from bodyschema.vision.poses import piece_poses
from imagined_hand import eyes, posture, shifted

pytest.importorskip("icub_models")
pytest.importorskip("trimesh")

BODY = icub.nominal_icub()
FRAMES = ("r_forearm", "r_hand")


def test_joint_offsets_add_to_the_readings() -> None:
    beta = 0.1 * np.random.default_rng(0).normal(size=(4, 7))
    error, q = JointOffsets(icub.RIGHT_ARM), posture()
    found = error.piece_poses(BODY, q, beta, eyes(), FRAMES)
    for hypothesis, T in zip(beta, found, strict=True):
        expected = piece_poses(BODY, shifted(q, hypothesis), eyes(), FRAMES)[0]
        np.testing.assert_allclose(T, expected, atol=1e-12)
    T_hand = error.hand_poses(BODY, q, beta, icub.LEFT_EYE, icub.HAND)
    np.testing.assert_allclose(T_hand, found[:, 0, 1], atol=1e-12)


def test_cartesian_errors_stand_behind_the_kinematics() -> None:
    """T = K(theta) T_err for the hand; what else is seen moves along rigidly."""
    beta = 0.1 * np.random.default_rng(1).normal(size=(3, 6))
    error, q = CartesianError(icub.HAND), posture()
    T_err = lie.transform(lie.exp_so3(beta[:, 3:]), ARM * beta[:, :3])
    K = relative_pose(BODY, q, icub.LEFT_EYE, icub.HAND)
    found = error.piece_poses(BODY, q, beta, eyes(), FRAMES)
    np.testing.assert_allclose(found[:, 0, 1], K @ T_err, atol=1e-12)
    plain = piece_poses(BODY, q, eyes(), FRAMES)[0]
    for c in range(2):
        apart = lie.inverse(found[:, c, 1]) @ found[:, c, 0]
        unmoved = np.broadcast_to(lie.inverse(plain[c, 1]) @ plain[c, 0], apart.shape)
        np.testing.assert_allclose(apart, unmoved, atol=1e-12)
    T_hand = error.hand_poses(BODY, q, beta, icub.LEFT_EYE, icub.HAND)
    np.testing.assert_allclose(T_hand, K @ T_err, atol=1e-12)
