"""Corners that are born, followed by what they looked like at birth, and die.

From frame to frame a corner is led by optical flow; then its template of birth is sought at that
place under an affine map (`vision.anchor`), in the left picture and in the right one. Following
alone slips: always a little to the same side, so that averages over many corners do not help.

A corner is seen where the template is found again: alike enough for its contrast, and near where
the flow has led it. Where that fails a few times in a row the corner ends; one that comes back
later is a new corner with a new name. Corners are born where the picture, levelled to one contrast,
has them: otherwise the brightest thing in view would take all.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.vision.anchor import GRID, HALF, STEPS, WEIGHT, align, templates
from bodyschema.vision.corner_patches import Patches, vision

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Grey = NDArray[np.uint8]
Ints = NDArray[np.int64]

HALVINGS = 3
"""Of the pictures, from frame to frame: a motion of some 30 px is followed."""
ALIKE, GREY_NOISE = 0.9, 6.0
"""Correlation that a patch must have, and the variance of grey values at which it is halved: the
noise of the camera takes its share of a dim patch's likeness."""
NEAR = 2.5
"""px by which the template may be found beside where the flow has led it."""
MISSES = 4
"""Frames in a row without its template that end a corner."""
OFF_ROW = 0.7
"""px by which the rows of a corner may differ between left and right."""
BUCKET = 28
"""px, side of a square that gets one corner at most at a time."""
APART = 12.0
"""px between a new corner and those that live."""
BORDER = HALF + 3
"""px from the border in which no corner is born."""
LEVEL, FAINT = 31, 6.0
"""px over which contrast is levelled, and the grey value below which there is none to level."""
QUALITY = 0.004
"""Least smaller eigenvalue of the gradients' matrix of a corner, in the levelled picture."""


@dataclass(frozen=True)
class Corners:
    """The corners that live, and where they are in the last frame."""

    left: Grey
    """(height, width) the last frame."""
    name: Ints
    """(K,) of each corner; never given twice."""
    place: Array
    """(K, 2) u, v px: where its template was found, or where the flow has led it."""
    disparity: Array
    """(K,) px, u_left - u_right; nan where the right picture did not show it."""
    seen: Flags
    """(K,) whether the template was found in the left picture."""
    affine: Array
    """(K, 2, 2) how the patch is turned and stretched since birth."""
    misses: Ints
    """(K,) frames in a row without it."""
    template: Array
    """(K, 289) see `vision.anchor`."""
    descent: Array
    """(K, 6, 289) see `vision.anchor`."""
    variance: Array
    """(K,) of the template's grey values."""
    born: int = 0
    """Corners so far."""

    @property
    def stereo(self) -> Array:
        """(K, 3) u, v, disparity; nan where a corner was not seen in both pictures."""
        both = self.seen & np.isfinite(self.disparity)
        return np.where(both[:, None], np.column_stack([self.place, self.disparity]), np.nan)

    def only(self, kept: Flags) -> Corners:
        """Some of them, (K,)."""
        return replace(
            self, name=self.name[kept], place=self.place[kept], disparity=self.disparity[kept],
            seen=self.seen[kept], affine=self.affine[kept], misses=self.misses[kept],
            template=self.template[kept], descent=self.descent[kept], variance=self.variance[kept],
        )  # fmt: skip


def no_corners(left: Grey) -> Corners:
    """Nothing followed yet."""
    none = np.zeros(0, dtype=np.int64)
    return Corners(
        left, none, np.zeros((0, 2)), np.zeros(0), none.astype(bool), np.zeros((0, 2, 2)), none,
        np.zeros((0, len(GRID))), np.zeros((0, 6, len(GRID))), np.zeros(0),
    )  # fmt: skip


@dataclass(frozen=True)
class AnchoredTracker:
    """Follows corners by what they looked like at birth."""

    most: int = 40
    """Corners at a time."""

    def step(self, state: Corners, left: Grey, right: Grey) -> Corners:
        """Follow all corners into the next frame of a rectified pair."""
        if not len(state.name):
            return replace(state, left=left)
        led = _led(state.left, left, state.place)
        affine, place = state.affine.copy(), led.copy()
        alike, least = _sought(state, left, affine, place)
        near = np.linalg.norm(place - led, axis=1) < NEAR
        seen = (alike > least) & near
        misses = np.where(seen, 0, state.misses + 1)
        place = np.where(seen[:, None], place, led)
        affine = np.where(seen[:, None, None], affine, state.affine)
        moved = replace(state, left=left, place=place, affine=affine, seen=seen, misses=misses)
        inside = (place > HALF) & (place < np.array(left.shape[::-1]) - 1 - HALF)
        return _matched(moved, right).only((misses < MISSES) & inside.all(axis=1))

    def births(
        self, state: Corners, mask: Flags, right: Grey, bucket: int = BUCKET, most: int = 1000
    ) -> Corners:
        """With new corners of the last frame, where the mask has room for them.

        Args:
            state: after the last frame.
            mask: (height, width) where corners may be born.
            right: the right picture of the last frame; only what it shows too is born.
            bucket: px, side of a square that gets one corner at most.
            most: corners that are born at most.
        """
        room = min(self.most - len(state.name), most)
        if room <= 0:
            return state
        place = _candidates(state.left, mask, state.place, bucket)[: 2 * room]
        if not len(place):
            return state
        T, G, variance = templates(state.left, place)
        K = len(place)
        new = Corners(
            state.left, state.born + np.arange(K), place, np.full(K, np.nan), np.ones(K, bool),
            np.tile(np.eye(2), (K, 1, 1)), np.zeros(K, np.int64), T, G, variance,
        )  # fmt: skip
        new = _matched(new, right)
        new = new.only(np.isfinite(new.disparity))
        new = new.only(np.arange(len(new.name)) < room)
        return _joined(state, new, state.born + K)


