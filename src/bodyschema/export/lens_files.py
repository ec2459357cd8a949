"""Lenses in the files that others read: camera_info.yaml of ROS, FileStorage of OpenCV.

Numbers are written in full, so that `model.lens_file` reads the same lens again.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from bodyschema.errors import InputError, did_you_mean
from bodyschema.judging.calibration import Calibration
from bodyschema.judging.settled import settled
from bodyschema.model.distortion import FISHEYE, OF_COUNT, PLUMB_BOB, RATIONAL
from bodyschema.model.parts import Part

ROS_MODELS = {PLUMB_BOB: "plumb_bob", RATIONAL: "rational_polynomial", FISHEYE: "equidistant"}

PREFIX = "lens:"
"""Of the groups of a lens's numbers, see `model.variables`."""

IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)


def lens_files(calibration: Calibration, run: Mapping[str, Any]) -> dict[str, str]:
    """Texts by file name of every lens that was estimated, in both forms.

    Args:
        calibration: the answer.
        run: what was asked, whose parts say how large the pictures are.
    """
    found = {}
    for name, lens in estimated_lenses(calibration).items():
        size = size_of(name, run)
        found[f"{name}_opencv.yml"] = opencv_text(lens, size)
        if size is not None:
            found[f"{name}_camera_info.yaml"] = camera_info_text(lens, size, name)
    return found


def estimated_lenses(calibration: Calibration) -> dict[str, Part]:
    """The lenses that were free, as they were found; none if the answer is withheld."""
    if calibration.withheld:
        return {}
    groups = dict.fromkeys(calibration.estimate.variables.groups)
    names = [group.removeprefix(PREFIX) for group in groups if group.startswith(PREFIX)]
    parts = settled(calibration).body.parts if names else {}
    return {name: parts[name] for name in names}


def lens_text(calibration: Calibration, name: str, run: Mapping[str, Any], ending: str) -> str:
    """One of them in the form that the ending of a file says.

    Args:
        calibration: the answer.
        name: of the lens.
        run: what was asked, whose parts say how large the pictures are.
        ending: ".yml" for OpenCV, ".yaml" for ROS.

    Raises:
        InputError: no such lens was found, another ending, or nobody said the pictures' size.
    """
    lenses, size = estimated_lenses(calibration), size_of(name, run)
    if name not in lenses:
        raise InputError(f"the result found no lens '{name}'{did_you_mean(name, lenses)}")
    if ending == ".yml":
        return opencv_text(lenses[name], size)
    if ending != ".yaml":
        raise InputError(f"a lens goes into a .yaml (ROS) or .yml (OpenCV), not a '{ending}'.")
    if size is None:
        raise InputError(
            f"camera_info needs the size of the pictures, and [parts.{name}] did not say it; write "
            "OpenCV's form, --out lens.yml."
        )
    return camera_info_text(lenses[name], size, name)


def size_of(name: str, run: Mapping[str, Any]) -> tuple[int, int] | None:
    """Width and height of the pictures of a lens, px, where the run says them."""
    size: Any = run.get("parts", {}).get(name, {}).get("size") or ()
    width, height = size if len(size) == 2 else (0, 0)
    return (int(width), int(height)) if width else None


def camera_info_text(lens: Part, size: tuple[int, int], name: str) -> str:
    """camera_info.yaml, as camera_calibration writes and camera drivers load it.

    Args:
        lens: a part of kind "lens".
        size: width and height of the pictures, px.
        name: of the camera.
    """
    fx, fy, cx, cy, *k = (float(v) for v in lens.values)
    P = (fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0)
    return (
        f"image_width: {size[0]}\nimage_height: {size[1]}\ncamera_name: {name}\n"
        + _matrix("camera_matrix", 3, _K(fx, fy, cx, cy))
        + f"distortion_model: {ROS_MODELS[_model(lens)]}\n"
        + _matrix("distortion_coefficients", 1, k)
        + _matrix("rectification_matrix", 3, IDENTITY)
        + _matrix("projection_matrix", 3, P)
    )


def opencv_text(lens: Part, size: tuple[int, int] | None) -> str:
    """The same as cv2.FileStorage reads it, in the names of OpenCV's own calibration.

    Args:
        lens: a part of kind "lens".
        size: width and height of the pictures, px; left out when None.
    """
    fx, fy, cx, cy, *k = (float(v) for v in lens.values)
    sized = "" if size is None else f"image_width: {size[0]}\nimage_height: {size[1]}\n"
    return (
        f"%YAML:1.0\n---\n{sized}fisheye_model: {int(_model(lens) == FISHEYE)}\n"
        + _matrix("camera_matrix", 3, _K(fx, fy, cx, cy), "!!opencv-matrix", "dt: d")
        + _matrix("distortion_coefficients", 1, k, "!!opencv-matrix", "dt: d")
    )


def _model(lens: Part) -> str:
    return OF_COUNT[len(lens.values) - 4]


def _K(fx: float, fy: float, cx: float, cy: float) -> tuple[float, ...]:
    return (fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0)


def _matrix(name: str, rows: int, values: Iterable[float], tag: str = "", kind: str = "") -> str:
    numbers = [_number(value) for value in values]
    lines = [f"rows: {rows}", f"cols: {len(numbers) // rows}", *([kind] if kind else [])]
    lines.append(f"data: [{', '.join(numbers)}]")
    indent = "   " if tag else "  "
    return f"{name}:{' ' + tag if tag else ''}\n" + "".join(f"{indent}{line}\n" for line in lines)


def _number(value: float) -> str:
    """In full; YAML takes 1e-05 for a word, and 1.0e-05 for a number."""
    text = repr(value)
    return text if "e" not in text or "." in text else text.replace("e", ".0e")
