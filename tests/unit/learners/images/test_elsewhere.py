"""A camera that stands elsewhere than it is said to is doubted; one that stands there is not."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import lie
from bodyschema.estimation.estimate import Estimate
from bodyschema.learners.images.elsewhere import (
    ROUGHLY,
    UNLIKELY,
    Elsewhere,
    _surprise,
    elsewhere,
)
from bodyschema.learners.images.markerless import Markerless
from bodyschema.learners.images.markerless_fit import MarkerlessFit
from bodyschema.senses.images import Images
from bodyschema.simulation import icub
from bodyschema.vision.contours import silhouette
from bodyschema.vision.poses import piece_poses
from icub_arm import arm, eyes, readings

pytest.importorskip("cv2")

Array = NDArray[np.float64]

BODY = icub.nominal_icub()
OFFSETS = bs.free_joints(BODY, ["offsets"], icub.RIGHT_ARM).with_prior(np.full(7, 0.1))
POSTURES = (0, 4, 9, 14, 17)
LEARNER = Markerless(arm(), seeds=0)


@cache
def looked(shift: float) -> tuple[MarkerlessFit, list[Images], Elsewhere]:
    """Fitted to pictures of a left eye that stands so many m and rad beside its place."""
    T = BODY.placement[BODY.frame_index(icub.LEFT_EYE)]
    aside = lie.transform(lie.exp_so3(np.array([0.0, 0.0, shift])), [shift, 0.0, 0.0])
    truth = 0.02 * np.array([1.0, -1.0, 1.0, 1.0, -1.0, 1.0, -1.0])
    built = BODY.with_placement(icub.LEFT_EYE, T @ aside).with_variables(OFFSETS, truth)
    frames = []
    for i in POSTURES:
        q = readings(20)[i]
        poses = piece_poses(built, q, eyes(), arm().frames)[0]
        shown = tuple(silhouette(arm(), pose, c) for pose, c in zip(poses, eyes(), strict=True))
        frames.append(Images(float(i), q, tuple(eyes()), shown))
    fit = LEARNER.fit(BODY, OFFSETS, frames)
    found = elsewhere(LEARNER, fit, frames)
    assert found is not None
    return fit, frames, found


def test_cameras_where_they_are_said_to_be_are_not_doubted() -> None:
    found = looked(0.0)[2]
    assert not found.doubted
    assert found.p_value > UNLIKELY
    assert found.freedom > 6
    assert not found.rivals


def test_a_camera_elsewhere_is_doubted_and_found_there() -> None:
    fit, _, found = looked(0.01)
    assert found.doubted
    assert found.cameras == (icub.LEFT_EYE, icub.RIGHT_EYE)
    assert found.left < fit.disagreement.contradiction
    assert found.left < min(found.rivals.values())
    assert set(found.rivals) == {"lens", "meshes"}
    # Both eyes may move, so that the shift of one against the other is what is told.
    at = [found.estimate.variables.names.index(f"{e}.turn_z") for e in found.cameras]
    x = found.estimate.x[at]
    assert np.ptp(x) == pytest.approx(0.01, rel=0.3)


def test_a_camera_that_is_looked_for_anyway_is_not_freed_again() -> None:
    fit, frames, _ = looked(0.0)
    wanted = bs.join(
        OFFSETS, *(bs.free_frame(BODY, eye, *ROUGHLY) for eye in (icub.LEFT_EYE, icub.RIGHT_EYE))
    )
    known = LEARNER.fit(BODY, wanted, frames)
    assert elsewhere(LEARNER, known, frames) is None
    assert elsewhere(LEARNER, fit, frames) is not None


def test_the_surprise_is_chi_square_over_what_the_pictures_tell() -> None:
    rng, turn = np.random.default_rng(2), 0.002
    variables = bs.join(OFFSETS, bs.free_frame(BODY, icub.LEFT_EYE, *ROUGHLY))
    n, scale = len(variables), variables.scale
    A = rng.normal(size=(60, n)) / scale
    A[:, 0] = 0.0
    H: Array = np.asarray(30.0 * A.T @ A, dtype=np.float64)
    told, squares = 0, []
    for _ in range(300):
        true = np.zeros(n)
        true[:7] = scale[:7] * rng.normal(size=7)
        true[10:13] = turn * rng.normal(size=3)
        seen = H @ true + np.linalg.cholesky(H + 1e-9 * np.eye(n)) @ rng.normal(size=n)
        x = np.linalg.solve(H + np.diag(scale**-2.0), seen)
        square, told = _surprise(Estimate(BODY, variables, x, H), [icub.LEFT_EYE], turn)
        squares.append(square)
    assert told == 6
    assert np.mean(squares) == pytest.approx(told, rel=0.15)
