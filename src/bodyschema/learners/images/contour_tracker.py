"""Offsets from a stream of pictures: each adds what it says, and nothing is forgotten.

The offsets x and what cameras and meshes have wrong y (`doubts`) do not change, so pictures add up
in information form. With H_k z = g_k the normal equations of key picture k round the z = (x, y) at
which it was last looked at,

    z = (P + sum_k H_k + H_t)^-1 (sum_k g_k + g_t)

for the picture of this moment, t, looked at anew in each of `REACH`. Then the key picture that was
looked at longest ago is looked at again, so that all of them follow the estimate. A picture becomes
a key when its posture is new; when there are too many, one of the two that are most alike goes.

The first picture, and any after one that was lost, starts from guesses over the prior, scored on
the key pictures (see `markerless`); those that explain the picture about as well as the best are
all followed until the pictures leave one (see `hypothesis`). Vicente, Jamone, Bernardino 2016 keep
wandering guesses, which forget as fast as they wander.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.estimate import Estimate
from bodyschema.learners.images.doubts import Doubts
from bodyschema.learners.images.hypothesis import REACH, Hypothesis, Key, survivors, weights
from bodyschema.learners.images.markerless import Markerless, learn_colours
from bodyschema.learners.images.markerless_fit import is_lost
from bodyschema.learners.images.rim_fit import RimModel
from bodyschema.learners.images.rim_information import design_effect, without
from bodyschema.learners.learner import in_turn
from bodyschema.learners.published.resampling import effective_size
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_joints
from bodyschema.senses.images import Images
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TrackState:
    """What is known between two pictures."""

    model: RimModel
    hypotheses: tuple[Hypothesis, ...]
    """The likeliest first; none before the first picture."""
    lost: bool
    """Whether the next picture starts from guesses."""


@dataclass(frozen=True)
class TrackInfo:
    """What one picture brought."""

    whole: Estimate
    """Of the offsets, which come first, and of the turns of the cameras."""
    n_joints: int
    matched: float
    """Share of the imagined contour that was found within 2 pixels."""
    lost: bool
    """Whether the picture does not show the body there; it has not been learned from then."""
    effective_size: float
    """How many equally likely hypotheses those that are left are worth."""
    ambiguous: bool
    """Whether more than one is left; the offsets are those of the likeliest, and the covariance
    has its distance from the others in it."""

    @property
    def offsets(self) -> Array:
        """(n_joints,) rad."""
        return self.whole.x[: self.n_joints]

    @property
    def covariance(self) -> Array:
        """(n_joints, n_joints) rad^2."""
        return self.whole.covariance[: self.n_joints, : self.n_joints]


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
    doubts: Doubts = field(default_factory=Doubts)
    """What cameras and meshes may have wrong."""
    seed: int = 0
    """The same seed gives the same answer."""

    def start(self, body: Body, joints: Sequence[str]) -> TrackState:
        """Before the first picture.

        Args:
            body: what is believed; its frames carry the cameras and the surface's pieces.
            joints: whose offsets are unknown.
        """
        free = free_joints(body, ["offsets"], joints)
        free = free.with_prior(np.full(len(free), self.prior))
        model = RimModel.of(self.surface, body, free, (), self.doubts)
        return TrackState(model, (), True)

    def step(
        self, state: TrackState, moment: tuple[Images, ...]
    ) -> tuple[TrackState, tuple[TrackInfo, ...]]:
        """The state after the images of one moment."""
        return in_turn(self._learn, state, moment)

    def _learn(self, state: TrackState, seen: Images) -> tuple[TrackState, TrackInfo]:
        """The state after one more picture."""
        begun = self._search(state, seen) if state.lost else state
        model, before = begun.model, begun.hypotheses
        found = [Hypothesis.followed(model, one.z, one.keys, one.colours, seen) for one in before]
        matched = max(one.matched for one in found)
        if is_lost(matched, seen.masked):
            # What a search finds in a picture without the body does not replace what was known.
            known = state if state.hypotheses else begun
            return replace(known, lost=True), _info(model, known.hypotheses, matched, True)
        alive = survivors([replace(one, keys=self._kept(one)) for one in found])
        reviewed = tuple(_reviewed(model, one) for one in alive)
        return replace(begun, hypotheses=reviewed), _info(model, alive, alive[0].matched, False)

    def _search(self, state: TrackState, seen: Images) -> TrackState:
        """From guesses, by the key pictures and this one."""
        model, old = state.model, state.hypotheses
        if not old:
            model = RimModel.of(self.surface, model.body, model.wanted, seen.cameras, self.doubts)
        frames = [*(key.seen for key in old[0].keys), seen] if old else [seen]
        found = []
        finder = Markerless(self.surface, seeds=self.seeds, seed=self.seed)
        for z in finder.guesses(model, frames):
            colours = () if seen.masked else tuple(learn_colours(model, z, frames))
            found.append(Hypothesis.followed(model, z, (), colours, seen))
        likely = [
            replace(
                one,
                keys=tuple(
                    Key.look(model, one.z, one.colours, old_seen, REACH[-1])
                    for old_seen in frames[:-1]
                ),
            )
            for one in survivors(found)
        ]
        return TrackState(model, tuple(likely), False)

    def _kept(self, one: Hypothesis) -> tuple[Key, ...]:
        """The keys with the newest picture, if its posture is new."""
        if not one.keys:
            return (one.now,)
        q = np.array([key.seen.q for key in (*one.keys, one.now)])
        away = np.linalg.norm(q[:, None] - q, axis=2) + np.diag(np.full(len(q), np.inf))
        if away[-1].min() < self.apart:
            return one.keys
        keys = [*one.keys, one.now]
        if len(keys) > self.keys:
            keys.pop(int(np.argmin(away[:-1].min(axis=1))))
        return tuple(keys)


def _reviewed(model: RimModel, one: Hypothesis) -> Hypothesis:
    """The key that was looked at longest ago is looked at again."""
    first, *others = one.keys
    again = Key.look(model, one.z, one.colours, first.seen, REACH[-1])
    return replace(one, keys=(*others, again))


def _info(
    model: RimModel, hypotheses: Sequence[Hypothesis], matched: float, lost: bool
) -> TrackInfo:
    """Of the likeliest, by its key pictures; by the newest alone before there are any."""
    best, w, n = hypotheses[0], weights(hypotheses), len(model.variables)
    told = [key.rows for key in best.keys or (best.now,)]
    H = np.sum([rows.H for rows in told], axis=0) / design_effect(told, model.scale, n)
    said = without(H, model.scale, n)
    whole = Estimate(model.body, model.variables, best.z[:n], said)
    if len(hypotheses) > 1:
        away = np.array([one.z[:n] - best.z[:n] for one in hypotheses])
        P = whole.covariance + away.T @ (w[:, None] * away)
        prior = np.diag(model.variables.prior_std**-2.0)
        whole = replace(whole, data_information=np.linalg.inv(P) - prior)
    return TrackInfo(
        whole, len(model.wanted), matched, lost, effective_size(w), len(hypotheses) > 1
    )
