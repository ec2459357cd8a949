"""Whether the camera has moved: corners of the background say so, long before hand and eye do.

Each corner of the background has an anchor, the mean of the first places where it was seen. A still
camera sees it there for ever, within the noise. When most corners are away from their anchors, and
by more than noise and shake explain, the camera moves; when they stand still again, at new places,
it has moved, and those are the new anchors. Things that move by themselves take single corners
along, never most of them.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[np.int64]

AWAY, MOST = 0.8, 0.6
"""px beyond which a corner is away from its anchor, and share of the corners that must be."""
FEW = 5
"""Corners with an anchor below which nothing is said."""
ANCHOR = 5
"""Frames that an anchor is the mean of."""
STILL, REST = 0.5, 6
"""px from frame to frame, and frames, for which a camera that moved must stand."""


@dataclass(frozen=True)
class Background:
    """Anchors of the corners of the background."""

    name: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(K,)"""
    anchor: Array = field(default_factory=lambda: np.zeros((0, 2)))
    """(K, 2) px, mean so far."""
    count: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(K,) frames in it, `ANCHOR` at most."""
    last: Array = field(default_factory=lambda: np.zeros((0, 2)))
    """(K, 2) px, in the last frame."""
    moving: bool = False
    """Whether the camera moves now."""
    still: int = 0
    """Frames for which it has stood since."""

    def step(self, name: Ints, place: Array) -> tuple[Background, bool]:
        """With one frame more: corners (K,) and places (K, 2); whether a turn has just ended."""
        known = {n: i for i, n in enumerate(self.name)}
        at = np.array([known.get(n, -1) for n in name], dtype=np.int64)
        old = at >= 0
        anchor = np.where(old[:, None], self.anchor[at] if len(self.anchor) else 0, place)
        before = np.where(old[:, None], self.last[at] if len(self.last) else 0, place)
        count = np.where(old, self.count[at] if len(self.count) else 0, 0)
        ripe = count >= ANCHOR
        state = replace(self, name=name, last=place)
        if self.moving:
            step = np.linalg.norm(place - before, axis=1)
            stands = old.sum() >= FEW and np.median(step[old]) < STILL
            still = self.still + 1 if stands else 0
            if still < REST:
                return replace(state, anchor=place, count=0 * count, still=still), False
            return replace(state, anchor=place, count=0 * count, moving=False, still=0), True
        away = np.linalg.norm(place - anchor, axis=1)
        if ripe.sum() >= FEW and np.mean(away[ripe] > AWAY) > MOST:
            return replace(state, anchor=place, count=0 * count, moving=True, still=0), False
        mean = np.where(
            ripe[:, None], anchor, (anchor * count[:, None] + place) / (count + 1)[:, None]
        )
        return replace(state, anchor=mean, count=np.minimum(count + 1, ANCHOR)), False
