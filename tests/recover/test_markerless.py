"""Pictures of an arm tell its joint offsets, how sure that is, and when it is not the arm."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import lie
from bodyschema.acting.servoing import pose_error
from bodyschema.learners.images.doubts import Doubts
from bodyschema.learners.images.hand_track import hand_pose
from bodyschema.learners.images.markerless import Markerless
from bodyschema.learners.images.markerless_fit import MarkerlessFit
from bodyschema.model.kinematics import relative_pose
from bodyschema.seeds.image_seeds import best_apart, coarse, sobol_seeds, spread_out
from bodyschema.senses.images import Images, Picture
from bodyschema.simulation import icub
from bodyschema.vision.contours import silhouette
from bodyschema.vision.poses import piece_poses
from icub_arm import arm, eyes, readings

pytest.importorskip("cv2")

Array = NDArray[np.float64]

BODY = icub.nominal_icub()
OFFSETS = bs.free_joints(BODY, ["offsets"], icub.RIGHT_ARM).with_prior(np.full(7, 0.1))
POSTURES = (0, 4, 9, 14, 17)


HAND = bs.Surface.of(BODY, ["r_hand"])


def look(truth: Array, n: int, shown: bs.Surface | None = None) -> list[Images]:
    """Masks of an arm that deviates by the truth."""
    skin = arm() if shown is None else shown
    body, cameras = BODY.with_variables(OFFSETS, truth), tuple(eyes())
    frames = []
    for i in POSTURES[:n]:
        q = readings(20)[i]
        T = piece_poses(body, q, cameras, skin.frames)[0]
        masks = tuple(silhouette(skin, pose, c) for pose, c in zip(T, cameras, strict=True))
        frames.append(Images(float(i), q, cameras, masks))
    return frames


def learn(frames: list[Images], free: bs.Variables = OFFSETS) -> MarkerlessFit:
    return Markerless(arm(), seeds=128, refined=4).fit(BODY, free, frames)


@pytest.mark.parametrize("seed", range(4))
def test_offsets_of_some_degrees_come_back_within_their_error_bars(seed: int) -> None:
    truth = np.random.default_rng(seed).uniform(-0.15, 0.15, 7)
    fit = learn(look(truth, 5))
    off = (fit.estimate.x - truth) / fit.estimate.std
    assert np.abs(fit.estimate.x - truth).max() < np.deg2rad(0.5)
    assert off @ off < 7 * 9
    assert fit.estimate.std.max() < np.deg2rad(0.5)
    assert fit.identifiability.rank == 7
    assert fit.iou > 0.97
    assert not fit.lost


def test_one_posture_leaves_the_motion_open_in_which_the_hand_stands_still() -> None:
    fit = Markerless(HAND, seeds=0).fit(BODY, OFFSETS, look(np.full(7, 0.03), 1, HAND))
    assert fit.identifiability.rank < 7
    assert not any(d.inherent for d in fit.identifiability.directions)


def test_a_mask_that_is_too_wide_moves_the_bias_and_not_the_joints() -> None:
    import cv2

    truth = np.random.default_rng(5).uniform(-0.1, 0.1, 7)

    def wider(mask: Picture) -> Picture:
        return np.asarray(cv2.dilate(mask.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0)

    frames = [replace(f, pictures=tuple(map(wider, f.pictures))) for f in look(truth, 5)]
    fit = learn(frames)
    assert np.abs(fit.estimate.x - truth).max() < np.deg2rad(0.7)
    assert (fit.bias > 0.5).all()


@pytest.mark.parametrize("what", ["nothing", "a box", "half a hand"])
def test_what_is_not_the_arm_is_lost(what: str) -> None:
    def replaced(mask: Picture) -> Picture:
        other = mask.copy() if what == "half a hand" else np.zeros_like(mask)
        if what == "a box":
            other[60:140, 90:200] = True
        if what == "half a hand":
            other[:, int(np.median(np.nonzero(mask)[1])) :] = False
        return other

    frames = [replace(f, pictures=tuple(map(replaced, f.pictures))) for f in look(np.zeros(7), 2)]
    assert learn(frames).lost


def wrong_cameras(seed: int) -> tuple[bs.Body, tuple[bs.Camera, ...]]:
    """Lenses and eyes that are wrong as the doubts say."""
    rng, body, cameras = np.random.default_rng(seed), BODY, []
    for camera in eyes():
        K = camera.matrix.copy()
        K[[0, 1], [0, 1]] *= 1 + 0.005 * rng.normal()
        K[:2, 2] += rng.normal(size=2)
        cameras.append(replace(camera, matrix=K))
        turn = lie.transform(lie.exp_so3(np.deg2rad(0.1) * rng.normal(size=3)), np.zeros(3))
        T = body.placement[body.frame_index(camera.frame)]
        body = body.with_placement(camera.frame, T @ turn)
    return body, tuple(cameras)


def error_of_the_hand(doubts: Doubts, seed: int) -> tuple[float, float]:
    """Normalised squared error of its pose in the first posture, and mm."""
    truth = np.random.default_rng(seed).uniform(-0.05, 0.05, 7)
    body, cameras = wrong_cameras(seed)
    frames = look(truth, 5)
    believed = [replace(seen, cameras=cameras) for seen in frames]
    fit = Markerless(arm(), seeds=0, doubts=doubts).fit(body, OFFSETS, believed)
    T, P = hand_pose(fit.whole, frames[0].q, icub.LEFT_EYE, icub.HAND)
    posed = BODY.with_variables(OFFSETS, truth)
    e = pose_error(relative_pose(posed, frames[0].q, icub.LEFT_EYE, icub.HAND), T)
    return float(e @ np.linalg.solve(P, e)), 1e3 * float(np.linalg.norm(e[:3]))


def test_who_doubts_the_lens_is_off_by_as_much_as_is_said() -> None:
    exact = Doubts(focal=0, centre=0, turn=0, shape=0)
    doubting = np.array([error_of_the_hand(Doubts(), seed) for seed in range(3)])
    trusting = np.array([error_of_the_hand(exact, seed) for seed in range(2)])
    # 18 degrees of freedom together; 0.999 of their sum lies below 42.
    assert doubting[:, 0].sum() < 42
    assert trusting[:, 0].min() > 42
    assert doubting[:2, 1].mean() < trusting[:, 1].mean()


def test_colours_take_the_place_of_masks() -> None:
    rng = np.random.default_rng(2)
    truth = rng.uniform(-0.06, 0.06, 7)
    clutter = rng.integers(0, 110, (240, 320, 3))
    clutter[60:150, 40:170] = (30, 90, 160)
    skin = rng.integers(120, 170, (240, 320, 3))
    frames = [
        replace(
            f,
            pictures=tuple(
                np.where(m[..., None], skin, clutter).astype(np.uint8) for m in f.pictures
            ),
        )
        for f in look(truth, 4)
    ]
    fit = learn(frames)
    assert np.abs(fit.estimate.x - truth).max() < np.deg2rad(0.7)
    assert np.isnan(fit.iou)
    assert not fit.lost


def test_the_same_seed_gives_the_same_answer() -> None:
    frames = look(np.full(7, 0.05), 2)
    assert learn(frames).estimate.x.tobytes() == learn(frames).estimate.x.tobytes()


def test_seeds_are_spread_as_the_prior_says() -> None:
    x = sobol_seeds(OFFSETS, 1000, 0)
    assert x.shape == (1000, 7)
    assert not x[0].any()
    np.testing.assert_allclose(x.std(axis=0), 0.1, rtol=0.03)
    assert (sobol_seeds(OFFSETS, 1000, 1) != x).any()


def test_of_guesses_that_are_near_each_other_the_best_is_refined() -> None:
    x = np.array([[0.0, 0], [0.1, 0], [2, 0], [2, 0.2], [0, 3]])
    assert best_apart(x, np.array([1.0, 2, 5, 6, 3]), 3) == [3, 4, 1]
    assert best_apart(x, np.array([1.0, 2, 5, 6, 3]), 9) == [3, 4, 1]


def test_far_postures_are_chosen() -> None:
    q = np.array([[0.0], [0.1], [5.0], [5.1], [-4.0]])
    assert spread_out(q, 3) in ([0, 2, 4], [0, 3, 4], [1, 3, 4])


def test_coarse_pictures_see_the_same() -> None:
    seen = look(np.zeros(7), 1)[0]
    large = replace(
        seen,
        cameras=tuple(c.scaled(640, 480) for c in seen.cameras),
        pictures=tuple(m.repeat(2, 0).repeat(2, 1) for m in seen.pictures),
    )
    small = coarse(large)
    assert [c.width for c in small.cameras] == [320, 320]
    for a, b in zip(small.pictures, seen.pictures, strict=True):
        assert (a == b).all()


def test_postures_of_other_cameras_are_refused() -> None:
    first, second = look(np.zeros(7), 2)
    alone = replace(second, cameras=second.cameras[:1], pictures=second.pictures[:1])
    with pytest.raises(bs.InputError, match="one kind from the cameras"):
        learn([first, alone])
    with pytest.raises(bs.InputError, match="no picture"):
        learn([])
