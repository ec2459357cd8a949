"""How large the residuals of a wrist sensor are, and how long they remember.

Nobody needs to declare noise: each of the six components has the mean squared residual that is
seen, degrees of freedom counted, with a declared level worth a few samples at first, and the mean
of its like (three forces, three torques) worth some more: on few samples six levels of their own
would be chance, and the smallest would pass for knowledge. tau is the
long-run variance over it: v_l = mean square of sums over blocks of l samples, per sample, grows
with l until blocks are longer than the memory; the largest v_l / v_1 is taken, or what the overlap
of the averaged windows makes of white noise, whichever is larger.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.payload.chart import SHARED, Guess
from bodyschema.learners.payload.sums import Sums, unknowns
from bodyschema.senses.wrench_means import FAITH

Array = NDArray[np.float64]

BLOCKS = 16
"""Blocks of one length that must be there before they say how long noise remembers."""


ALIKE = 12.0
"""Samples that the mean level of three like axes counts for beside that of one: axes of one sensor
differ by a factor of two or so, which a dozen samples are as sure of."""


@dataclass(frozen=True)
class Segment:
    """Samples during which the same loads hung on the sensor."""

    sums: Sums
    loads: tuple[int, ...]
    """Which of the K loads."""


@dataclass(frozen=True)
class Levels:
    """Size and memory of the residuals."""

    variance: Array
    """(6,) mean squared residual of each component, N^2 and (Nm)^2."""
    tau: Array
    """(6,) long-run variance over it, at least 1."""
    faith: float = FAITH
    """Samples that these levels count for when others are measured."""

    @property
    def v(self) -> Array:
        """(6,) long-run variance."""
        return self.variance * self.tau


def measured_levels(segments: Sequence[Segment], guess: Guess, believed: Levels) -> Levels:
    """Size and memory of the residuals at a guess."""
    squares = np.sum([s.sums.squares(_z(guess, s.loads)) for s in segments], axis=0)
    blocks = np.sum([s.sums.blocks for s in segments], axis=0).astype(np.float64)
    taken = (SHARED + guess.eta.size) / 6
    left = max(blocks[0] - taken, 1.0)
    if blocks[0] <= taken + 1:
        return believed
    variance = (squares[0] + believed.faith * believed.variance) / (left + believed.faith)
    weight = left + believed.faith
    alike = np.repeat(variance.reshape(2, 3).mean(axis=1), 3)
    variance = (weight * variance + ALIKE * alike) / (weight + ALIKE)
    tau = believed.tau.copy()
    if blocks[1] - taken >= BLOCKS:
        for group in (slice(0, 3), slice(3, 6)):
            tau[group] = np.maximum(tau[group], _memory(squares[:, group], blocks, taken))
    return Levels(variance, tau, believed.faith)


def _memory(squares: Array, blocks: Array, taken: float) -> float:
    """tau of one group of three components.

    The estimate's own unknowns take degrees of freedom from blocks as from samples.
    """
    white = float(np.sum(squares[0])) / max(blocks[0] - taken, 1.0)
    tau = 1.0
    for level in range(1, len(blocks)):
        left = blocks[level] - taken
        if left < BLOCKS or white <= 0:
            break
        per_sample = float(np.sum(squares[level])) / left / 2**level
        # What chance alone makes of white noise, one standard deviation, is not memory.
        chance = 1 + np.sqrt(2 / (3 * left))
        tau = max(tau, per_sample / white / chance)
    return tau


def _z(theta: Guess, loads: tuple[int, ...]) -> Array:
    return unknowns(theta.R, theta.phi[list(loads)].sum(axis=0), theta.bias)
