"""Gauss-Newton on the contour finds a hand that another renderer drew.

MuJoCo draws the native meshes of an arm whose joints are off by a few degrees; the correspondences
of the decimated arm bring the hand from centimetres to a fraction of a millimetre, from one pair of
images. Seven offsets from one pair are not all told (self-motion of the arm); the pose is.
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import lie
from bodyschema.model.kinematics import relative_pose
from bodyschema.simulation import icub
from bodyschema.vision.correspondences import find_rim, rim_slopes
from bodyschema.vision.normal_search import search_masks
from bodyschema.vision.poses import piece_poses
from icub_arm import arm, eyes, readings
from referees import mujoco_silhouettes

pytest.importorskip("mujoco")
pytest.importorskip("cv2")

Array = NDArray[np.float64]

BODY = icub.nominal_icub()
FREE = bs.free_joints(BODY, ["offsets"], icub.RIGHT_ARM)
REACH = (40, 40, 30, 20, 15, 10, 8, 6, 4, 4)
"""pixels, step by step."""


def stepped(q: Array, masks: list[NDArray[np.bool_]], prior_std: float) -> Array:
    """Offsets after some robust steps from zero."""
    x = np.zeros(len(FREE))
    for reach in REACH:
        poses = piece_poses(BODY.with_variables(FREE, x), q, eyes(), arm().frames)[0]
        rim = find_rim(arm(), poses, eyes())
        slopes = rim_slopes(rim, arm(), eyes(), BODY, FREE, x, q)
        seen = search_masks(rim, masks, reach)
        J, d = slopes.by_parameter[seen.found], seen.distance[seen.found]
        trust = rim.length[seen.found] * (1 + (d / max(1, reach / 6)) ** 2) ** -2
        weight = trust / max(0.3, reach / 10) ** 2 / 3
        information = J.T @ (weight[:, None] * J) + np.eye(len(x)) / prior_std**2
        x = x + np.linalg.solve(information, J.T @ (weight * d) - x / prior_std**2)
    return x


def hand_error(q: Array, x: Array, truth: Array) -> tuple[float, float]:
    """mm and degrees between the poses of the hand in the left eye."""
    found, true = (
        relative_pose(BODY.with_variables(FREE, v), q, icub.LEFT_EYE, icub.HAND) for v in (x, truth)
    )
    turn = lie.log_so3(found[:3, :3] @ true[:3, :3].T)
    return 1e3 * float(np.linalg.norm(found[:3, 3] - true[:3, 3])), float(
        np.rad2deg(np.linalg.norm(turn))
    )


def test_a_few_steps_bring_the_hand_within_a_fraction_of_a_millimetre(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("MUJOCO_GL", "egl")
    rng = np.random.default_rng(0)
    postures = readings(20)[[0, 4, 9, 14]]
    truths = np.deg2rad(3) * rng.normal(size=(len(postures), len(FREE)))
    native = arm(decimated=False)
    poses = np.concatenate(
        [
            piece_poses(BODY.with_variables(FREE, truth), q, eyes(), native.frames)
            for q, truth in zip(postures, truths, strict=True)
        ]
    )
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as fresh:
        try:
            views = [
                fresh.submit(mujoco_silhouettes, native, poses[:, c], camera).result()
                for c, camera in enumerate(eyes())
            ]
        except Exception as error:  # without EGL every platform has an error of its own
            pytest.skip(f"MuJoCo cannot render here: {error}")
    for i, (q, truth) in enumerate(zip(postures, truths, strict=True)):
        before = hand_error(q, np.zeros(len(FREE)), truth)
        after = hand_error(q, stepped(q, [view[i] for view in views], np.deg2rad(10)), truth)
        assert before[0] > 5
        assert after[0] < 0.3
        assert after[1] < 0.5
