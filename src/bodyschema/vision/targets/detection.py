"""Where a picture shows the corners of a target, by OpenCV (4.x and 5.x: only calls of both).

Whatever a detector answers is numbered as `Target` says: from the front, so that x, y and the way
into the picture are right-handed, and of a chessboard with its black corner first. What is left
open, a pattern that looks the same turned round, is for the robot's postures to tell (`turns`).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError, MissingExtraError, did_you_mean
from bodyschema.vision.targets.found import Found
from bodyschema.vision.targets.target import Target

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Grey = NDArray[np.uint8]

LEAST = 4
"""Corners of a picture that is used."""

Numbered = tuple[Ints, Array]
"""Numbers (m,) and places (m, 2) px of corners."""


def find_target(target: Target, grey: Grey) -> Found | None:
    """The corners of a target in a picture; None when it is not there.

    Fewer than LEAST corners, or none, are left where no edges meet at what was detected: it is of
    no use, and `Found.rejected` says why.

    Args:
        target: what to look for.
        grey: (height, width).

    Raises:
        InputError: a dictionary that OpenCV does not have.
        MissingExtraError: OpenCV is not installed.
    """
    ids, image = _FINDERS[target.kind](target, np.ascontiguousarray(grey))
    height, width = grey.shape
    inside = (image > -0.5).all(axis=1) & (image < [width - 0.5, height - 0.5]).all(axis=1)
    if inside.sum() < LEAST:
        return None
    return Found.of(grey, ids[inside], image[inside], target.kind == "circles", target.clear)


def _chessboard(target: Target, grey: Grey) -> Numbered:
    seen, corners = _opencv().findChessboardCornersSB(grey, target.grid)
    if not seen:
        return _nothing()
    ordered = _from_the_front(target, corners)
    if not _black_first(target, grey, ordered):
        ordered = ordered[::-1]
    return np.arange(len(ordered)), ordered


def _circles(target: Target, grey: Grey) -> Numbered:
    cv2 = _opencv()
    form = cv2.CALIB_CB_ASYMMETRIC_GRID if target.asymmetric else cv2.CALIB_CB_SYMMETRIC_GRID
    seen, centres = cv2.findCirclesGrid(grey, target.grid, flags=form | cv2.CALIB_CB_CLUSTERING)
    if not seen:
        seen, centres = cv2.findCirclesGrid(grey, target.grid, flags=form)
    if not seen:
        return _nothing()
    ordered = _from_the_front(target, centres)
    return np.arange(len(ordered)), ordered


def _charuco(target: Target, grey: Grey) -> Numbered:
    corners, ids, _, _ = _charuco_detector(target).detectBoard(grey)
    if ids is None or not len(ids):
        return _nothing()
    return np.asarray(ids).ravel().astype(np.int64), _pairs(corners)


def _tags(target: Target, grey: Grey) -> Numbered:
    tags, ids, _ = _tag_detector(target.dictionary).detectMarkers(grey)
    numbers = np.zeros(0, np.int64) if ids is None else np.asarray(ids).ravel().astype(np.int64)
    place = numbers - target.first_id
    once = np.array([np.sum(numbers == one) == 1 for one in numbers], dtype=bool)
    mine = np.flatnonzero(once & (place >= 0) & (place < target.columns * target.rows))
    if not len(mine):
        return _nothing()
    order = mine[np.argsort(place[mine])]
    ids = (4 * place[order, None] + np.arange(4)).ravel()
    return ids, np.concatenate([_pairs(tags[k]) for k in order])


_FINDERS: dict[str, Callable[[Target, Grey], Numbered]] = {
    "chessboard": _chessboard,
    "circles": _circles,
    "charuco": _charuco,
    "tags": _tags,
}


def _from_the_front(target: Target, corners: Any) -> Array:
    """Corners of a whole grid, rows reversed where it was numbered as if seen from behind."""
    columns, rows = target.grid
    grid = _pairs(corners).reshape(rows, columns, 2)
    along, down = grid[:, -1] - grid[:, 0], grid[-1] - grid[0]
    turn = float(np.linalg.det(np.stack([along.mean(axis=0), down.mean(axis=0)])))
    return (grid if turn > 0 else grid[:, ::-1]).reshape(-1, 2)


def _black_first(target: Target, grey: Grey, ordered: Array) -> bool:
    """Whether the square inward of corner 0 is darker than its neighbours."""
    columns, rows = target.grid
    g = ordered.reshape(rows, columns, 2)
    middles = (g[:-1, :-1] + g[1:, :-1] + g[:-1, 1:] + g[1:, 1:]) / 4
    u, v = np.rint(middles).astype(int).transpose(2, 0, 1)
    height, width = grey.shape
    levels = grey[np.clip(v, 0, height - 1), np.clip(u, 0, width - 1)].astype(np.float64)
    even = np.add.outer(np.arange(rows - 1), np.arange(columns - 1)) % 2 == 0
    return bool(levels[even].mean() < levels[~even].mean())


def _pairs(corners: Any) -> Array:
    return np.asarray(corners, dtype=np.float64).reshape(-1, 2)


def _nothing() -> Numbered:
    return np.zeros(0, np.int64), np.zeros((0, 2))


@lru_cache(maxsize=8)
def _charuco_detector(target: Target) -> Any:
    cv2 = _opencv()
    size, tags = (target.columns, target.rows), dictionary(target.dictionary)
    board = cv2.aruco.CharucoBoard(size, target.square_m, target.marker_m, tags)
    board.setLegacyPattern(target.legacy)
    return cv2.aruco.CharucoDetector(board)


@lru_cache(maxsize=8)
def _tag_detector(name: str) -> Any:
    cv2 = _opencv()
    settings = cv2.aruco.DetectorParameters()
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    return cv2.aruco.ArucoDetector(dictionary(name), settings)


def dictionary(name: str) -> Any:
    """OpenCV's dictionary of tags. Raises InputError for a name that it does not have."""
    aruco = _opencv().aruco
    known = [one.removeprefix("DICT_") for one in dir(aruco) if one.startswith("DICT_")]
    plain = name.removeprefix("DICT_")
    found = next((one for one in known if one.lower() == plain.lower()), None)
    if found is None:
        raise InputError(f"no dictionary '{name}' of tags{did_you_mean(plain, known)}")
    return aruco.getPredefinedDictionary(getattr(aruco, f"DICT_{found}"))


def _opencv() -> Any:
    try:
        import cv2
    except ImportError:
        raise MissingExtraError("opencv-python-headless", "vision", "finding boards") from None
    return cv2
