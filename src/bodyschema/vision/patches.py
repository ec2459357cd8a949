"""Patches of a surface: parts of its outside that are thought to be wrong each on its own.

A mesh is never quite the body: it is a little too thick here and too thin there, and stays so in
every picture. Here each piece is cut into patches round centres that are spread out over it (each
centre is the vertex farthest from those before); a point belongs to the nearest centre.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.vision.correspondences import Rim
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Patches:
    """The patches of all pieces of a surface, counted through."""

    centres: tuple[Array, ...]
    """(n, 3) m of each piece, in its frame."""

    @classmethod
    def of(cls, surface: Surface, n: int) -> Patches:
        """At most n patches a piece; none of any for n = 0."""
        pieces = [surface.vertices[a:b] for a, b in zip(surface.vo, surface.vo[1:], strict=False)]
        return cls(tuple(_spread(vertices, n) for vertices in pieces))

    def __len__(self) -> int:
        return sum(map(len, self.centres))

    def of_rim(self, rim: Rim) -> Ints:
        """The patch of each point of an outline, (n,)."""
        found = np.zeros(len(rim), dtype=np.int64)
        before = 0
        for piece, centres in enumerate(self.centres):
            mine = np.flatnonzero(rim.piece == piece)
            # The nearest centre has the largest p.c - |c|^2 / 2.
            nearness = rim.point[mine] @ centres.T - np.sum(centres**2, axis=1) / 2
            found[mine] = before + np.argmax(nearness, axis=1) if len(mine) else 0
            before += len(centres)
        return found


def _spread(vertices: Array, n: int) -> Array:
    """At most n vertices far from each other."""
    if not n:
        return np.zeros((0, 3))
    chosen = [int(np.argmax(np.linalg.norm(vertices - vertices.mean(axis=0), axis=1)))]
    away = np.linalg.norm(vertices - vertices[chosen[0]], axis=1)
    while len(chosen) < n and away.max() > 0:
        chosen.append(int(np.argmax(away)))
        away = np.minimum(away, np.linalg.norm(vertices - vertices[chosen[-1]], axis=1))
    return np.asarray(vertices[chosen])
