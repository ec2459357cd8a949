"""The pose of the hand in a picture, its covariance, and whether it is the hand."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema.learners.images.hand_track import HandTracker, hand_pose
from bodyschema.learners.images.markerless import Markerless
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.images import Images
from bodyschema.simulation import icub
from bodyschema.vision.contours import silhouette
from bodyschema.vision.poses import piece_poses
from imagined_hand import eyes, hand, masks, posture, shifted

pytest.importorskip("cv2")

Array = NDArray[np.float64]

BODY = icub.nominal_icub()
OFFSETS = bs.free_joints(BODY, ["offsets"], icub.RIGHT_ARM).with_prior(np.full(7, 0.05))
BETA = np.array([0.02, -0.01, 0.015, 0.01, -0.02, 0.01, 0.015])


@cache
def tracker() -> HandTracker:
    frames = [masks(posture(step), BETA) for step in (0.0, 0.5, 1.0)]
    fit = Markerless(hand(), seeds=0).fit(BODY, OFFSETS, frames)
    return HandTracker.of(fit, frames, icub.HAND)


def forearm_alone(q: Array) -> Images:
    """Masks in which the hand is covered and the forearm is not."""
    T = piece_poses(BODY, shifted(q, BETA), eyes(), hand().frames)[0]
    covered = bs.Surface.of(BODY, ["r_hand"], 150)
    k = hand().frames.index(covered.frames[0])
    pictures = tuple(
        silhouette(hand(), pose, eye) & ~silhouette(covered, pose[k : k + 1], eye)
        for pose, eye in zip(T, eyes(), strict=True)
    )
    return replace(masks(q, BETA), pictures=pictures)


def test_the_hand_is_found_where_it_is() -> None:
    q = posture(0.3)
    found = tracker().look(masks(q, BETA))
    true = relative_pose(BODY, shifted(q, BETA), icub.LEFT_EYE, icub.HAND)
    assert not found.lost
    assert found.matched > 0.9
    assert found.residual < 0.5
    off = found.pose[:3, 3] - true[:3, 3]
    assert off @ np.linalg.solve(found.covariance[:3, :3], off) < 16


def test_a_hand_that_is_covered_is_lost_although_the_forearm_shows() -> None:
    seen = forearm_alone(posture(0.3))
    assert all(picture.any() for picture in seen.pictures)
    assert tracker().look(seen).lost


def test_the_covariance_of_the_pose_is_that_of_poses_of_sampled_bodies() -> None:
    whole, q = tracker().fit.whole, posture(0.3)
    T, P = hand_pose(whole, q, icub.LEFT_EYE, icub.HAND)
    x = np.random.default_rng(0).multivariate_normal(whole.x, whole.covariance, 1500)
    places = np.array(
        [
            relative_pose(whole.reference.with_variables(whole.variables, row), q,
                          icub.LEFT_EYE, icub.HAND)[:3, 3]
            for row in x
        ]
    )  # fmt: skip
    np.testing.assert_allclose(places.mean(axis=0), T[:3, 3], atol=1e-4)
    # Four standard errors of a covariance from so many draws.
    size = np.sqrt(np.outer(np.diag(P)[:3], np.diag(P)[:3]) + P[:3, :3] ** 2)
    assert (np.abs(np.cov(places.T) - P[:3, :3]) < 4 / np.sqrt(len(x)) * size).all()
