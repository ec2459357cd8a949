"""Is it me? For each cell the log odds that its motion comes from the joints, motion by motion.

A motion and the rest before it give a cell the flow energy C, of which K x explains e at the price
p (`visual_jacobian`); joints that carry the camera are given to both sides. Energies are counted
per independent moment: flow is smooth in time, so a motion of T seconds has k = T / CORRELATION of
them, and C and e are scaled to that number. What a motion may be:

    still   nothing is seen              ln p = -C / 2
    mover   anything, any strength       ln p = U(C)
    driven  K x and something more       ln p = U(C - e) - p + ln 4 r^3

    U(C) = (k + 1) ln(k + 1) - (k + 1) ln(k + 1 + C / 2),    r = e / (C + k)

U is the normal distribution with its unknown variance integrated out (inverse gamma prior whose
weight is that of the motion's own moments, floor at the least noise). The law 4 r^3 of the share
that is explained says that what the joints drive moves mostly with them; the flow of a mover,
smooth in time, always has some share in common with them. What is not me is still or a mover, by
halves. What is me is driven, or still, since these joints may not move it. How probable that is,
q, follows from what earlier motions foretell, F = |K0 x|^2, and from how far that may be off, the
spread D of K0 x (`visual_jacobian`), both in units of noise:

    q = RARELY        F >= FORETELLING (1 + D)     it would be seen to move
        MOSTLY_STILL  F + D < FORETELLING          it would not
        1/2           otherwise

So a rod that is let go stops being me as soon as what carried it moves without it, and who moves
while I rest is not me; a motion that leaves a cell of mine still, as all before say that it would,
says next to nothing about it. Neither does a motion that is made again (the confirming motion, the
way back) and leaves still what it left still before: it has the same blind spot. With the cosine
c = tr(S S') / |S| |S'| of the sums S of x x^T of both motions, q <- q + c (MOSTLY_STILL - q) there.

The log Bayes factor of a motion is held within LEAST .. MOST: one motion, whose flow may be wrong
in ways that no noise model has, may not settle all. The log odds fade and are held within +-CAP, so
that the answer stays ready to change.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.attention.visual_jacobian import Explained, MotionSums, explained, joined

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Ints = NDArray[np.int64]

PRIOR = 0.1
"""Probability that a cell shows the body, before it has moved."""
CORRELATION = 5.0 / 30.0
"""s, over which flow is one moment."""
LEAST, MOST, CAP = -6.0, 6.5, 12.0
"""nats"""
MOSTLY = 3.0
"""Exponent of r in the law of the explained share."""
FADING = 0.97
"""Of log odds, from motion to motion."""
FORETELLING = 4.0
"""Energy in units of noise from which earlier motions foretell that the cell moves."""
RARELY, MOSTLY_STILL = 0.02, 0.9
"""Probability that a cell of the body is still when it was foretold to move, and not to."""


@dataclass(frozen=True)
class Contingency:
    """State: odds at every lag."""

    log_odds: Array
    """(L, N) nats, before the prior's."""
    motions: int = 0
    missed: Flags | None = None
    """(L, N) cells that the last motion was foretold to move and left still."""
    turns: Array | None = None
    """(L, J, J) S of the last motion."""


def weigh(
    state: Contingency, before: MotionSums, motion: MotionSums, seconds: float,
    own: Ints, camera: Ints, precision: float,
) -> tuple[Contingency, Array]:  # fmt: skip
    """Weigh a motion that is over.

    Args:
        state: odds so far.
        before: belief about the visual Jacobians, faded.
        motion: sums of the motion and the rest before it.
        seconds: it took.
        own: joints that move the body.
        camera: joints that carry the camera.
        precision: 1 / s^2 of the prior of K.

    Returns:
        the odds, and (L,) by how many nats the motion speaks for each lag.
    """
    after, moments = joined(before, motion), max(seconds / CORRELATION, 1.0)
    per_moment = moments / max(motion.frames, 1.0)
    every = np.sort(np.concatenate([own, camera]))
    gain, missed = np.empty_like(state.log_odds), np.empty(state.log_odds.shape, dtype=bool)
    again = _again(state, motion)
    for lag in range(len(gain)):
        driven = explained(before, after, lag, every, precision)
        by_camera = explained(before, after, lag, camera, precision)
        missed[lag] = _foretold(driven, per_moment) & (motion.energy < driven.foretold / 4)
        gain[lag] = bayes_factor(motion.energy, driven, by_camera, moments, per_moment, again[lag])
    held = np.clip(gain, LEAST, MOST)
    odds = np.clip(FADING * state.log_odds + held, -CAP, CAP)
    score = np.sum(probability(odds) * np.clip(gain, 0.0, 3 * MOST), axis=1)
    return Contingency(odds, state.motions + 1, missed, motion.A), score


