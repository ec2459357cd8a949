"""Corners on the body: from the cells that are me to points that can be followed and measured.

Corners are chosen once, where the smaller eigenvalue of the gradients' matrix is largest (Shi and
Tomasi 1994) inside the mask of the body, and each keeps its place in the list for good: the
learners of hand and eye hold one unknown point for each place.

Following from frame to frame adds up errors. So each frame is also compared with two key frames,
turned and stretched as the corners have been since: the first frame of all, which knows no drift,
and a later one, which becomes the last frame whenever few corners can be compared with it any more.
A corner that was hidden is found again in the same way when it comes back.

With the right image of a rectified pair, each corner is sought along its row:

    depth = f B / (u_left - u_right)

and (u_left, v, u_right) is what `learners.hand_eye` takes. Without, u_right is nan.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.vision.corner_patches import NEARBY, Patches, vision

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Grey = NDArray[np.uint8]

HALVINGS = 3
"""Of the images, from frame to frame: a motion of some 30 px is followed."""
SPARE = 2
"""Candidates for each corner, as the right image does not show all."""
NEAR_KEY = 1.5
"""px by which a key frame may move a corner from where the last frame leads it."""
LOST = 12.0
"""px around its foretold place in which a corner that was lost is sought."""
OLD_KEY = 0.5
"""Share of the corners seen that must agree with the later key frame for it to stay."""
FOR_AFFINE, FOR_TURN = 4, 2
"""Corners that must move as one for a key frame to be stretched, or only turned, with them."""
OFF_ROW = 1.0
"""px by which the rows of a corner may differ between left and right."""


@dataclass(frozen=True)
class KeyFrame:
    """What later frames are compared with."""

    image: Grey
    """(height, width)."""
    place: Array
    """(K, 2) px; nan for corners that it does not show."""


@dataclass(frozen=True)
class Corners:
    """Where the corners are in the last frame."""

    left: Grey
    """(height, width) the last frame."""
    place: Array
    """(K, 2) u, v of each corner, px; nan where it is not seen."""
    disparity: Array
    """(K,) px, u_left - u_right; nan where the right image does not show it or there is none."""
    first: KeyFrame
    """The frame in which the corners were chosen."""
    later: KeyFrame
    """A frame nearer to the last one."""

    @property
    def seen(self) -> Flags:
        """(K,) which corners the last frame shows."""
        return np.asarray(np.isfinite(self.place[:, 0]))

    @property
    def pixels(self) -> Array:
        """(K, 3) u_left, v, u_right; nan where a corner, or its match on the right, is not seen."""
        return np.column_stack([self.place, self.place[:, 0] - self.disparity])


@dataclass(frozen=True)
class CornerTracker:
    """Follows corners on the body."""

    count: int = 20
    """K: at most so many are chosen."""
    window: int = 15
    """px, side of the patch that is compared."""
    spacing: float = 10.0
    """px between two corners at least."""
    quality: float = 0.03
    """Of the best corner's eigenvalue that others must have."""
    back: float = 0.5
    """px by which the way back may miss its beginning."""

    def start(self, left: Grey, mask: Flags, right: Grey | None = None) -> Corners:
        """Choose corners.

        Args:
            left: (height, width) grey, 8 bit.
            mask: (height, width) where the body is, see `BodyInView.pixels`.
            right: the same moment in the right camera of a rectified pair; only corners that it
                shows, too, are chosen.

        Raises:
            InputError: no corner in the mask, or arrays of other shapes.
        """
        _check(left, mask, right)
        place = self._candidates(left, mask)
        if right is not None:
            both = np.isfinite(self._match(_chosen(left, place), right).disparity)
            place = place[both]
        if not len(place):
            raise InputError(
                "there is no corner on the body that could be followed; the mask has "
                f"{int(np.sum(mask))} pixels. Let more of the body be found, or wear a pattern."
            )
        state = _chosen(left, place[: self.count])
        return state if right is None else self._match(state, right)

    def step(self, state: Corners, left: Grey, right: Grey | None = None) -> Corners:
        """Follow the corners into the next frame.

        Raises:
            InputError: an image of another size.
        """
        _check(left, state.left, right)
        moved, seen = self._patches.follow(state.left, left, state.place, state.place, HALVINGS)
        place = np.where(seen[:, None], moved, np.nan)
        nearer, agrees = self._compared(state.later, left, place)
        exact, surely = self._compared(state.first, left, place)
        place = np.where(agrees[:, None], nearer, place)
        place = np.where(surely[:, None], exact, place)
        later = state.later
        if agrees.sum() < OLD_KEY * np.isfinite(place[:, 0]).sum():
            later = KeyFrame(left, place)
        after = replace(state, left=left, place=place, later=later)
        return after if right is None else self._match(after, right)

    @property
    def _patches(self) -> Patches:
        return Patches(self.window, self.back)

    def _candidates(self, left: Grey, mask: Flags) -> Array:
        """(n, 2) px, corners inside the mask, the best first."""
        inside = np.asarray(mask, dtype=np.uint8)
        # A patch that reaches over the edge of the body would follow the edge, not the body.
        inside = vision().erode(inside, np.ones((self.window, self.window), np.uint8))
        found = vision().goodFeaturesToTrack(
            left, SPARE * self.count, self.quality, self.spacing, mask=inside, blockSize=7
        )
        return np.zeros((0, 2)) if found is None else np.asarray(found, np.float64).reshape(-1, 2)

    def _compared(self, key: KeyFrame, left: Grey, place: Array) -> tuple[Array, Flags]:
        """Where a key frame says that its corners are, (K, 2) px, and whether to believe it."""
        turned, seen = _turned(key, place), np.isfinite(place[:, 0])
        guess = np.where(seen[:, None], place, turned.place)
        halvings = NEARBY if seen.any() else HALVINGS
        found, sure = self._patches.follow(turned.image, left, turned.place, guess, halvings)
        off = np.linalg.norm(found - guess, axis=1)
        return found, sure & (off < np.where(seen, NEAR_KEY, LOST))

    def _match(self, state: Corners, right: Grey) -> Corners:
        """The disparity of each corner that is seen."""
        left, guess = state.place, state.disparity.copy()
        for k in np.flatnonzero(state.seen & np.isnan(guess)):
            guess[k] = self._patches.along_row(state.left, right, left[k])
        shift = np.column_stack([guess, np.zeros(len(guess))])
        there, sure = self._patches.follow(state.left, right, left, left - shift)
        disparity = left[:, 0] - there[:, 0]
        sure &= (np.abs(left[:, 1] - there[:, 1]) < OFF_ROW) & (disparity > 0)
        return replace(state, disparity=np.where(sure, disparity, np.nan))


