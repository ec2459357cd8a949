"""Three models of a lens: pixels are OpenCV's, derivatives those of differences, rays undo them."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.model import parts
from bodyschema.model.camera import Camera
from bodyschema.model.distortion import FISHEYE, MODELS, PLUMB_BOB, RATIONAL
from bodyschema.model.lens import UNSEEN, pixel_derivatives, pixels, straight_rays

Array = NDArray[np.float64]

K = np.array([[300.0, 0.0, 330.0], [0.0, 295.0, 245.0], [0.0, 0.0, 1.0]])
COEFFICIENTS = {
    PLUMB_BOB: [-0.25, 0.08, 1e-3, -2e-3, 0.01],
    RATIONAL: [0.9, 0.3, 1e-3, -2e-3, 0.02, 1.2, 0.5, 0.05],
    FISHEYE: [0.05, -0.02, 0.006, -0.001],
}
WIDE = {PLUMB_BOB: 1.2, RATIONAL: 2.0, FISHEYE: 6.0}
"""a and b of the farthest points: 50, 63 and 80 degrees off the axis."""


def camera_of(model: str) -> Camera:
    k = np.array(COEFFICIENTS[model])
    return Camera("eye", "eye", 660, 490, K, k, fisheye=model == FISHEYE)


def points_of(model: str, n: int = 60) -> Array:
    rng = np.random.default_rng(1)
    angle, far = rng.uniform(0, 2 * np.pi, n), rng.uniform(0, WIDE[model], n)
    depth = rng.uniform(0.3, 2.0, n)
    rays = np.stack([far * np.cos(angle), far * np.sin(angle), np.ones(n)], axis=1)
    rays[0] = [0, 0, 1]
    return np.asarray(depth[:, None] * rays)


@pytest.mark.parametrize("model", MODELS)
def test_pixels_are_those_of_opencv(model: str) -> None:
    cv2 = pytest.importorskip("cv2")
    p, k, still = points_of(model), np.array(COEFFICIENTS[model]), np.zeros(3)
    if model == FISHEYE:
        told, _ = cv2.fisheye.projectPoints(p[None], still, still, K, k)
    else:
        told, _ = cv2.projectPoints(p[:, None], still, still, K, k)
    camera = camera_of(model)
    assert pixels(parts.lens(camera).values, p) == pytest.approx(told.reshape(-1, 2), abs=1e-9)
    assert camera.project(p) == pytest.approx(told.reshape(-1, 2), abs=1e-9)


@pytest.mark.parametrize("model", MODELS)
def test_derivatives_are_those_of_differences(model: str) -> None:
    lens, p, step = parts.lens(camera_of(model)).values, points_of(model), 1e-6
    p[1] = [3e-5, -2e-5, 1.0]  # where a fisheye is taken for its limit
    image, by_point, by_lens = pixel_derivatives(lens, p)
    assert image == pytest.approx(pixels(lens, p), abs=1e-12)
    for axis in range(3):
        by = np.zeros(3)
        by[axis] = step
        slope = (pixels(lens, p + by) - pixels(lens, p - by)) / (2 * step)
        assert by_point[:, :, axis] == pytest.approx(slope, rel=1e-5, abs=1e-3)
    for number in range(len(lens)):
        by = np.zeros(len(lens))
        by[number] = step
        slope = (pixels(lens + by, p) - pixels(lens - by, p)) / (2 * step)
        assert by_lens[:, :, number] == pytest.approx(slope, rel=1e-6, abs=1e-5)


@pytest.mark.parametrize("model", MODELS)
def test_rays_undo_pixels(model: str) -> None:
    lens, p = parts.lens(camera_of(model)).values, points_of(model)
    rays = straight_rays(lens, pixels(lens, p))
    assert rays == pytest.approx(p[:, :2] / p[:, 2:], rel=1e-8, abs=1e-12)


def test_a_fisheye_sees_wider_and_not_behind() -> None:
    wide = [[8.0, 0.0, 1.0]]
    assert (pixels(parts.lens(camera_of(PLUMB_BOB)).values, wide) == UNSEEN).all()
    fisheye = parts.lens(camera_of(FISHEYE)).values
    assert (pixels(fisheye, wide) != UNSEEN).all()
    assert (pixels(fisheye, [[8.0, 0.0, -1.0]]) == UNSEEN).all()


def test_no_model_has_ten_numbers() -> None:
    with pytest.raises(InputError, match=r"9 \(plumb_bob\), 12 \(rational\), 8 \(fisheye\)"):
        pixels(np.ones(10), [[0.0, 0.0, 1.0]])
