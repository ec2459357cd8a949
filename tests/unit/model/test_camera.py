"""Projection against OpenCV, undistortion, and the conventions of pixels."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.model.camera import Camera

cv2 = pytest.importorskip("cv2")

K = np.array([[260.0, 0.0, 158.0], [0.0, 255.0, 121.0], [0.0, 0.0, 1.0]])
LENS = np.array([-0.31, 0.12, 1e-3, -8e-4, -0.02, 0.05, 0.01, -2e-3, 1e-3, 2e-4, -9e-4, 1e-4])


@pytest.mark.parametrize("count", [0, 4, 5, 8, 12])
def test_projection_agrees_with_opencv(count: int) -> None:
    p = np.random.default_rng(0).uniform([-0.5, -0.4, 0.8], [0.5, 0.4, 2.0], size=(50, 3))
    camera = Camera("eye", "eye", 320, 240, K, LENS[:count])
    expected, _ = cv2.projectPoints(p, np.zeros(3), np.zeros(3), K, LENS[:count])
    np.testing.assert_allclose(camera.project(p), expected.reshape(-1, 2), atol=1e-9)
    assert camera.project(p.reshape(5, 10, 3)).shape == (5, 10, 2)


def test_an_undistorted_image_is_that_of_the_ideal_camera() -> None:
    """Paint a smooth pattern over the rays as the bent camera sees it; straighten; compare."""
    bent, ideal = Camera("", "", 320, 240, K, LENS[:5]), Camera("", "", 320, 240, K)
    v, u = np.mgrid[:240, :320].astype(np.float64)

    def pattern(rays: np.ndarray) -> np.ndarray:
        return 120 + 50 * np.sin(6 * rays[..., 0]) + 50 * np.cos(7 * rays[..., 1])

    plane = np.stack([(u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1]], axis=-1)
    seen = cv2.undistortPoints(np.stack([u, v], -1).reshape(-1, 1, 2), K, LENS[:5])
    image = pattern(seen.reshape(240, 320, 2)).astype(np.float32)
    straight = bent.undistort(image)
    inside = (slice(20, 220), slice(20, 300))
    assert np.abs(straight - pattern(plane))[inside].max() < 0.5
    assert np.abs(image - pattern(plane))[inside].max() > 5
    assert ideal.undistort(image) is image


def test_a_mask_stays_a_mask() -> None:
    mask = np.zeros((240, 320), dtype=bool)
    mask[60:200, 80:250] = True
    straight = Camera("", "", 320, 240, K, LENS[:5]).undistort(mask)
    assert straight.dtype == bool
    assert 0.5 < straight.sum() / mask.sum() < 2


def test_pixel_zero_is_the_centre_of_the_top_left_pixel() -> None:
    camera = Camera.from_fov("eye", "eye", 320, 240, np.deg2rad(60))
    left_edge = [-np.tan(np.deg2rad(30)), 0, 1]
    np.testing.assert_allclose(camera.project(left_edge), [-0.5, 119.5], atol=1e-12)


def test_a_scaled_camera_sees_the_same() -> None:
    camera = Camera("eye", "eye", 320, 240, K, LENS[:5])
    p = np.random.default_rng(1).uniform([-0.4, -0.3, 0.9], [0.4, 0.3, 2.0], size=(20, 3))
    small = camera.scaled(160, 120)
    np.testing.assert_allclose(small.project(p) + 0.5, (camera.project(p) + 0.5) / 2, atol=1e-9)
    assert (small.width, small.height) == (160, 120)


@pytest.mark.parametrize(
    ("matrix", "distortion", "words"),
    [
        (np.eye(2), [], "3x3"),
        (np.diag([0.0, 1.0, 1.0]), [], "f_x, f_y > 0"),
        (K + np.array([[0, 1, 0], [0, 0, 0], [0, 0, 0]]), [], "skew"),
        (K, [0.1, 0.2], "2 distortion coefficients"),
    ],
    ids=["shape", "focal length", "skew", "coefficients"],
)
def test_a_camera_without_sense_is_refused(
    matrix: np.ndarray, distortion: list[float], words: str
) -> None:
    with pytest.raises(InputError, match=words):
        Camera("eye", "eye", 320, 240, matrix, np.array(distortion))


def test_an_image_of_another_size_is_refused() -> None:
    with pytest.raises(InputError, match="has 320 x 240 pixels, and its picture 160 x 120"):
        Camera("eye", "eye", 320, 240, K, LENS[:5]).undistort(np.zeros((120, 160)))