def _chosen(left: Grey, place: Array) -> Corners:
    """Corners in the frame in which they are chosen."""
    key = KeyFrame(left, place)
    return Corners(left, place, np.full(len(place), np.nan), key, key)


def _turned(key: KeyFrame, place: Array) -> KeyFrame:
    """The key frame, turned and stretched as its corners have been since."""
    both = np.isfinite(np.hstack([key.place, place])).all(axis=1)
    before, after = key.place[both], place[both]
    A = fitting = None
    if len(before) >= FOR_AFFINE:
        A, fitting = vision().estimateAffine2D(before, after)
    elif len(before) >= FOR_TURN:
        A, fitting = vision().estimateAffinePartial2D(before, after)
    if A is None or fitting is None or fitting.sum() < min(len(before), FOR_AFFINE):
        return key
    image = vision().warpAffine(key.image, A, key.image.shape[::-1])
    return KeyFrame(image, key.place @ A[:, :2].T + A[:, 2])


def _check(left: Grey, like: NDArray[Any], right: Grey | None) -> None:
    for image in (left, left if right is None else right):
        if image.dtype != np.uint8 or image.shape != like.shape or image.ndim != 2:
            raise InputError(
                f"expected a grey 8-bit image of shape {like.shape}, got {image.dtype} of shape "
                f"{image.shape}."
            )
