"""A finger on two joints shows its tip alone: one picture leaves two postures, a few leave one."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import lie
from bodyschema.learners.images.contour_tracker import ContourTracker, TrackInfo
from bodyschema.learners.images.doubts import Doubts
from bodyschema.learners.images.hypothesis import weights
from bodyschema.model.kernels import FIXED, REVOLUTE
from bodyschema.senses.images import Images
from bodyschema.vision.contours import silhouette
from bodyschema.vision.poses import piece_poses

pytest.importorskip("cv2")

Array = NDArray[np.float64]

LINK = 0.1
"""m, of both links."""
TRUTH = np.array([0.25, -0.3])
"""rad"""


@cache
def finger() -> tuple[bs.Body, bs.Surface, bs.Camera]:
    """Two links in the plane of the image, of which a ball at the tip can be seen."""
    trimesh = pytest.importorskip("trimesh")
    out = lie.transform(np.eye(3), [LINK, 0, 0])
    body = bs.Body.build(
        "finger", ["base", "upper", "lower", "tip"], ["", "a", "b", "end"], [-1, 0, 1, 2],
        [FIXED, REVOLUTE, REVOLUTE, FIXED], [(0, 0, 1)] * 4,
        np.array([np.eye(4), np.eye(4), out, out]),
    )  # fmt: skip
    body = body.attach("eye", "base", lie.transform(np.eye(3), [0.0, 0.0, -0.5]))
    ball = trimesh.creation.icosphere(3, 0.02)
    surface = bs.Surface.build({"tip": (ball.vertices, ball.faces)})
    return body, surface, bs.Camera.from_fov("eye", "eye", 160, 120, 1.2)


def look(q: Array) -> Images:
    body, surface, camera = finger()
    T = piece_poses(body, q + TRUTH, [camera], surface.frames)[0, 0]
    return Images(0.0, q, (camera,), (silhouette(surface, T, camera),))


def watch(postures: Array) -> tuple[list[TrackInfo], list[int]]:
    body, surface, _ = finger()
    exact = Doubts(focal=0, centre=0, turn=0, shape=0)
    tracker = ContourTracker(surface, seeds=256, prior=1.2, doubts=exact)
    state, infos, left = tracker.start(body, ["a", "b"]), [], []
    for q in postures:
        state, (info,) = tracker.step(state, (look(q),))
        infos.append(info)
        left.append(len(state.hypotheses))
        np.testing.assert_allclose(weights(state.hypotheses).sum(), 1)
    return infos, left


def test_one_picture_leaves_two_postures_and_says_so() -> None:
    (info,), _ = watch(np.array([[0.4, 1.2]]))
    assert info.ambiguous
    assert 1 < info.effective_size <= 2.01
    assert not info.lost
    # The other posture folds the finger the other way, 1.8 rad off in its second joint.
    assert np.sqrt(info.covariance[1, 1]) > 0.2


def test_more_pictures_leave_the_true_one() -> None:
    postures = np.column_stack([np.linspace(0.4, 0.1, 6), np.linspace(1.2, 0.6, 6)])
    infos, left = watch(postures)
    assert left[-1] == 1
    assert not infos[-1].ambiguous
    assert infos[-1].effective_size == 1
    assert np.abs(infos[-1].offsets - TRUTH).max() < 0.02
    assert np.sqrt(infos[-1].covariance[1, 1]) < 0.02
