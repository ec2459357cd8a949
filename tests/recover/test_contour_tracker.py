"""A stream of pictures: the first finds the arm, each adds, a lost arm is said and found again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema.learners.images.contour_tracker import ContourTracker, TrackInfo, TrackState
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.images import Images
from bodyschema.simulation import icub
from bodyschema.vision.contours import silhouette
from bodyschema.vision.poses import piece_poses
from icub_arm import arm, eyes, readings

pytest.importorskip("cv2")

Array = NDArray[np.float64]

BODY = icub.nominal_icub()
OFFSETS = bs.free_joints(BODY, ["offsets"], icub.RIGHT_ARM)
TRUTH = np.deg2rad([5, 4, 3, -2, 3, -7, 3])
TRACKER = ContourTracker(arm(), seeds=128, keys=3)


def stream(n: int) -> list[Images]:
    """Masks on the way from one posture to another."""
    body, cameras = BODY.with_variables(OFFSETS, TRUTH), tuple(eyes())
    start, end = readings(20)[[4, 9]]
    frames = []
    for i, q in enumerate(np.linspace(start, end, n)):
        T = piece_poses(body, q, cameras, arm().frames)[0]
        masks = tuple(silhouette(arm(), pose, c) for pose, c in zip(T, cameras, strict=True))
        frames.append(Images(float(i), q, cameras, masks))
    return frames


def follow(frames: list[Images]) -> tuple[TrackState, list[TrackInfo]]:
    state, infos = TRACKER.start(BODY, icub.RIGHT_ARM), []
    for seen in frames:
        state, (info,) = TRACKER.step(state, (seen,))
        infos.append(info)
    return state, infos


def hand_error(offsets: Array, q: Array) -> float:
    """mm"""
    a, b = (
        relative_pose(BODY.with_variables(OFFSETS, x), q, icub.LEFT_EYE, icub.HAND)[:3, 3]
        for x in (offsets, TRUTH)
    )
    return 1e3 * float(np.linalg.norm(a - b))


def test_the_hand_is_known_at_once_and_the_offsets_after_a_while() -> None:
    frames = stream(8)
    state, infos = follow(frames)
    assert hand_error(np.zeros(7), frames[0].q) > 20
    assert hand_error(infos[0].offsets, frames[0].q) < 1
    assert np.abs(infos[-1].offsets - TRUTH).max() < np.deg2rad(0.5)
    assert np.trace(infos[-1].covariance) < np.trace(infos[0].covariance)
    off = infos[-1].offsets - TRUTH
    assert off @ np.linalg.solve(infos[-1].covariance, off) < 7 * 9
    assert not any(info.lost for info in infos)
    assert len(state.hypotheses[0].keys) == 3
    assert not any(info.ambiguous for info in infos)


def test_a_hidden_hand_is_lost_teaches_nothing_and_is_found_again() -> None:
    frames = stream(4)
    hidden = [
        replace(seen, pictures=tuple(np.zeros_like(mask) for mask in seen.pictures))
        for seen in frames[1:3]
    ]
    _, infos = follow([frames[0], *hidden, frames[3]])
    assert [info.lost for info in infos] == [False, True, True, False]
    for info in infos[1:3]:
        assert (info.offsets == infos[0].offsets).all()
    assert (infos[2].covariance == infos[1].covariance).all()
    assert hand_error(infos[3].offsets, frames[3].q) < 1


def test_images_without_the_hand_are_lost_again_and_again() -> None:
    tracker = ContourTracker(arm(), seeds=32)
    wall = np.full((240, 320, 3), 90, np.uint8)
    wall[150:, :] = (60, 120, 40)
    state = tracker.start(BODY, icub.RIGHT_ARM)
    for seen in stream(2):
        state, (info,) = tracker.step(state, (replace(seen, pictures=(wall, wall)),))
        assert info.lost
        assert np.isfinite(info.covariance).all()


def test_the_same_pictures_give_the_same_answer() -> None:
    (_, first), (_, second) = follow(stream(3)), follow(stream(3))
    assert first[-1].offsets.tobytes() == second[-1].offsets.tobytes()
