"""A lens from the files that calibrations write: ROS, OpenCV, Kalibr.

    camera_info.yaml of ROS     camera_matrix, distortion_model, distortion_coefficients,
                                image_width, image_height; also a message that was echoed: k, d
    FileStorage of OpenCV       .yml, .xml or .json; names as its own examples write them
    camchain.yaml of Kalibr     "camchain.yaml#cam1" where there are several

All are of the whole picture as it was taken: K and a distortion, plumb_bob, rational or fisheye.
Rectification and projection of a stereo pair belong to straightened pictures and are passed over.
"""

from __future__ import annotations

import json
import re
import reprlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from bodyschema.documents import file_text
from bodyschema.errors import InputError, did_you_mean
from bodyschema.model.distortion import FISHEYE, MODELS, PLUMB_BOB, RATIONAL
from bodyschema.model.urdf_xml import xml_root

ENDINGS = (".yaml", ".yml", ".xml", ".json")

MARK = "#"
"""Between a file and a camera of it."""

MOST_BYTES = 1 << 20
"""Of a file of lenses; they have two thousand."""

NAMES = {
    "matrix": ("camera_matrix", "cameraMatrix", "k", "K", "intrinsics", "intrinsic_matrix"),
    "distortion": ("distortion_coefficients", "dist_coeffs", "distCoeffs", "distortion_coeffs",
                   "d", "D", "dist_coeff", "distortion"),
    "width": ("image_width", "imageWidth", "image_Width", "width"),
    "height": ("image_height", "imageHeight", "image_Height", "height"),
    "size": ("resolution", "image_size", "imageSize"),
    "model": ("distortion_model",),
}  # fmt: skip
"""What each number is called, by who writes it."""

CALLED = {
    "": "", "none": "", "plumb_bob": PLUMB_BOB, "radtan": PLUMB_BOB,
    "rational_polynomial": RATIONAL, "rational": RATIONAL,
    "equidistant": FISHEYE, "fisheye": FISHEYE, "kannala_brandt4": FISHEYE,
}  # fmt: skip
"""Models of distortion, by who writes them."""


@dataclass(frozen=True)
class LensFile:
    """What a file says of a lens."""

    intrinsics: tuple[float, float, float, float]
    """f_x f_y c_x c_y, px."""
    distortion: tuple[float, ...]
    """As many as the model has, in OpenCV's order; none where the file has none or zeros alone."""
    model: str
    """"plumb_bob", "rational" or "fisheye"."""
    size: tuple[int, int] | None
    """Width and height of the pictures, px; None where the file does not say."""


def is_lens_file(name: str) -> bool:
    """Whether a word names a file of a lens, and not a part."""
    return Path(name.partition(MARK)[0]).suffix.lower() in ENDINGS


def read_lens(path: str | Path) -> LensFile:
    """Read a lens; see the module's text.

    Raises:
        InputError: the file is missing or holds no lens, or one of another kind.
    """
    name, _, camera = str(path).partition(MARK)
    missing = f"no lens at '{name}'; give the path of a camera_info.yaml or a file of OpenCV."
    text = file_text(Path(name), missing, MOST_BYTES)
    table = _camera(_table(text, Path(name)), camera, name)
    K, size = _matrix(table, name), _size(table, name)
    given = _numbers(_found(table, "distortion"), f"the distortion in '{name}'")
    model = _model(table, given, name)
    count = len(MODELS[model].names)
    if any(given[count:]):
        raise InputError(
            f"'{name}' has {len(given)} distortion coefficients, and a lens of model '{model}' has "
            f"{count}; calibrate the camera with that model."
        )
    _refuse_part(table, name)
    bent = (*given[:count], *[0.0] * (count - len(given)))
    return LensFile(K, bent if any(bent) or model == FISHEYE else (), model, size)


def _table(text: str, path: Path) -> Mapping[str, Any]:
    """The keys and values of a file."""
    table: Any
    try:
        if path.suffix.lower() == ".xml":
            table = {element.tag: _of_element(element) for element in xml_root(text.encode())}
        elif path.suffix.lower() == ".json":
            table = json.loads(text)
        else:
            # OpenCV's first line is none of YAML's, and its tags are its own.
            text = re.sub(r"\A%YAML:[\d.]+", "", text)
            table = next(iter(yaml.load_all(text, _Loader)), None)
    except Exception as error:  # of three parsers, each with errors of its own
        reason = str(error).partition("\n")[0].rstrip(".")[:200]
        raise InputError(f"'{path}' is no {path.suffix[1:]} that can be read: {reason}.") from None
    if not isinstance(table, Mapping):
        raise InputError(f"'{path}' holds no lens: expected keys and values.")
    return table


class _Loader(yaml.SafeLoader):
    """Plain values; a tag that nobody knows is passed over."""


def _untagged(loader: _Loader, suffix: str, node: yaml.Node) -> Any:
    if isinstance(node, yaml.MappingNode):
        return loader.construct_mapping(node, deep=True)
    if isinstance(node, yaml.SequenceNode):
        return loader.construct_sequence(node, deep=True)
    assert isinstance(node, yaml.ScalarNode)  # YAML has no fourth kind
    return loader.construct_scalar(node)


