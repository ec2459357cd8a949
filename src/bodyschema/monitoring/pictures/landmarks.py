"""Corners of the hand that are remembered by how they look: are they still there?

A corner that was surely on the hand leaves its template, its place on the hand and the direction
from which it was first seen. Whenever the hand is seen from nearly the same side again, the
template is sought where it should be. It is mostly found, also long after the corner has died.
When all that is remembered of one region is missed, look after look, while the rest of the hand is
found, what was in that region is gone: a tool was put down, or swapped for another one.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.hand_eye.corner_fit import CornerFit
from bodyschema.learners.hand_eye.corner_rows import CornerRows
from bodyschema.learners.hand_eye.stereo_points import Stereo
from bodyschema.vision.anchor import GRID, HALF, STEPS, WEIGHT, align
from bodyschema.vision.anchored_corners import NEAR, Corners, enough

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Grey = NDArray[np.uint8]
Ints = NDArray[np.int64]

SIDE_ON = np.deg2rad(12.0)
"""rad by which the view may have turned for a template to be sought."""
MOST = 400
"""Landmarks that are kept, the newest."""
REGION = 0.05
"""m round a landmark that is missed: what is there has gone with it, or has not."""
LOOKS, LEAST, GONE, THERE = 2, 4, 0.8, 0.5
"""Misses in a row, landmarks of a region that must have them, share of those looked for lately that
they must be, and share of the rest that must have been found."""
LIKE = 0.75
"""Correlation that a remembered template must have: less than one that is followed."""
PROVEN, RELIABLE, OFTEN = 4, 0.8, 4
"""Looks that must have found a landmark, and share of its looks before it was missed, so that it
may be missed; looks after which one that is mostly missed is forgotten."""
LATELY = 3.0
"""s within which a look counts."""


@dataclass(frozen=True)
class Landmarks:
    """What is remembered, L of them."""

    name: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(L,) of the corner."""
    place: Array = field(default_factory=lambda: np.zeros((0, 3)))
    """(L, 3) m on the hand."""
    view: Array = field(default_factory=lambda: np.zeros((0, 3, 3)))
    """(L, 3, 3) rotation R_cam_hand at birth."""
    template: Array = field(default_factory=lambda: np.zeros((0, len(GRID))))
    descent: Array = field(default_factory=lambda: np.zeros((0, 6, len(GRID))))
    variance: Array = field(default_factory=lambda: np.zeros(0))
    misses: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(L,) looks in a row that missed."""
    hits: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(L,) looks that found it."""
    looks: Ints = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    """(L,) looks so far."""
    looked: Array = field(default_factory=lambda: np.zeros(0))
    """(L,) s, the last look."""

    def only(self, kept: Flags) -> Landmarks:
        """Some of them, (L,)."""
        return Landmarks(*(getattr(self, name)[kept] for name in self.__dataclass_fields__))

    def near(self, place: Array, radius: float) -> Flags:
        """(L,) which lie within a radius, m, of places (K, 3)."""
        away = np.linalg.norm(self.place[:, None] - place[None], axis=2)
        return np.asarray(away.min(axis=1, initial=np.inf) < radius)

    def joined(self, more: Landmarks) -> Landmarks:
        """With new ones."""
        names = self.__dataclass_fields__
        every = (np.concatenate([getattr(self, n), getattr(more, n)])[-MOST:] for n in names)
        return Landmarks(*every)

    def sought(self, image: Grey, time: float, T_cam_hand: Array, stereo: Stereo) -> Landmarks:
        """After one look at a picture.

        Args:
            image: (height, width), of the left camera.
            time: s.
            T_cam_hand: (4, 4) as believed.
            stereo: the lens.
        """
        if not len(self.name):
            return self
        found = np.zeros(len(self.name), dtype=bool)
        turn = np.einsum("lji,jk->lik", self.view, T_cam_hand[:3, :3])
        angle = np.arccos(np.clip((np.trace(turn, axis1=1, axis2=2) - 1) / 2, -1, 1))
        c = self.place @ T_cam_hand[:3, :3].T + T_cam_hand[:3, 3]
        where = stereo.project(c)[:, :2]
        size = np.array(image.shape[::-1])
        inside = ((where > 2 * HALF) & (where < size - 1 - 2 * HALF)).all(axis=1)
        looked = (angle < SIDE_ON) & inside & (c[:, 2] > 0.1)
        k = np.flatnonzero(looked)
        affine, place = np.tile(np.eye(2), (len(k), 1, 1)), where[k].copy()
        alike, variance = np.empty(len(k)), np.zeros(len(k))
        align(image, self.template[k], self.descent[k], WEIGHT, GRID, affine, place, STEPS,
              alike, variance)  # fmt: skip
        near = np.linalg.norm(place - where[k], axis=1) < NEAR
        found[k] = (alike > enough(self.variance[k], variance, LIKE)) & near
        return replace(
            self,
            misses=np.where(looked, np.where(found, 0, self.misses + 1), self.misses),
            hits=self.hits + found,
            looks=self.looks + looked,
            looked=np.where(looked, time, self.looked),
        )

    @property
    def worth_keeping(self) -> Flags:
        """(L,) those that are not mostly missed: corners of something else, or hidden ones."""
        return np.asarray(
            (self.looks < OFTEN) | (self.hits >= self.looks / 2) | (self.hits >= PROVEN)
        )

    def gone(self, time: float) -> Flags:
        """(L,) landmarks of a region whose landmarks are all missed; none if nothing has gone."""
        before = self.looks - self.misses
        proven = (self.hits >= PROVEN) & (self.hits >= RELIABLE * before)
        lately = (time - self.looked < LATELY) & proven
        missed = lately & (self.misses >= LOOKS)
        none = np.zeros(len(self.name), dtype=bool)
        if missed.sum() < LEAST:
            return none
        for k in np.flatnonzero(missed):
            near = np.linalg.norm(self.place - self.place[k], axis=1) < REGION
            inside, outside = lately & near, lately & ~near
            if (missed & near).sum() < LEAST or missed[inside].mean() < GONE:
                continue
            if outside.sum() >= LEAST and (~missed[outside]).mean() > THERE:
                return np.asarray(near)
        return none


def remembered(
    landmarks: Landmarks, hand: Corners, fit: CornerFit, rows: CornerRows, sure: Ints
) -> Landmarks:
    """With corners that live and are surely on the hand, if they are new.

    Args:
        landmarks: so far.
        hand: corners that live, named from 0.
        fit: where they are.
        rows: that it rests on, where corners are named from 1.
        sure: (n,) names, from 1, of those that are surely on the hand.
    """
    new = np.isin(hand.name + 1, sure) & ~np.isin(hand.name, landmarks.name)
    name, n = hand.name[new], int(new.sum())
    if not n:
        return landmarks
    row = np.searchsorted(rows.corner, name + 1)
    camera = fit.cameras[rows.camera[row]]
    view = np.swapaxes(camera[:, :3, :3], 1, 2) @ rows.T_world_carrier[row, :3, :3]
    none = np.zeros(n, dtype=np.int64)
    more = Landmarks(
        name, fit.place[np.searchsorted(fit.names, name + 1)], view, hand.template[new],
        hand.descent[new], hand.variance[new], none, none, none, np.full(n, -np.inf),
    )  # fmt: skip
    return landmarks.joined(more)
