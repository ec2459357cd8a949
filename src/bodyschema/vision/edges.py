"""The edge table of a triangle soup: which two faces meet in each edge.

Entry (u, v, f, g): face f has the edge running from u to v, face g has it running from v to u. A
face that has no partner across an edge stands alone: (u, v, f, none) in its own direction. So the
outlines of all faces, each turned by a sign s, add up to the entries with the weights

    w = s(f) - s(g),        s(none) = 0,

and inner edges of a well wound surface cancel. Holes, edges with three faces and wrongly wound
neighbours only make more entries: any soup is exact and none needs repair.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Ints = NDArray[np.int64]


def edge_table(faces: Ints, none: int) -> Ints:
    """Entries (u, v, f, g), (k, 4), of faces (m, 3); `none` stands for a missing g."""
    u, v = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
    f = np.repeat(np.arange(len(faces)), 3)
    low, high, backward = np.minimum(u, v), np.maximum(u, v), u > v
    # Several faces may run along an edge in one direction: the i-th of them is paired with the
    # i-th of those that run the other way.
    order = np.lexsort((f, backward, high, low))
    runs = _first_of_run(low[order], high[order], backward[order])
    rank = np.empty_like(f)
    rank[order] = np.arange(len(f)) - np.maximum.accumulate(np.where(runs, np.arange(len(f)), 0))
    order = np.lexsort((backward, rank, high, low))
    first = _first_of_run(low[order], high[order], rank[order])
    at = np.flatnonzero(first)
    paired = ~np.append(first, True)[at + 1]
    head = order[at]
    partner = np.full(len(at), none)
    partner[paired] = f[order[at[paired] + 1]]
    return np.stack([u[head], v[head], f[head], partner], axis=1)


def _first_of_run(*columns: Ints | NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether a row of sorted columns differs from the one before, (n,)."""
    new = np.ones(len(columns[0]), dtype=bool)
    new[1:] = np.any([column[1:] != column[:-1] for column in columns], axis=0)
    return new
