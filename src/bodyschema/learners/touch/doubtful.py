"""Touches that are none: where nothing taught the load, that crept in, or that a load makes.

What the load explains of the wrench errs by L z (`unexplained`), z of unit variance. Where

    e(t) = size of the force part of L(t), the largest standard deviation of a direction

is several times what it was in the quiet motion, the posture lies outside those in which the load
was taught, and a wrench there is the load's own error until it is many times e. A touch comes
within a moment; an offset that drifts, or a posture that is left slowly, creeps in: then the wrench
was nearly as large before it was noticed. And what lasts through several postures and is as well
explained by another mass and centre of mass, w = Y d, is perhaps a load that changed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.touch.finder import Touch
from bodyschema.learners.touch.unexplained import Unexplained

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Doubt = Literal["", "untaught", "crept", "load"]

OUTSIDE = 3.0
"""Times e of the quiet motion (its 95th percentile), beyond which a posture was not taught."""

LARGE = 6.0
"""Times e that a force must be to be a touch there."""

BEFORE = (1.5, 0.4)
"""s before a touch is noticed, over which its beginning is looked at: from, to."""

CREPT = 0.5
"""Share of the wrench, as it was noticed, that must have been there before for it to have crept."""

LASTS, EXPLAINED = 2.0, 0.9
"""s from which a touch may be another load, and the share of its wrench (squared) that this must
explain."""

MOST, ROUNDS = 0.7, 5
"""Share of the samples that another load must explain: the rest may be touches; and the turns in
which they are found (least trimmed squares, Rousseeuw 1984)."""

ARM = 0.1
"""m: torque over force of what is felt."""

LEAST = 3
"""Samples before a touch from which that is told."""


@dataclass(frozen=True)
class Taught:
    """How well the load is known, and was in the quiet motion."""

    usual: float
    """N, e of the quiet motion."""
    noise: float
    """N, of a sample."""

    @classmethod
    def by(cls, quiet: Unexplained, noise: Array) -> Taught:
        """From the quiet motion, and the noise (6, 6) of a sample."""
        e = force_error(quiet)
        return cls(float(np.quantile(e, 0.95)), float(np.sqrt(np.trace(noise[:3, :3]) / 3)))

    def outside(self, left: Unexplained) -> Flags:
        """(n,) samples in postures that were not taught."""
        return np.asarray(force_error(left) > OUTSIDE * max(self.usual, self.noise))

    def doubt(self, touch: Touch, left: Unexplained, Y: Array) -> Doubt:
        """Why a touch is none; "" if nothing speaks against it.

        Args:
            touch: that was felt.
            left: the whole recording.
            Y: (n, 6, 10) its regressor.
        """
        until = float(left.time[-1]) if touch.ends is None else touch.ends
        during = (left.time >= touch.begins) & (left.time <= until)
        error = float(force_error(left.take(during)).max(initial=0.0))
        size = float(np.linalg.norm(touch.force))
        if error > OUTSIDE * max(self.usual, self.noise) and size < LARGE * error:
            return "untaught"
        if until - touch.begins > LASTS and self._loaded(left.wrench[during], Y[during]):
            return "load"
        start, stop = (touch.begins - gap for gap in BEFORE)
        ago = left.wrench[(left.time >= start) & (left.time <= stop), :3]
        now = left.wrench[(left.time >= touch.begins) & (left.time <= touch.begins + 0.2), :3]
        if len(ago) < LEAST or not len(now):
            return ""
        then, here = ago.mean(axis=0), now.mean(axis=0)
        return "crept" if then @ here > CREPT * float(here @ here) else ""

    def _loaded(self, w: Array, Y: Array) -> bool:
        """Whether another mass and centre of mass explain wrenches (n, 6)."""
        scale, kept = np.repeat([1.0, ARM], 3), np.arange(len(w))
        for _ in range(ROUNDS):
            A, b = (Y[kept][:, :, :4] / scale[:, None]).reshape(-1, 4), (w[kept] / scale).ravel()
            d = np.linalg.lstsq(A, b, rcond=None)[0]
            e = np.sum(((w - Y[:, :, :4] @ d) / scale) ** 2, axis=1)
            kept = np.argsort(e, kind="stable")[: max(round(MOST * len(w)), LEAST)]
        whole = float(np.sum((w[kept] / scale) ** 2))
        return float(e[kept].sum()) < (1 - EXPLAINED) * whole


def force_error(left: Unexplained) -> Array:
    """(n,) N: e of the module's text."""
    L = left.factor[:, :3]
    return np.asarray(np.sqrt(np.linalg.eigvalsh(L @ np.swapaxes(L, 1, 2))[:, -1].clip(0.0)))
