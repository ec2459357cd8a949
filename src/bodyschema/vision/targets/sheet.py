"""A target as black rectangles on paper, in metres: what a printer is to draw.

The sheet's origin is the top-left corner of the pattern, x to the right and y down. Tags are drawn
cell by cell; circles cannot be made of rectangles and are not printed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.vision.targets.detection import dictionary
from bodyschema.vision.targets.target import Target

Array = NDArray[np.float64]


def pattern_size(target: Target) -> tuple[float, float]:
    """Width and height of the whole pattern, m."""
    s = target.square_m
    if target.kind == "tags":
        gap = s - target.marker_m if target.columns * target.rows > 1 else 0.0
        one = target.marker_m + gap
        return target.columns * one - gap, target.rows * one - gap
    more = 1 if target.kind == "chessboard" else 0
    return s * (target.columns + more), s * (target.rows + more)


def black_rectangles(target: Target) -> Array:
    """Every black rectangle, (n, 4): x, y, width, height, m. Raises InputError for circles."""
    if target.kind == "circles":
        raise InputError(
            "a board of circles is not drawn here; take kind chessboard, charuco or tags."
        )
    if target.kind == "tags":
        return _tags(
            target, [divmod(k, target.columns) for k in range(target.columns * target.rows)]
        )
    more = 1 if target.kind == "chessboard" else 0
    rows, columns = np.indices((target.rows + more, target.columns + more))
    # OpenCV before 4.6 began a board of an even number of rows with a white square.
    first = 1 if target.legacy and target.rows % 2 == 0 else 0
    black = (rows + columns) % 2 == first
    s = target.square_m
    corner = s * np.stack([columns[black], rows[black]], axis=1)
    squares = np.concatenate([corner, np.full_like(corner, s)], axis=1)
    if target.kind == "chessboard":
        return squares
    white = list(zip(rows[~black].tolist(), columns[~black].tolist(), strict=True))
    return np.concatenate([squares, _tags(target, white)])


def _tags(target: Target, places: list[tuple[int, int]]) -> Array:
    """Cells of the tags in squares (row, column), numbered on from the first one."""
    # First: it says which extra is missing.
    tags = dictionary(target.dictionary)
    import cv2

    cells = int(tags.markerSize) + 2
    size = target.marker_m / cells
    inset = (target.square_m - target.marker_m) / 2 if target.kind == "charuco" else 0.0
    if target.first_id + len(places) > len(tags.bytesList):
        raise InputError(
            f"the dictionary '{target.dictionary}' has {len(tags.bytesList)} tags, and "
            f"{target.first_id + len(places)} are needed; take a larger one."
        )
    found = []
    for k, (row, column) in enumerate(places):
        picture = cv2.aruco.generateImageMarker(tags, target.first_id + k, cells)
        corner = target.square_m * np.array([column, row]) + inset
        for i, j, length in _runs(np.asarray(picture) == 0):
            found.append([*(corner + size * np.array([j, i])), length * size, size])
    return np.array(found)


def _runs(black: NDArray[np.bool_]) -> list[tuple[int, int, int]]:
    """Row, first column and length of every black run of a picture."""
    found = []
    for i, line in enumerate(black):
        edges = np.flatnonzero(np.diff(np.pad(line.astype(np.int8), 1)))
        found += [(i, int(a), int(b - a)) for a, b in edges.reshape(-1, 2)]
    return found
