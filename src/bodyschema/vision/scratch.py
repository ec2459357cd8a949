"""Working memory of a silhouette, made once for many hypotheses; see `silhouette`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import kernel
from bodyschema.vision.surface import Columns

Floats = NDArray[np.float32]
Ints = NDArray[np.int32]
Naturals = NDArray[np.uint32]
Signs = NDArray[np.int8]


class Scratch(NamedTuple):
    """Working memory of one thread, sized for one surface and one view."""

    U: Floats
    """(n_vertices,) columns of the projected vertices."""
    V: Floats
    """(n_vertices,) rows of the projected vertices."""
    S: Signs
    """(n_faces + 1,) s(f); the last is s(none) = 0."""
    found: Naturals
    """(n_edges + 1,) contour edges; in the end those that cross a row, see `outline`."""
    first: Ints
    """First row that a segment of the contour crosses."""
    rows: Ints
    """How many it crosses."""
    x: Floats
    """Column at the first row."""
    g: Floats
    """Columns to a row."""
    weight: Ints
    """Winding weight + 8."""
    crossings: Ints
    """(height * capacity,)"""
    full: Naturals
    """(height,)"""


@kernel
def new_scratch(columns: Columns, height: int, capacity: int) -> Scratch:
    """Fresh working memory; a face that is cut by the near plane makes up to four segments."""
    n_faces, n_edges = columns.NX.shape[0], columns.EU.shape[0]
    n_segments = n_edges + 4 * n_faces + 1
    U, V = np.empty(columns.VX.shape[0], np.float32), np.empty(columns.VX.shape[0], np.float32)
    S = np.zeros(n_faces + 1, np.int8)
    found = np.empty(n_edges + 1, np.uint32)
    first, rows = np.empty(n_segments, np.int32), np.empty(n_segments, np.int32)
    x, g = np.empty(n_segments, np.float32), np.empty(n_segments, np.float32)
    weight = np.empty(n_segments, np.int32)
    crossings, full = np.full(height * capacity, -1, np.int32), np.ones(height, np.uint32)
    return Scratch(U, V, S, found, first, rows, x, g, weight, crossings, full)
