"""Small squares of one image sought in another: by descent, checked backwards, and along a row.

    Lucas and Kanade: move the patch until the sum of squared differences stops falling, first on
    small copies of the images, then on larger ones.

What is found must lead back to where it came from, lie inside the image, and look like what was
sought: by chance a wrong way leads back, too.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import MissingExtraError

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Grey = NDArray[np.uint8]

NEARBY = 1
"""Halvings where the place is known to a few pixels: large patches would see the background too."""
ALIKE = 0.8
"""Correlation that a patch and its match must have."""


@dataclass(frozen=True)
class Patches:
    """How patches are compared."""

    window: int
    """px, side of a patch; odd."""
    back: float
    """px by which the way back may miss its beginning."""

    def follow(
        self, first: Grey, second: Grey, place: Array, guess: Array, halvings: int = NEARBY
    ) -> tuple[Array, Flags]:
        """Where patches of the first image are in the second.

        Args:
            first: (height, width).
            second: (height, width).
            place: (K, 2) middles of the patches in the first, px; nan for none.
            guess: (K, 2) where to begin in the second, px; nan for nowhere.
            halvings: of the images, for patches that may be farther away.

        Returns:
            (K, 2) px, the guess where nothing was found, and (K,) what is sure.
        """
        known = np.asarray(np.isfinite(np.hstack([place, guess])).all(axis=1))
        found, sure = guess.copy(), known.copy()
        if not known.any():
            return found, sure
        there, there_ok = self._descend(first, second, place[known], guess[known], halvings)
        back, back_ok = self._descend(second, first, there, place[known], halvings)
        error = np.linalg.norm(back - place[known], axis=1)
        inside = self._within(there, second)
        sure[known] = there_ok & back_ok & (error < self.back) & inside
        found[known] = np.where(inside[:, None], there, guess[known])
        for k in np.flatnonzero(sure):
            sure[k] = self._likeness(first, second, place[k], found[k]) > ALIKE
        return found, sure

    def along_row(self, left: Grey, right: Grey, place: Array) -> float:
        """px to the left, whole ones, at which the row of the right image looks most alike.

        nan where nothing does.
        """
        half = self.window // 2
        u, v = np.rint(place).astype(int)
        if not self._within(place[None], left)[0]:
            return np.nan
        rows = slice(v - half, v + half + 1)
        patch, strip = left[rows, u - half : u + half + 1], right[rows, : u + half + 1]
        alike = vision().matchTemplate(strip, patch, vision().TM_CCOEFF_NORMED).ravel()
        best = int(np.argmax(alike))
        return float(place[0] - half - best) if alike[best] > ALIKE else np.nan

    def _descend(
        self, first: Grey, second: Grey, place: Array, guess: Array, halvings: int
    ) -> tuple[Array, Flags]:
        cv2 = vision()
        found, status, _ = cv2.calcOpticalFlowPyrLK(
            first, second, place[:, None].astype(np.float32), guess[:, None].astype(np.float32),
            winSize=(self.window, self.window), maxLevel=halvings,
            criteria=(cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 30, 0.003),
            flags=cv2.OPTFLOW_USE_INITIAL_FLOW,
        )  # fmt: skip
        return np.asarray(found, dtype=np.float64).reshape(-1, 2), status.ravel().astype(bool)

    def _likeness(self, first: Grey, second: Grey, place: Array, found: Array) -> float:
        """Correlation of two patches."""
        cv2, size = vision(), (self.window, self.window)
        sought = cv2.getRectSubPix(first, size, place)
        there = cv2.getRectSubPix(second, size, found)
        return float(cv2.matchTemplate(there, sought, cv2.TM_CCOEFF_NORMED)[0, 0])

    def _within(self, place: Array, image: Grey) -> Flags:
        """Whether the whole patch lies in the image."""
        half, size = self.window // 2 + 1, np.array(image.shape[::-1])
        return np.asarray(((place >= half) & (place <= size - 1 - half)).all(axis=1))


def vision() -> Any:
    """OpenCV.

    Raises:
        MissingExtraError: it is not installed.
    """
    try:
        import cv2
    except ImportError:
        raise MissingExtraError("opencv-python-headless", "vision", "following corners") from None
    return cv2
