"""Offsets from a stream of pictures: each adds what it says, and nothing is forgotten.

The offsets x and the biases b of the cameras do not change, so pictures add up in information form.
With H_k z = g_k the normal equations of key picture k round the z at which it was last looked at,

    z = (P + sum_k H_k + H_t)^-1 (sum_k g_k + g_t)

for the picture of this moment, t, looked at anew in each of `REACH`. Then the key picture that was
looked at longest ago is looked at again, so that all of them follow the estimate. A picture becomes
a key when its posture is new; when there are too many, one of the two that are most alike goes.

The first picture, and any after one that was lost, starts from guesses over the prior, scored on
the key pictures (see `markerless`). Vicente, Jamone, Bernardino 2016 keep wandering guesses, which
forget as fast as they wander.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.body.parameters import free_joints
from bodyschema.body.tree import Body
from bodyschema.imagination.colours import ColourModel
from bodyschema.imagination.surface import Surface
from bodyschema.learning.images.markerless import Markerless, is_lost, learn_colours, noise_at
from bodyschema.learning.images.rim_fit import (
    Normal,
    RimModel,
    RimRows,
    Sight,
    design_effect,
    without_bias,
)
from bodyschema.senses.images import Images

Array = NDArray[np.float64]

REACH = (8.0, 4.0)
"""pixels; while the hand is followed the outline is near."""


@dataclass(frozen=True)
class Key:
    """A picture that is kept."""

    seen: Images
    rows: RimRows
    """When it was last looked at."""
    normal: Normal
    z: Array
    """(n,) then."""


@dataclass(frozen=True)
class TrackState:
    """What is known between two pictures."""

    model: RimModel
    keys: tuple[Key, ...]
    """The one that was looked at longest ago comes first."""
    z: Array
    """(n_joints + n_cameras,) offsets in rad, biases in pixels; empty before the first picture."""
    colours: tuple[ColourModel, ...]
    """Of each camera; empty with masks."""
    lost: bool
    """Whether the next picture starts from guesses."""


@dataclass(frozen=True)
class TrackInfo:
    """What one picture brought."""

    offsets: Array
    """(n_joints,) rad."""
    covariance: Array
    """(n_joints, n_joints) rad^2."""
    matched: float
    """Share of the imagined contour that was found within 2 pixels."""
    lost: bool
    """Whether the picture does not show the body there; it has not been learned from then."""
    effective_size: float = 1.0
    """There is one hypothesis."""


@dataclass(frozen=True)
class ContourTracker:
    """Settings."""

    surface: Surface
    """What shows of the body."""
    seeds: int = 200
    """Guesses when nothing is known."""
    prior: float = float(np.deg2rad(5))
    """rad, standard deviation of an offset."""
    keys: int = 16
    """Pictures that are kept."""
    apart: float = 0.03
    """rad; postures nearer than that to a key tell nothing new."""
    seed: int = 0
    """The same seed gives the same answer."""

    def start(self, body: Body, joints: Sequence[str]) -> TrackState:
        """Before the first picture.

        Args:
            body: what is believed; its frames carry the cameras and the surface's pieces.
            joints: whose offsets are unknown.
        """
        free = free_joints(body, ["offsets"], joints)
        model = RimModel(self.surface, body, free.with_prior(np.full(len(free), self.prior)))
        return TrackState(model, (), np.zeros(0), (), True)

    def step(self, state: TrackState, seen: Images) -> tuple[TrackState, TrackInfo]:
        """The state after one more picture."""
        if state.lost:
            state = self._search(state, seen)
        model, z, n = state.model, state.z, len(state.model.parameters)
        sight, known = Sight.of(seen, state.colours), [key.normal for key in state.keys]
        for reach in REACH:
            rows = model.rows(sight, z, reach)
            normal = model.normal(rows, z, noise_at(reach))
            at, z = z, model.solve([*known, normal], len(z) - n)
        matched = rows.matched / max(rows.length, 1.0)
        lost = is_lost(matched, seen.masked)
        if lost:
            return replace(state, lost=True), self._info(state, rows, state.z, matched, True)
        state = replace(state, z=z, keys=self._kept(state, Key(seen, rows, normal, at)))
        return self._reviewed(state), self._info(state, rows, z, matched, False)

    def _search(self, state: TrackState, seen: Images) -> TrackState:
        """From guesses, by the key pictures and this one."""
        frames = [*(key.seen for key in state.keys), seen]
        finder = Markerless(self.surface, seeds=self.seeds, seed=self.seed)
        z = finder.start(state.model, frames)
        colours = () if seen.masked else tuple(learn_colours(state.model, z, frames))
        state = replace(state, z=z, colours=colours, lost=False)
        return replace(state, keys=tuple(self._again(state, key) for key in state.keys))

    def _kept(self, state: TrackState, new: Key) -> tuple[Key, ...]:
        """The keys with a new one, if its posture is."""
        if not state.keys:
            return (new,)
        q = np.array([key.seen.q for key in (*state.keys, new)])
        away = np.linalg.norm(q[:, None] - q, axis=2) + np.diag(np.full(len(q), np.inf))
        if away[-1].min() < self.apart:
            return state.keys
        keys = [*state.keys, new]
        if len(keys) > self.keys:
            keys.pop(int(np.argmin(away[:-1].min(axis=1))))
        return tuple(keys)

    def _reviewed(self, state: TrackState) -> TrackState:
        """The oldest look at a key is taken anew."""
        first, *others = state.keys
        return replace(state, keys=(*others, self._again(state, first)))

    def _again(self, state: TrackState, key: Key) -> Key:
        sight = Sight.of(key.seen, state.colours)
        rows = state.model.rows(sight, state.z, REACH[-1])
        normal = state.model.normal(rows, state.z, noise_at(REACH[-1]))
        return Key(key.seen, rows, normal, state.z)

    def _info(
        self, state: TrackState, rows: RimRows, z: Array, matched: float, lost: bool
    ) -> TrackInfo:
        """Covariance from the key pictures; of one of them alone before there are any."""
        n = len(state.model.parameters)
        told = [key.rows for key in state.keys] or [rows]
        f = design_effect(told, z, n)
        H = np.sum([r.H for r in told], axis=0) / f + np.diag(state.model.prior(len(z) - n))
        P = np.linalg.inv(without_bias(H, n))
        return TrackInfo(z[:n], (P + P.T) / 2, matched, lost)