_Loader.add_multi_constructor("tag:yaml.org,2002:opencv-", _untagged)


def _of_element(element: Any) -> Any:
    """A matrix as YAML has it, or the words of an element."""
    inner = {child.tag: (child.text or "").split() for child in element}
    return inner or (element.text or "").split()


def _camera(table: Mapping[str, Any], camera: str, name: str) -> Mapping[str, Any]:
    """The table of one camera where a file has several, as Kalibr's do."""
    inner = {
        key: value
        for key, value in table.items()
        if isinstance(value, Mapping) and _found(value, "matrix") is not None
    }
    if camera or (_found(table, "matrix") is None and inner):
        if camera and not inner:
            raise InputError(
                f"'{name}' has one lens and no cameras of their own; leave out {MARK}{camera}."
            )
        if camera not in inner and (camera or len(inner) > 1):
            raise InputError(
                f"'{name}' has the cameras {', '.join(map(str, inner))}; name one: "
                f'"{name}{MARK}{next(iter(inner), "cam0")}".'
            )
        return inner[camera] if camera else next(iter(inner.values()))
    return table


def _found(table: Mapping[str, Any], what: str) -> Any:
    return next((table[key] for key in NAMES[what] if key in table), None)


def _numbers(value: Any, what: str) -> tuple[float, ...]:
    """The numbers of a list, of rows of lists, or of a matrix of OpenCV or ROS."""
    if isinstance(value, Mapping):
        value = value.get("data")
    if value is None:
        return ()
    listed = value if isinstance(value, list) else [value]
    if any(isinstance(row, list) for row in listed):
        listed = [v for row in listed for v in (row if isinstance(row, list) else [row])]
    try:
        # YAML takes 1e-05 for a word.
        numbers = tuple(float(v) for v in listed)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{what} should be numbers, it is {_short(value)}.") from None
    if not all(abs(v) < 1e12 for v in numbers):
        raise InputError(f"{what} has a number that is none of a lens: {numbers!s:.60}.")
    return numbers


def _short(value: Any) -> str:
    """The beginning of a value; YAML's aliases may double one another, so it is never whole."""
    return reprlib.repr(value)[:60]


def _matrix(table: Mapping[str, Any], name: str) -> tuple[float, float, float, float]:
    """f_x f_y c_x c_y."""
    K = _numbers(_found(table, "matrix"), f"the matrix in '{name}'")
    if len(K) == 4:  # Kalibr's
        return K[0], K[1], K[2], K[3]
    if len(K) != 9:
        there = ", ".join(list(map(str, table))[:12])
        raise InputError(f"'{name}' has no camera_matrix of nine numbers; it has {there}.")
    if K[1] or K[3] or K[6:] != (0.0, 0.0, 1.0):
        raise InputError(f"the camera_matrix in '{name}' has skew or a wrong last row: {K}.")
    if K[0] <= 0 or K[4] <= 0:
        raise InputError(f"the camera_matrix in '{name}' is that of no calibrated camera: {K}.")
    return K[0], K[4], K[2], K[5]


def _size(table: Mapping[str, Any], name: str) -> tuple[int, int] | None:
    pair = _found(table, "size")
    each: Sequence[Any] = pair if isinstance(pair, list) else [
        _found(table, "width"), _found(table, "height")
    ]  # fmt: skip
    values = [v for one in each for v in _numbers(one, f"the image size in '{name}'")]
    if len(values) != 2 or min(values) < 1:
        return None
    return int(values[0]), int(values[1])


def _model(table: Mapping[str, Any], given: Sequence[float], name: str) -> str:
    """The model of the distortion, by its name, OpenCV's mark of a fisheye, or its count."""
    said = _found(table, "model")
    first = said[0] if isinstance(said, list) and said else said or ""
    word = first.lower() if isinstance(first, str) else _short(first)
    if word not in CALLED:
        raise InputError(f"distortion_model '{word}' in '{name}'{did_you_mean(word, CALLED)}")
    if any(_numbers(table.get("fisheye_model", 0), f"fisheye_model in '{name}'")):
        return FISHEYE
    longer = len(given) > len(MODELS[PLUMB_BOB].names)
    return CALLED[word] or (RATIONAL if longer else PLUMB_BOB)


def _refuse_part(table: Mapping[str, Any], name: str) -> None:
    """K of a message is that of the whole picture; those of a cut or thinned one are smaller."""
    roi = table.get("roi")
    cut = roi if isinstance(roi, Mapping) else {}
    thinned = [table.get("binning_x", 0), table.get("binning_y", 0)]
    if any(cut.get(key) for key in ("x_offset", "y_offset")) or any(
        isinstance(n, int) and n > 1 for n in thinned
    ):
        raise InputError(
            f"the pictures of '{name}' are binned or cut out of larger ones; give the lens of the "
            "pictures as they lie there."
        )
