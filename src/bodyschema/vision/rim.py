"""The outer contour of an imagined body, point by point, each with the mesh edge that makes it.

Rows and columns of the image cut the contour. Where the winding number of a row (see `silhouette`)
leaves or returns to zero, the union of all pieces begins or ends, so the point lies on the outer
contour: it is neither hidden nor on an inner edge between two pieces, and no depth is needed to
know that. Rows take the contour where it is steep, |dx/dy| <= 1, columns where it is flat,
|dy/dx| < 1; so neighbouring points are 1 to 1.4 lines apart everywhere and each stands for the
length sqrt(1 + g^2) of contour, g the slope in the line's direction.

Columns are rows of the turned view: the first two rows of T_cam_piece and of the lens exchanged.
The eye, and with it every sign s(f), stays the same. Every second line only is the view with f and
c of the lines halved; so neither needs code of its own.

A crossing is one number that sorts by place: (256 x) 2^36 + (w + 8) 2^32 + segment. Gaps and spans
thinner than 1/16 pixel are taken for seams and slivers, not for contour.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import kernel
from bodyschema.vision.scratch import Scratch, new_scratch
from bodyschema.vision.silhouette import outline
from bodyschema.vision.surface import Columns

Floats = NDArray[np.float32]
Longs = NDArray[np.int64]
Naturals = NDArray[np.uint32]

PLACE, WEIGHT, SEGMENT = 36, 32, (1 << 32) - 1
"""Where the parts of a crossing lie."""

THINNEST = 16
"""1/256 pixel."""


class Cuts(NamedTuple):
    """Where lines cut the outer contour of one view: working memory of one thread."""

    memory: Scratch
    crossings: Longs
    """(n_lines * capacity,); of each line first those that are ends of spans: begin, end, ..."""
    held: Naturals
    """(n_lines,) ends of each line."""


@kernel
def new_cuts(columns: Columns, n_lines: int, capacity: int) -> Cuts:
    """Fresh working memory."""
    memory = new_scratch(columns, n_lines, 1)
    return Cuts(memory, np.zeros(n_lines * capacity, np.int64), np.zeros(n_lines, np.uint32))


@kernel
def turned(T: Floats, lens: Floats, step: int, columns_first: bool) -> tuple[Floats, Floats]:
    """T_cam_piece and lens of the view whose rows are every step-th row, or column, of the view."""
    T_view, lens_view = T.copy(), lens.copy()
    if columns_first:
        T_view[:, 0], T_view[:, 1] = T[:, 1], T[:, 0]
        lens_view[0], lens_view[1], lens_view[2], lens_view[3] = lens[1], lens[0], lens[3], lens[2]
    lens_view[1] /= np.float32(step)
    lens_view[3] /= np.float32(step)
    return T_view, lens_view


@kernel
def cut_contour(
    columns: Columns, T: Floats, lens: Floats, near: np.float32, last: int, cuts: Cuts
) -> tuple[int, int]:
    """Find where all lines cut the outer contour of one view.

    Args:
        columns: of the surface.
        T: (n_pieces, 3, 4) T_cam_piece, see `turned`.
        lens: (4,) see `turned`.
        near: m.
        last: the last pixel of a line.
        cuts: filled.

    Returns:
        How many segments the near plane made (they come first and are no contour of the body),
        and how many crossings found no place.
    """
    made, n = outline(columns, T, lens, near, cuts.memory)
    lost = _cross(n, last, cuts)
    _keep_ends(cuts)
    return made, lost


@kernel
def _cross(n: int, last: int, cuts: Cuts) -> int:
    """Put the crossings of n segments into their lines; returns how many found no place."""
    memory, crossings, held = cuts.memory, cuts.crossings, cuts.held
    capacity = np.uint32(crossings.shape[0] // held.shape[0])
    right, scale, lost = np.float32(last), np.float32(256), 0
    for i in range(n):
        x, g = memory.x[i], memory.g[i]
        tail = (np.int64(memory.weight[i]) << WEIGHT) | np.int64(i)
        line = np.uint32(memory.first[i])
        for j in range(memory.rows[i]):
            place = min(max(x + np.float32(j) * g, np.float32(0)), right)
            free = held[line]
            if free < capacity:
                key = np.int64(np.int32(place * scale + np.float32(0.5)))
                crossings[line * capacity + free] = (key << PLACE) | tail
                held[line] = free + np.uint32(1)
            else:
                lost += 1
            line += np.uint32(1)
    return lost


@kernel
def _keep_ends(cuts: Cuts) -> None:
    """Sort each line and keep the ends of its spans, but for those of slivers and seams."""
    crossings, held = cuts.crossings, cuts.held
    capacity = crossings.shape[0] // held.shape[0]
    for line in range(held.shape[0]):
        row = crossings[line * capacity : (line + 1) * capacity]
        n, kept, w = held[line], 0, 0
        for i in range(1, n):
            key, j = row[i], i
            while j > 0 and row[j - 1] > key:
                row[j] = row[j - 1]
                j -= 1
            row[j] = key
        for i in range(n):
            after = w + ((row[i] >> WEIGHT) & 15) - 8
            if (w == 0) != (after == 0):
                if kept > 0 and (row[i] >> PLACE) - (row[kept - 1] >> PLACE) < THINNEST:
                    kept -= 1
                else:
                    row[kept] = row[i]
                    kept += 1
            w = after
        held[line] = kept


@kernel
def collect(
    columns: Columns,
    T: Floats,
    lens: Floats,
    near: np.float32,
    n_lines: int,
    last: int,
    columns_first: bool,
    step: int,
    capacity: int,
) -> tuple[Longs, int]:
    """Points of the outer contour of one view that rows, or columns, find.

    Returns:
        (n, 3) edge entry of the surface, line, and -1 or +1: the side on which nothing is; and how
        many crossings found no place, so that the points are not to be trusted.
    """
    T_view, lens_view = turned(T, lens, step, columns_first)
    cuts = new_cuts(columns, n_lines, capacity)
    made, lost = cut_contour(columns, T_view, lens_view, near, last, cuts)
    out = np.empty((cuts.held.sum(), 3), np.int64)
    n, border = 0, np.int64(last) * 256
    for line in range(n_lines):
        for k in range(cuts.held[line]):
            key = cuts.crossings[line * capacity + k]
            i, x = key & SEGMENT, key >> PLACE
            steep = belongs(cuts.memory.g[i] / np.float32(step), columns_first)
            if i >= made and steep and 0 < x < border:
                out[n, 0] = cuts.memory.found[i - made]
                out[n, 1] = line * step
                out[n, 2] = 2 * (k % 2) - 1
                n += 1
    return out[:n], lost


@kernel
def belongs(slope: np.float32, columns_first: bool) -> bool:
    """Whether the rows (or the columns) are to take a contour of this slope; never both."""
    one = np.float32(1)
    return bool(abs(slope) < one if columns_first else abs(slope) <= one)
