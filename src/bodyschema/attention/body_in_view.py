"""The answer of a detector: which cells of the image are the body, and which joint moves them.

The image is cut into square cells. What is left over at the right and lower edge, when the image is
no whole number of cells, belongs to no cell.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]


@dataclass(frozen=True)
class NextMotion:
    """The motion that would settle most of the doubt."""

    kind: Literal["repeat", "joint"]
    """Repeat the last motion, or move one joint alone."""
    joint: str
    """The joint to move; of a repeated motion the one that turned furthest."""
    why: str
    """One sentence."""


@dataclass(frozen=True)
class BodyInView:
    """What is me in the image, by cells of `cell_px` pixels."""

    time: float
    """s, of the last frame."""
    joints: tuple[str, ...]
    """J names."""
    size: tuple[int, int]
    """Width and height of the image, pixels."""
    cell_px: int
    """Side of a cell, pixels."""
    probability: Array
    """(rows, cols) that the cell shows the body."""
    mask: Flags
    """(rows, cols) cells that are called me."""
    now: Flags
    """(rows, cols) cells that move in the last frame together with the joints."""
    joint: Ints
    """(rows, cols) index of the joint that moves the cell furthest; -1 where it is not me."""
    evidence: Array
    """(J, rows, cols) how clearly each joint moves each cell: onsets that coincided, or nats."""
    lag_s: float
    """s by which images come after the encoder readings of the same time; nan if not known."""
    lag_sd_s: float
    """s, its standard deviation; nan if not known."""
    motions: int
    """Motions that have been weighed."""
    enough: bool
    """Whether more motion would change little."""
    reason: str
    """Why it is enough or not, in one sentence."""
    next_motion: NextMotion | None
    """What to do next; None when it is enough."""

    def pixels(self) -> Flags:
        """(height, width) the mask in pixels."""
        width, height = self.size
        shown = np.zeros((height, width), dtype=bool)
        large = self.mask.repeat(self.cell_px, axis=0).repeat(self.cell_px, axis=1)
        shown[: large.shape[0], : large.shape[1]] = large
        return shown
