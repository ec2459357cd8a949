"""What cameras and meshes may have wrong: slopes, priors, and what is taken at its word."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema.learners.images.doubts import PER_CAMERA, Doubts, corrected
from bodyschema.learners.images.rim_fit import Normal, RimModel
from bodyschema.learners.images.rim_information import without
from bodyschema.simulation import icub
from bodyschema.vision.correspondences import find_rim, outward_gain
from bodyschema.vision.patches import Patches
from bodyschema.vision.poses import piece_poses
from imagined_hand import eyes, hand, posture

Array = NDArray[np.float64]

BODY = icub.nominal_icub()
OFFSETS = bs.free_joints(BODY, ["offsets"], icub.RIGHT_ARM)


FEW_PATCHES = Doubts(patches=5)


def model(doubts: Doubts = FEW_PATCHES) -> RimModel:
    return RimModel.of(hand(), BODY, OFFSETS, eyes(), doubts)


def sphere(radius: float) -> bs.Surface:
    trimesh = pytest.importorskip("trimesh")
    ball = trimesh.creation.icosphere(4, radius)
    return bs.Surface.build({"ball": (ball.vertices, ball.faces)})


def test_slopes_of_the_lens_are_those_of_the_points_of_the_outline() -> None:
    m, step = model(), 1e-6
    z = 0.3 * m.scale
    rim, J = m.outline(eyes(), posture(), z)
    T = piece_poses(m.posed(z), posture(), eyes(), hand().frames)[0][rim.camera, rim.piece]
    X = np.einsum("nij,nj->ni", T[:, :3, :3], rim.point) + T[:, :3, 3]
    n = len(m.variables)
    for c in range(2):
        mine = rim.camera == c
        for k in (1, 2, 3):
            column = n + PER_CAMERA * c + k
            h = np.zeros(len(z))
            h[column] = step
            pixels = [m.cameras(eyes(), z + sign * h)[c].project(X[mine]) for sign in (1, -1)]
            slope = np.sum(rim.normal[mine] * (pixels[0] - pixels[1]), axis=1) / (2 * step)
            np.testing.assert_allclose(J[mine, column], slope, rtol=1e-6, atol=1e-6)
            assert not J[~mine, column].any()


def test_a_thicker_ball_has_a_wider_outline() -> None:
    camera = eyes()[0]
    T = np.eye(4)[None, None]
    T[0, 0, 2, 3] = 0.3

    def width(radius: float) -> tuple[float, Array]:
        ball = sphere(radius)
        rim = find_rim(ball, T[:, :, :3], [camera])
        away = np.linalg.norm(rim.pixel - camera.intrinsics[2:], axis=1)
        return float(np.average(away, weights=rim.length)), outward_gain(rim, T, [camera])

    wide, gain = width(0.0402)
    narrow, _ = width(0.0398)
    np.testing.assert_allclose((wide - narrow) / 0.0004, gain.mean(), rtol=0.01)


def test_a_point_belongs_to_the_nearest_centre_of_its_piece() -> None:
    patches = Patches.of(hand(), 7)
    assert len(patches) == 14
    T = piece_poses(BODY, posture(), eyes(), hand().frames)[0]
    rim = find_rim(hand(), T, eyes())
    found = patches.of_rim(rim)
    for i in range(0, len(rim), 20):
        away = np.linalg.norm(patches.centres[rim.piece[i]] - rim.point[i], axis=1)
        assert found[i] == 7 * rim.piece[i] + int(np.argmin(away))
    assert len(Patches.of(hand(), 0)) == 0


def test_every_row_has_one_patch_and_the_unknowns_of_one_camera() -> None:
    m = model()
    rim, J = m.outline(eyes(), posture(), np.zeros(len(m.scale)))
    doubted = J[:, len(m.variables) :]
    own = doubted[:, : 2 * PER_CAMERA].reshape(-1, 2, PER_CAMERA)
    assert (own[np.arange(len(rim)), rim.camera, 0] == 1).all()
    assert not own[np.arange(len(rim)), 1 - rim.camera].any()
    assert (np.count_nonzero(doubted[:, 2 * PER_CAMERA :], axis=1) == 1).all()


def test_turns_are_of_cameras_that_are_not_looked_for_anyway() -> None:
    turns = Doubts().turns(BODY, OFFSETS, eyes())
    assert [name.split(".")[0] for name in turns.names] == ["left_eye"] * 3 + ["right_eye"] * 3
    np.testing.assert_allclose(turns.prior_std, np.deg2rad(0.1))
    mounted = bs.join(OFFSETS, bs.free_frame(BODY, icub.LEFT_EYE))
    assert {name.split(".")[0] for name in Doubts().turns(BODY, mounted, eyes()).names} == {
        "right_eye"
    }
    assert len(Doubts(turn=0.0).turns(BODY, OFFSETS, eyes())) == 0


def test_a_focal_length_stretches_about_the_centre() -> None:
    y = np.array([9.0, np.log(1.01), 2.0, -1.0, 9.0, 0.0, 0.0, 0.0])
    left, right = corrected(eyes(), y)
    f, c = eyes()[0].intrinsics[:2], eyes()[0].intrinsics[2:]
    np.testing.assert_allclose(left.intrinsics, [*(1.01 * f), c[0] + 2, c[1] - 1])
    assert (right.matrix == eyes()[1].matrix).all()


def test_what_is_taken_at_its_word_stays_zero() -> None:
    m = model(Doubts(focal=0, centre=0, turn=0, shape=0, edge=0))
    rng = np.random.default_rng(0)
    A = rng.normal(size=(40, len(m.scale)))
    z = m.solve([Normal(A.T @ A, A.T @ rng.normal(size=40))])
    assert len(m.patches) == 0
    assert z[:7].all()
    assert not z[7:].any()


def test_information_without_the_others_is_that_of_the_joint_covariance() -> None:
    rng = np.random.default_rng(1)
    A, scale = rng.normal(size=(30, 6)), np.array([1, 1, 1, 0.3, 2.0, 0.1])
    joint = A.T @ A + np.diag([0, 0, 0, *scale[3:] ** -2])
    np.testing.assert_allclose(
        np.linalg.inv(without(A.T @ A, scale, 3)), np.linalg.inv(joint)[:3, :3], rtol=1e-9
    )
    known = without(A.T @ A, np.array([1, 1, 1, 0, 0, 0]), 3)
    np.testing.assert_allclose(known, (A.T @ A)[:3, :3], rtol=1e-12)


@pytest.mark.parametrize("wrong", [{"focal": -0.1}, {"shape": np.nan}])
def test_a_doubt_is_a_standard_deviation(wrong: dict[str, float]) -> None:
    with pytest.raises(bs.InputError, match="standard deviation, 0 or more"):
        Doubts(**wrong)
