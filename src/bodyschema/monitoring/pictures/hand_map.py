"""Where on the hand corners have been: a map of small cubes, each with what spoke for and against.

A cube in which a corner was found to be on the hand is where the next one may be born, long after
that corner has died. A cube whose corners turned out to be on the wall, on the forearm, or on the
edge between two things, is not.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SIDE = 0.008
"""m of a cube."""
SPAN = 1 << 20
"""Cubes either way."""
MOST = 50
"""Votes that a cube keeps."""


@dataclass(frozen=True)
class HandMap:
    """Cubes on the hand."""

    cube: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(n,) sorted numbers of the cubes."""
    place: Array = field(default_factory=lambda: np.zeros((0, 3)))
    """(n, 3) m, where the last corner in each was."""
    votes: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(n,) for minus against."""

    def voted(self, place: Array, vote: int) -> HandMap:
        """With votes of corners at places (K, 3) m."""
        place = place[np.abs(place).max(axis=1) < SIDE * SPAN / 2] if len(place) else place
        if not len(place):
            return self
        keys = np.floor(place / SIDE).astype(np.int64) + SPAN // 2
        number = (keys[:, 0] * SPAN + keys[:, 1]) * SPAN + keys[:, 2]
        every = np.concatenate([self.cube, number])
        cube, first, which = np.unique(every, return_index=True, return_inverse=True)
        votes = np.concatenate([self.votes, np.full(len(number), vote)])
        total = np.clip(np.bincount(which, votes, minlength=len(cube)), -MOST, MOST)
        spots = np.concatenate([self.place, place])[first]
        return HandMap(cube, spots, total.astype(np.int64))

    def without(self, place: Array, radius: float) -> HandMap:
        """Without the cubes near places (K, 3) m: what was there has gone."""
        if not len(place) or not len(self.cube):
            return self
        near = np.linalg.norm(self.place[:, None] - place[None], axis=2).min(axis=1) < radius
        return HandMap(self.cube[~near], self.place[~near], self.votes[~near])

    @property
    def points(self) -> Array:
        """(n, 3) m, of the cubes that are on the hand."""
        return np.asarray(self.place[self.votes > 0])
