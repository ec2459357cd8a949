"""Lenses out and in again: the same to the last digit, and as OpenCV reads them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import yaml

from bodyschema.export.lens_files import camera_info_text, opencv_text
from bodyschema.model import parts
from bodyschema.model.camera import Camera
from bodyschema.model.lens_file import LensFile, read_lens
from bodyschema.model.parts import Part


def lens(count: int, seed: int) -> Part:
    rng = np.random.default_rng(seed)
    K = np.diag([*rng.uniform(300, 900, 2), 1.0])
    K[:2, 2] = rng.uniform(200, 400, 2)
    k = rng.normal(size=count) * 10.0 ** rng.integers(-7, 0, count)
    return parts.lens(Camera("eye", "eye", 640, 480, K, k, fisheye=count == 4))


MODELS = [(5, "plumb_bob"), (8, "rational"), (4, "fisheye")]


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(("count", "model"), MODELS)
def test_they_come_back_to_the_last_digit(
    tmp_path: Path, count: int, model: str, seed: int
) -> None:
    eye = lens(count, seed)
    expected = LensFile(tuple(eye.values[:4]), tuple(eye.values[4:]), model, (640, 480))
    info, opencv = tmp_path / "eye.yaml", tmp_path / "eye.yml"
    info.write_text(camera_info_text(eye, (640, 480), "eye"))
    opencv.write_text(opencv_text(eye, (640, 480)))
    assert read_lens(info) == expected
    assert read_lens(opencv) == expected
    opencv.write_text(opencv_text(eye, None))
    assert read_lens(opencv).size is None


@pytest.mark.parametrize(("count", "model"), MODELS)
def test_opencv_reads_its_form(tmp_path: Path, count: int, model: str) -> None:
    cv2 = pytest.importorskip("cv2")
    eye, path = lens(count, 9), tmp_path / "eye.yml"
    path.write_text(opencv_text(eye, (640, 480)))
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    K = storage.getNode("camera_matrix").mat()
    assert (K[[0, 1, 0, 1], [0, 1, 2, 2]] == eye.values[:4]).all()
    assert (storage.getNode("distortion_coefficients").mat().ravel() == eye.values[4:]).all()
    assert storage.getNode("image_width").real() == 640
    assert storage.getNode("fisheye_model").real() == (model == "fisheye")


def test_camera_info_has_what_a_camera_driver_loads() -> None:
    """The keys of ROS's camera_calibration_parsers, numbers as numbers of YAML 1.1."""
    eye = lens(5, 1)
    eye.values[4] = 1e-05  # a word for YAML 1.1, unless it has a point
    document = yaml.safe_load(camera_info_text(eye, (640, 480), "eye"))
    shapes = {
        key: (value["rows"], value["cols"], len(value["data"]))
        for key, value in document.items()
        if isinstance(value, dict)
    }
    assert shapes == {
        "camera_matrix": (3, 3, 9),
        "distortion_coefficients": (1, 5, 5),
        "rectification_matrix": (3, 3, 9),
        "projection_matrix": (3, 4, 12),
    }
    assert document["distortion_model"] == "plumb_bob"
    numbers = [v for value in document.values() if isinstance(value, dict) for v in value["data"]]
    assert all(isinstance(v, float) for v in numbers)
