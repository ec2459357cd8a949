"""Lens files of ROS, OpenCV and Kalibr, as their own programs write them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.model.lens_file import LensFile, read_lens

ROS = """image_width: 640
image_height: 480
camera_name: narrow_stereo
camera_matrix:
  rows: 3
  cols: 3
  data: [615.5, 0, 320.25, 0, 616.5, 241.75, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.1, -0.2, 1e-05, 0.002, 0]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
projection_matrix:
  rows: 3
  cols: 4
  data: [600, 0, 320, 0, 0, 600, 240, 0, 0, 0, 1, 0]
"""
K = (615.5, 616.5, 320.25, 241.75)
EXPECTED = LensFile(K, (0.1, -0.2, 1e-05, 0.002, 0.0), "plumb_bob", (640, 480))

ECHOED = """header:
  stamp: {sec: 3, nanosec: 4}
height: 480
width: 640
distortion_model: plumb_bob
d: [0.1, -0.2, 1.0e-05, 0.002, 0.0]
k: [615.5, 0.0, 320.25, 0.0, 616.5, 241.75, 0.0, 0.0, 1.0]
binning_x: 0
roi: {x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false}
---
"""
KALIBR = """cam0:
  camera_model: pinhole
  distortion_coeffs: [0.1, 0.02, -0.003, 0.0004]
  distortion_model: equidistant
  intrinsics: [615.5, 616.5, 320.25, 241.75]
  resolution: [640, 480]
cam1:
  camera_model: pinhole
  distortion_coeffs: [0.1, -0.2, 1.0e-05, 0.002]
  distortion_model: radtan
  intrinsics: [615.5, 616.5, 320.25, 241.75]
  resolution: [640, 480]
"""
NESTED = "K: [[615.5, 0, 320.25], [0, 616.5, 241.75], [0, 0, 1]]\nimage_size: [640, 480]\n"


def written(tmp_path: Path, text: str, name: str = "lens.yaml") -> Path:
    path = tmp_path / name
    path.write_text(text)
    return path


@pytest.mark.parametrize("text", [ROS, ECHOED], ids=["calibration", "echo"])
def test_ros(tmp_path: Path, text: str) -> None:
    assert read_lens(written(tmp_path, text)) == EXPECTED


def test_kalibr(tmp_path: Path) -> None:
    path = written(tmp_path, KALIBR)
    assert read_lens(f"{path}#cam1") == EXPECTED
    fisheye = LensFile(K, (0.1, 0.02, -0.003, 0.0004), "fisheye", (640, 480))
    assert read_lens(f"{path}#cam0") == fisheye
    with pytest.raises(InputError, match="has the cameras cam0, cam1; name one"):
        read_lens(path)


def test_rows_of_a_matrix(tmp_path: Path) -> None:
    assert read_lens(written(tmp_path, NESTED)) == LensFile(K, (), "plumb_bob", (640, 480))


@pytest.mark.parametrize("ending", ["yml", "xml", "json"])
@pytest.mark.parametrize(("count", "model"), [(5, "plumb_bob"), (8, "rational"), (4, "fisheye")])
def test_opencv(tmp_path: Path, ending: str, count: int, model: str) -> None:
    """What cv2.FileStorage writes itself."""
    cv2 = pytest.importorskip("cv2")
    path = tmp_path / f"lens.{ending}"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", 640)
    storage.write("image_height", 480)
    storage.write("camera_matrix", np.array([[K[0], 0, K[2]], [0, K[1], K[3]], [0, 0, 1]]))
    k = np.random.default_rng(count).normal(size=(count, 1)) * 1e-5
    storage.write("distortion_coefficients", k)
    if model == "fisheye":
        storage.write("fisheye_model", 1)
    storage.release()
    assert read_lens(path) == LensFile(K, tuple(k[:, 0].tolist()), model, (640, 480))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("camera_matrix", "kamera", "has no camera_matrix of nine numbers; it has image_width"),
        ("data: [615.5, 0,", "data: [615.5, 1,", "has skew"),
        ("data: [615.5", "data: [0", "of no calibrated camera"),
        ("data: [615.5", "data: [.nan", "a number that is none of a lens"),
        ("data: [615.5", "data: [wide", "should be numbers, it is"),
        ("plumb_bob", "plumb_bop", "distortion_model 'plumb_bop' .*; did you mean 'plumb_bob'"),
        (
            "plumb_bob",
            "equidistant",
            "has 5 distortion coefficients, and a lens of model 'fisheye'",
        ),
        ("camera_name: narrow_stereo", "binning_x: 2", "are binned or cut out"),
        ("camera_name: narrow_stereo", "roi: {x_offset: 8}", "are binned or cut out"),
        ("image_width: 640", "a: [", "is no yaml that can be read"),
        ("image_width: 640", "a: !!python/object:os.system x", "is no yaml that can be read"),
    ],
)
def test_what_is_no_lens_is_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    text = ROS.replace(old, new, 1)
    if new == "equidistant":
        text = text.replace("0.002, 0]", "0.002, 0.1]")
    assert text != ROS
    with pytest.raises(InputError, match=message):
        read_lens(written(tmp_path, text))


def test_missing_files(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no lens at"):
        read_lens(tmp_path / "none.yaml")
    with pytest.raises(InputError, match="holds no lens"):
        read_lens(written(tmp_path, "3"))
    with pytest.raises(InputError, match="is no xml that can be read"):
        read_lens(written(tmp_path, "<a>", "lens.xml"))
    assert read_lens(written(tmp_path, ROS.replace("image_width", "x"))).size is None


@pytest.mark.parametrize("key", ["k", "d", "image_width", "distortion_model", "fisheye_model"])
def test_anchors_that_double_one_another_are_never_written_out(tmp_path: Path, key: str) -> None:
    doubled = [f"a{i}: &a{i} [*a{i - 1}, *a{i - 1}]" for i in range(1, 60)]
    text = ECHOED.replace(f"{key}:", "was:") if key in ("k", "d") else ROS
    text = "\n".join(["a0: &a0 [1, 1]", *doubled, f"{key}: *a59", text.replace(f"{key}:", "was:")])
    with pytest.raises(InputError) as error:
        read_lens(written(tmp_path, text.partition("---")[0]))
    assert len(str(error.value)) < 400


def test_a_whole_number_that_is_no_float(tmp_path: Path) -> None:
    text = ROS.replace("615.5", "1" + "0" * 400)
    with pytest.raises(InputError, match="should be numbers, it is"):
        read_lens(written(tmp_path, text))


def test_a_camera_of_a_file_that_has_one_lens(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"has one lens and no cameras .*; leave out #cam1"):
        read_lens(f"{written(tmp_path, ROS)}#cam1")
