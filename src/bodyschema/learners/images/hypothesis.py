"""Hypotheses of where an arm is, each with what it saw, weighed until one is left.

One pair of pictures may fit two postures of an arm. Each that fits about as well is followed on its
own; over the key pictures k of a hypothesis, with e the distances of the outline in pixels,

    log w = - INDEPENDENT / 2 sum_k mean_k rho(e),     rho = M^2 e^2 / (M^2 + e^2),   M = MATCHED

mean_k over the length of the imagined contour, what was not found with rho = M^2. The likelihood of
all pixels would be sure at once; it is tempered: of a whole contour only INDEPENDENT parts are
counted as told on their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.images.rim_fit import Normal, RimModel, RimRows, noise_at
from bodyschema.learners.images.sight import Sight
from bodyschema.senses.images import Images
from bodyschema.vision.colours import ColourModel

Array = NDArray[np.float64]

REACH = (8.0, 4.0)
"""pixels; while the hand is followed the outline is near."""

INDEPENDENT = 25.0
"""Parts of the contour in the pictures of one moment."""

LEAST_WEIGHT = 0.01
"""A hypothesis with less is given up."""

SAME = 1.0
"""pixels; two hypotheses whose outlines are nearer to each other, root mean square, are one."""


@dataclass(frozen=True)
class Key:
    """A picture, and what it said when it was last looked at."""

    seen: Images
    rows: RimRows
    normal: Normal
    z: Array
    """(size,) at which it was looked at."""

    @classmethod
    def look(
        cls,
        model: RimModel,
        z: Array,
        colours: tuple[ColourModel, ...],
        seen: Images,
        reach: float,
    ) -> Key:
        """At z, within `reach` pixels."""
        rows = model.rows(Sight.of(seen, colours), z, reach)
        return cls(seen, rows, model.normal(rows, z, noise_at(reach)), z)


@dataclass(frozen=True)
class Hypothesis:
    """One way in which the arm may be off."""

    z: Array
    """(size,) offsets and turns of cameras in rad, doubts."""
    keys: tuple[Key, ...]
    """The one that was looked at longest ago comes first."""
    colours: tuple[ColourModel, ...]
    """Of each camera; empty with masks."""
    now: Key
    """The newest picture, kept or not."""

    @classmethod
    def followed(
        cls,
        model: RimModel,
        z: Array,
        keys: tuple[Key, ...],
        colours: tuple[ColourModel, ...],
        seen: Images,
    ) -> Hypothesis:
        """From z on, by the key pictures and a new one that is looked at anew in each of REACH."""
        known = [key.normal for key in keys]
        for reach in REACH:
            now = Key.look(model, z, colours, seen, reach)
            z = model.solve([*known, now.normal])
        return cls(z, keys, colours, now)

    @property
    def evidence(self) -> float:
        """log w, up to a constant."""
        told = self.keys or (self.now,)
        return -INDEPENDENT / 2 * sum(key.rows.loss for key in told)

    @property
    def matched(self) -> float:
        """Share of the contour that is found in the newest picture."""
        return self.now.rows.matched


def weights(hypotheses: Sequence[Hypothesis]) -> Array:
    """(n,) shares of the belief."""
    log = np.array([hypothesis.evidence for hypothesis in hypotheses])
    w = np.exp(log - log.max())
    return np.asarray(w / w.sum())


def survivors(hypotheses: Sequence[Hypothesis]) -> tuple[Hypothesis, ...]:
    """Those that are still likely and not the same as a likelier one, the likeliest first."""
    w, kept = weights(hypotheses), list[Hypothesis]()
    for i in np.argsort(-w, kind="stable"):
        one = hypotheses[i]
        if w[i] >= LEAST_WEIGHT and not any(same(one, other) for other in kept):
            kept.append(one)
    return tuple(kept)


def same(a: Hypothesis, b: Hypothesis) -> bool:
    """Whether both imagine the same outline in the newest picture."""
    off, weight = b.z - a.z, float(b.now.rows.weight.sum())
    return bool(off @ b.now.rows.H @ off <= SAME**2 * weight)
