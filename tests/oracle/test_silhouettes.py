"""Silhouettes of the iCub's arm against a ray caster and against MuJoCo's renderer."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest

from bodyschema.vision.contours import silhouette
from icub_arm import arm, beside_the_eye, eyes, views
from referees import iou, mujoco_silhouettes, ray_silhouette

pytest.importorskip("mujoco")
pytest.importorskip("embreex")


@pytest.mark.parametrize(("width", "n"), [(160, 16), (320, 10), (640, 4)])
def test_no_pixel_differs_from_ray_casting(width: int, n: int) -> None:
    """Pixel centres within float32 of an edge may differ: at most 1 in 100,000."""
    wrong = covered = 0
    for T in views(n, seed=width):
        for c, camera in enumerate(eyes(width, width * 3 // 4)):
            expected = ray_silhouette(arm(decimated=False), T[c], camera)
            seen = silhouette(arm(decimated=False), T[c], camera)
            wrong += np.count_nonzero(seen != expected)
            covered += np.count_nonzero(expected)
    assert covered > 50_000
    assert wrong <= np.ceil(covered * 1e-5)


def test_a_forearm_beside_the_camera_is_cut_where_the_eye_begins() -> None:
    surface, camera = arm(decimated=False), eyes()[0]
    cut = beside_the_eye(100)
    assert len(cut) >= 20
    for T in cut:
        expected = ray_silhouette(surface, T, camera)
        assert iou(silhouette(surface, T, camera), expected) >= 0.995


def test_a_decimated_arm_looks_like_the_native_one() -> None:
    for T in views(20, seed=2):
        for c, camera in enumerate(eyes()):
            native = silhouette(arm(decimated=False), T[c], camera)
            assert iou(silhouette(arm(), T[c], camera), native) >= 0.995


def test_mujoco_sees_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "egl")
    surface, camera = arm(decimated=False), eyes()[0]
    T = views(6, seed=3)[:, 0]
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as fresh:
        try:
            masks = fresh.submit(mujoco_silhouettes, surface, T, camera).result()
        except Exception as error:  # without EGL every platform has an error of its own
            pytest.skip(f"MuJoCo cannot render here: {error}")
    for poses, mask in zip(T, masks, strict=True):
        assert iou(silhouette(surface, poses, camera), mask) >= 0.999
