"""Rows of a silhouette as spans, and what they say about an observed mask.

Sorted by column, the crossings of a row add up to the winding number; where it leaves or returns to
zero a span [a, b) begins or ends. Ends of equal column cancel in pairs: empty spans and the seams
between touching ones. With the row sums P of the observed mask and PD of the distances to its
contour,

    A = sum (b - a),   I = sum (P[b] - P[a])      area, and its part inside the observed mask

The inner boundary of the silhouette is what a cross-shaped erosion takes away. Its complement, the
interior of row r, is the intersection of three lists of spans: those of row r shrunk by one pixel
at either end, those of row r - 1 and those of row r + 1; what lies beyond the image counts as
covered. With it

    N = A - sum |interior|,   D = sum over spans of PD - sum over interior of PD

are the number of boundary pixels and the sum of their distances.

The spans of row r are kept as ends[r, 1 .. kept[r]] = a, b, a, b ...; ends[r, 0] = -1 is a guard.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import kernel
from bodyschema.vision.scratch import Scratch

Ints = NDArray[np.int32]
Naturals = NDArray[np.uint32]


class Spans(NamedTuple):
    """The spans of one view."""

    ends: Ints
    """(height, capacity + 1)"""
    kept: Naturals
    """(height,) ends of each row, an even number."""


@kernel
def new_spans(height: int, capacity: int) -> Spans:
    """Room for the spans of one view."""
    return Spans(np.full((height, capacity + 1), -1, np.int32), np.zeros(height, np.uint32))


@kernel
def sweep(memory: Scratch, spans: Spans) -> None:
    """Turn the crossings of every row into spans, and leave the rows empty."""
    crossings, full = memory.crossings, memory.full
    capacity = crossings.shape[0] // full.shape[0]
    one = np.uint32(1)
    for r in range(full.shape[0]):
        n, kept = full[r], np.uint32(0)
        row, ends = crossings[r * capacity : (r + 1) * capacity], spans.ends[r]
        for i in range(np.uint32(2), n):
            key, j = row[i], np.uint32(i)
            while row[j - one] > key:
                row[j] = row[j - one]
                j -= one
            row[j] = key
        w = np.int32(0)
        for i in range(one, n):
            x = row[i] >> 4
            after = np.int32(w + (row[i] & 15) - 8)
            changes = np.uint32((w == 0) != (after == 0))
            cancels = ends[kept] == x
            ends[kept + one] = x
            kept = np.uint32(kept - changes) if cancels else np.uint32(kept + changes)
            w = after
        spans.kept[r], full[r] = kept, one


@kernel
def overlap(spans: Spans, P: Ints) -> tuple[int, int]:
    """I and A."""
    inside = area = 0
    for r in range(P.shape[0]):
        ends, row = spans.ends[r], P[r]
        for i in range(np.uint32(1), spans.kept[r], np.uint32(2)):
            a, b = ends[i], ends[i + np.uint32(1)]
            area += b - a
            inside += row[np.uint32(b)] - row[np.uint32(a)]
    return inside, area


@kernel
def boundary(spans: Spans, PD: Ints) -> tuple[int, int]:
    """D and N."""
    distance = number = 0
    last, width = PD.shape[0] - 1, np.int32(PD.shape[1] - 1)
    one, two = np.uint32(1), np.uint32(2)
    for r in range(PD.shape[0]):
        n = spans.kept[r]
        above, below = max(r - 1, 0), min(r + 1, last)
        ends, upper, lower = spans.ends[r], spans.ends[above], spans.ends[below]
        n_upper, n_lower = spans.kept[above], spans.kept[below]
        row = PD[r]
        for m in range(one, n, two):
            a, b = ends[m], ends[m + one]
            number += b - a
            distance += row[np.uint32(b)] - row[np.uint32(a)]
        i = j = k = one
        while (i < n) & (j < n_upper) & (k < n_lower):
            b, c, d = ends[i + one], upper[j + one], lower[k + one]
            b -= b < width
            left = max(ends[i] + (ends[i] > 0), upper[j], lower[k])
            right = min(b, c, d)
            stop = max(left, right)
            number -= stop - left
            distance -= row[np.uint32(stop)] - row[np.uint32(left)]
            i += two if b == right else np.uint32(0)
            j += two if c == right else np.uint32(0)
            k += two if d == right else np.uint32(0)
    return distance, number