def enough(template: Array, found: Array, alike: float) -> Array:
    """(K,) correlation that patches must have; more than there is where nothing is to be seen.

    Args:
        template: (K,) variance of grey values at birth.
        found: (K,) variance now.
        alike: correlation that patches without noise must have.
    """
    contrast = np.minimum(template, found)
    least = alike * contrast / (contrast + GREY_NOISE)
    return np.asarray(np.where(contrast > GREY_NOISE, least, np.inf))


def _led(before: Grey, now: Grey, place: Array) -> Array:
    """(K, 2) px where optical flow leads corners; where they were if it is lost."""
    cv2 = vision()
    found, status, _ = cv2.calcOpticalFlowPyrLK(
        before, now, place[:, None].astype(np.float32), None, winSize=(15, 15), maxLevel=HALVINGS,
        criteria=(cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, 15, 0.03),
    )  # fmt: skip
    there = np.asarray(found, dtype=np.float64).reshape(-1, 2)
    return np.where(status.reshape(-1, 1).astype(bool), there, place)


def _sought(state: Corners, image: Grey, affine: Array, place: Array) -> tuple[Array, Array]:
    """Likeness of each corner where its template fits best, and what it must be."""
    alike, variance = np.empty(len(place)), np.zeros(len(place))
    align(image, state.template, state.descent, WEIGHT, GRID, affine, place, STEPS, alike, variance)
    return alike, enough(state.variance, variance, ALIKE)


def _matched(state: Corners, right: Grey) -> Corners:
    """With the disparity of each corner that is seen."""
    rows, guess = Patches(2 * HALF + 1, 0.5), state.disparity.copy()
    for k in np.flatnonzero(state.seen & np.isnan(guess)):
        guess[k] = rows.along_row(state.left, right, state.place[k])
    affine, place = state.affine.copy(), state.place - np.column_stack([guess, 0 * guess])
    alike, least = _sought(state, right, affine, place)
    level = np.abs(place[:, 1] - state.place[:, 1]) < OFF_ROW
    disparity = state.place[:, 0] - place[:, 0]
    with np.errstate(invalid="ignore"):
        sure = state.seen & (alike > least) & level & (disparity > 0)
    return replace(state, disparity=np.where(sure, disparity, np.nan))


def _candidates(left: Grey, mask: Flags, living: Array, bucket: int) -> Array:
    """(n, 2) px: the best corner of each square that has none, the best first."""
    cv2 = vision()
    height, width = left.shape
    grey = left.astype(np.float32)
    mean = cv2.blur(grey, (LEVEL, LEVEL))
    spread = np.sqrt(np.maximum(cv2.blur(grey**2, (LEVEL, LEVEL)) - mean**2, 0))
    strength = cv2.cornerMinEigenVal((grey - mean) / (spread + FAINT), 7)
    allowed = np.zeros_like(mask)
    allowed[BORDER:-BORDER, BORDER:-BORDER] = mask[BORDER:-BORDER, BORDER:-BORDER]
    for u, v in np.rint(living).astype(int):
        r = int(APART)
        allowed[max(v - r, 0) : v + r + 1, max(u - r, 0) : u + r + 1] = False
    strength = np.where(allowed, strength, 0)
    found = []
    for v in range(0, height, bucket):
        for u in range(0, width, bucket):
            square = strength[v : v + bucket, u : u + bucket]
            best = int(np.argmax(square))
            value = float(square.flat[best])
            if value > QUALITY:
                found.append((value, u + best % square.shape[1], v + best // square.shape[1]))
    found.sort(reverse=True)
    return np.array([(u, v) for _, u, v in found], dtype=np.float64).reshape(-1, 2)


def _joined(state: Corners, new: Corners, born: int) -> Corners:
    """Both together."""
    names = ("name", "place", "disparity", "seen", "affine", "misses", "template", "descent",
             "variance")  # fmt: skip
    together = {n: np.concatenate([getattr(state, n), getattr(new, n)]) for n in names}
    return replace(state, born=born, **together)