def bayes_factor(
    energy: Array, driven: Explained, by_camera: Explained, moments: float, per_moment: float,
    again: Array | float = 0.0,
) -> Array:  # fmt: skip
    """(N,) nats for me against not me.

    Args:
        energy: (N,) of the flow.
        driven: what all joints explain of it.
        by_camera: what those that carry the camera explain.
        moments: independent moments of the motion.
        per_moment: moments a frame.
        again: (N,) how far this is the motion before once more, which left the cell still.
    """
    rest = per_moment * np.maximum(energy - by_camera.energy, 0.0)
    unexplained = per_moment * np.maximum(energy - driven.energy, 0.0)
    still, mover = -rest / 2, _any_variance(rest, moments)
    # Of nothing, nothing is explained: one unit of noise a moment stands for what cannot be seen.
    share = (rest - unexplained) / (rest + moments)
    moved = _any_variance(unexplained, moments) - (driven.price - by_camera.price)
    moved = moved + np.log(1 + MOSTLY) + MOSTLY * np.log(np.clip(share, 1e-3, 1.0))
    expected = per_moment * (driven.foretold + driven.doubt)
    quiet = np.where(expected < FORETELLING, MOSTLY_STILL, 0.5)
    quiet = np.where(_foretold(driven, per_moment), RARELY, quiet)
    quiet = quiet + again * (MOSTLY_STILL - quiet)
    me = np.logaddexp(np.log(quiet) + still, np.log(1 - quiet) + moved)
    return np.asarray(me - np.logaddexp(np.log(0.5) + still, np.log(0.5) + mover))


def probability(log_odds: Array) -> Array:
    """That a cell is me."""
    return np.asarray(1 / (1 + np.exp(-(log_odds + np.log(PRIOR / (1 - PRIOR))))))


def called_me(P: Array, false_share: float) -> NDArray[np.bool_]:
    """The most cells of which no more than `false_share` are expected to be wrong.

    The expected share of wrong ones among the cells that are named is the mean of 1 - P over them.
    """
    order = np.argsort(-P, axis=None, kind="stable")
    ranked = P.ravel()[order]
    expected = np.cumsum(1 - ranked) / np.arange(1, len(ranked) + 1)
    named = np.zeros(len(ranked), dtype=bool)
    named[order[(expected <= false_share) & (ranked > 0.5)]] = True
    return named.reshape(P.shape)


def _foretold(driven: Explained, per_moment: float) -> Flags:
    """(N,) cells that would be seen to move, were they me."""
    least = FORETELLING * (1 + per_moment * driven.doubt)
    return np.asarray(per_moment * driven.foretold >= least)


def _again(state: Contingency, motion: MotionSums) -> Array:
    """(L, N) the cosine between the last motion and this one; 0 where that left nothing out."""
    if state.missed is None or state.turns is None:
        return np.zeros(state.log_odds.shape)
    both, last, now = (
        np.einsum("lij,lij->l", a, b)
        for a, b in (
            (state.turns, motion.A), (state.turns, state.turns), (motion.A, motion.A),
        )
    )  # fmt: skip
    cosine = both / np.sqrt(np.maximum(last * now, np.finfo(float).tiny))
    return np.asarray(cosine[:, None] * state.missed)


def _any_variance(energy: Array, moments: float) -> Array:
    """U(C)."""
    return np.asarray((moments + 1) * (np.log(moments + 1) - np.log(moments + 1 + energy / 2)))
