"""The next posture for eyes: it can be reached, is in view, and tells more than most."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import bodyschema as bs
from bodyschema.acting.telling_posture import telling_posture
from bodyschema.learners.images.rim_information import LEAST_EFFECT, without
from bodyschema.senses.images import Images
from bodyschema.vision.contours import silhouette
from bodyschema.vision.poses import piece_poses
from small_arm import CAMERA, POSTURES, write_arm

pytest.importorskip("trimesh")


def test_it_is_better_than_most_postures(tmp_path: Path) -> None:
    body = write_arm(tmp_path)
    surface, q = bs.Surface.of(body), POSTURES[[0, 0, 0]] + [[0.0, 0], [0.01, 0], [0, 0.01]]
    poses = piece_poses(body, q, [CAMERA], surface.frames)[:, 0]
    frames = [
        Images(0.0, row, (CAMERA,), (silhouette(surface, pose, CAMERA),))
        for row, pose in zip(q, poses, strict=True)
    ]
    free = bs.free_joints(body, ["offsets"]).with_prior(np.full(2, 0.1))
    fit = bs.Markerless(surface, seeds=0).fit(body, free, frames)
    found = telling_posture(fit, (CAMERA,), q)
    assert found is not None
    assert ((body.lower <= found.q) & (found.q <= body.upper)).all()
    assert (found.then < found.std).all()

    def then(row: np.ndarray) -> float:
        """What is left of the uncertainty, in units of the prior."""
        H = without(fit.model.imagined((CAMERA,), row, fit.z) / LEAST_EFFECT, fit.model.scale, 2)
        left = np.linalg.inv(fit.estimate.information + H)
        return float(np.trace(left / 0.1**2))

    others = [then(row) for row in np.random.default_rng(5).uniform(-1.5, 1.5, (20, 2))]
    assert then(found.q) < np.quantile(others, 0.2)


def test_there_is_none_where_the_cameras_see_nothing(tmp_path: Path) -> None:
    body = write_arm(tmp_path)
    away = bs.Camera("eye", "eye", 320, 240, np.array([[9e4, 0, 0], [0, 9e4, 0], [0, 0, 1.0]]))
    surface, q = bs.Surface.of(body), POSTURES[:1]
    nothing = np.zeros((240, 320), dtype=bool)
    free = bs.free_joints(body, ["offsets"]).with_prior(np.full(2, 0.1))
    seen = Images(0.0, q[0], (away,), (nothing,))
    fit = bs.Markerless(surface, seeds=0).fit(body, free, [seen])
    assert telling_posture(fit, (away,), q) is None
