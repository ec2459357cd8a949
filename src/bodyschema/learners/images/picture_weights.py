"""How much each picture counts, and each piece of the body in all of them.

rho of a contour point (see `hypothesis`) is M^2 e^2 / (M^2 + e^2), and M^2 where nothing was found;
M = MATCHED. Over the imagined contour of a picture, or of one piece in all pictures, its mean L
says what one point of weight (1 + e^2 / M^2)^-2 (Geman and McClure, see `rim_fit`) would say:

    w = (1 - L / M^2)^2

1 where the whole contour lies where it should, 0 where nothing does. So a picture in which the body
is covered, or is another thing, or is elsewhere, fades by its own statistic and is never thrown
away; so does a piece whose mesh is not that of the robot. A camera is the pictures it took.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.images.rim_fit import MATCHED, RimRows

Array = NDArray[np.float64]

USED = 0.25
"""A picture with less weight does not count as used: more than half of what an empty picture would
lose is lost in it."""

LEAST = 1e-3
"""Weight of a picture in which nothing fits: information never vanishes altogether."""


@dataclass(frozen=True)
class PictureWeights:
    """Of the pictures of several moments."""

    pictures: Array
    """(n_moments, n_cameras); nan where nothing of the body would show."""
    pieces: Array
    """(n_pieces,); nan for a piece that would show nowhere."""

    @classmethod
    def of(cls, rows: Sequence[RimRows]) -> PictureWeights:
        """By what was found of each."""
        lengths = np.array([r.lengths for r in rows])
        losses = np.array([r.losses for r in rows])
        return cls(
            _weight(losses.sum(axis=2), lengths.sum(axis=2)),
            _weight(losses.sum(axis=(0, 1)), lengths.sum(axis=(0, 1))),
        )

    @property
    def used(self) -> NDArray[np.bool_]:
        """(n_moments, n_cameras) pictures that show the body where it is said to be."""
        return np.nan_to_num(self.pictures) >= USED

    @property
    def cameras(self) -> Array:
        """(n_cameras,) mean weight of its pictures; 0 for one in which nothing would show."""
        return np.asarray(np.nan_to_num(self.pictures).mean(axis=0))

    @property
    def total(self) -> float:
        """How many whole pictures all of them are worth."""
        return float(np.nansum(self.pictures))

    def matched(self, rows: Sequence[RimRows]) -> float:
        """Share of the contour that was found within `MATCHED`, pictures by their weights."""
        w = np.nan_to_num(self.pictures)
        found, whole = (
            float(np.sum(w * np.array([getattr(r, name).sum(axis=1) for r in rows])))
            for name in ("matches", "lengths")
        )
        return found / whole if whole else 0.0

    def on(self, rows: Sequence[RimRows]) -> list[RimRows]:
        """The rows with these weights, the best picture and the best piece taken as 1."""
        picture, piece = (np.nan_to_num(w) / max(np.nanmax(w, initial=LEAST), LEAST)
                          for w in (self.pictures, self.pieces))  # fmt: skip
        both = np.maximum(picture[:, :, None] * piece, LEAST).reshape(len(rows), -1)
        return [replace(r, weight=r.weight * w[r.group]) for r, w in zip(rows, both, strict=True)]


def _weight(loss: Array, length: Array) -> Array:
    """w of a sum of rho over so much contour."""
    with np.errstate(invalid="ignore"):
        mean = np.where(length > 0, loss / length, np.nan)
    return np.asarray((1 - mean / MATCHED**2) ** 2)
