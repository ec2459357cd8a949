"""How far an answer of hand and eye may be believed, and the error of the eye's place with it.

    total^2 = core^2 + max(rival, halves)^2

core is the 95 % error of `HandEye`, widened already by what hangs together; a rival is what
explains the residuals better than chance (`pose_rivals`), with the error of the eye's place if it
is true; halves are half the difference of two parts of the recording where that is no chance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.estimate import Estimate
from bodyschema.judging.pose_rivals import PairScores, families, scales
from bodyschema.learners.hand_eye.full_poses import HandEye
from bodyschema.learners.hand_eye.pair_bars import Linear
from bodyschema.senses.poses import Poses
from bodyschema.trust.alike import outliers_alike, two_heaps
from bodyschema.trust.halves import halves
from bodyschema.trust.reasons import FAR, MOST_OF_IT, WIDENED
from bodyschema.trust.rival import Weighed, weigh
from bodyschema.trust.trust import Trust
from bodyschema.trust.weighing import ALIKE, COLOURED, RIVAL, SPLIT
from bodyschema.trust.whiteness import whiteness
from bodyschema.units import shown

Array = NDArray[np.float64]

FEW = 7
"""Postures up to which, six motions, the noise is guessed from little more than itself."""

STRAY = 0.2
"""Share of the outliers that may lie on the wrong side of the row from which something moved."""

EXACT = 1e-6
"""m and rad of residuals below which there is nothing to explain: a recording that was computed."""


@dataclass(frozen=True)
class PoseWeighing:
    """What an answer's own pairs hold against it."""

    trust: Trust
    total: float
    """m: 95 % of the error of the eye's place, all that is known to be wrong included."""
    rivals: tuple[Weighed, ...]
    """That beat chance, best first."""


def weighed_pairs(
    found: HandEye, problem: Linear, estimate: Estimate, sense: Poses, streams: bool, seed: int
) -> PoseWeighing:
    """Weigh an answer against its pairs.

    Args:
        found: the answer.
        problem: the rows of its fit.
        estimate: that it is.
        sense: all pairs.
        streams: whether a lag was fitted.
        seed: of shuffles.
    """
    core, few = found.predicted_95, _of_few(found)
    if np.sqrt(np.max(np.diag(found.noise))) < EXACT:
        return PoseWeighing(few, core, ())
    scores = PairScores.beside(problem, estimate, sense)
    rivals = _significant(found, problem, scores, streams)
    by_rival = rivals[0].bias if rivals else 0.0
    split, words = _split(found, scores)
    total = float(np.hypot(core, max(by_rival, split)))
    trust = _of_rivals(rivals, core).also(few)
    if total > WIDENED * core:
        why = f": {words} disagree" if split > by_rival else ""
        trust = trust.also(Trust("limited", (
            f"Count on {shown(total, 'm')} (95 %) for the place of the eye, not on the "
            f"{shown(core, 'm')} that noise alone would leave{why}.",
        )))  # fmt: skip
    trust = trust.also(_of_colour(scores, seed)).also(_of_heaps(found, estimate, sense))
    return PoseWeighing(trust, total, tuple(rivals))


def _significant(
    found: HandEye, problem: Linear, scores: PairScores, streams: bool
) -> list[Weighed]:
    """The best of each family that beats chance, best first, with the eye's error if it is true."""
    B, best = scores.A @ scores.root, []
    for family in families(found, problem, streams):
        tested = [w for rival in family if (w := weigh(rival, len(family), scores, B)) is not None]
        if not tested:
            continue
        top = max(tested, key=lambda w: w.criterion)
        if top.p_value < RIVAL:
            best.append(replace(top, bias=_bias(found, top)))
    return sorted(best, key=lambda w: -w.criterion)


def _bias(found: HandEye, weighed: Weighed) -> float:
    """m: error of the eye's place now, if a rival is true."""
    first = 0 if found.eye_on == "hand" else 6
    moved = weighed.moved[first : first + 3] * scales(12)[first : first + 3]
    before = float(np.linalg.norm(moved))
    if weighed.family == "eye moved":
        return max(before, float(np.linalg.norm(moved + weighed.gamma[:3])))
    return before


def _split(found: HandEye, scores: PairScores) -> tuple[float, str]:
    """Half the difference of halves that is no chance, m, and of which halves."""
    first, largest = 0 if found.eye_on == "hand" else 6, (0.0, "")
    for half in halves(scores):
        if half.p_value < SPLIT:
            apart = half.difference[first : first + 3] * scales(12)[first : first + 3]
            largest = max(largest, (float(np.linalg.norm(apart)) / 2, half.words))
    return largest


def _of_few(found: HandEye) -> Trust:
    if found.postures > FEW:
        return Trust()
    said = (
        f"Only {found.postures} postures of the hand, each counted once: with fewer than "
        f"{FEW} motions the noise is guessed from little more than itself; count on "
        f"{shown(found.predicted_95, 'm')} (95 %), and record 10 postures or more."
    )
    return Trust("limited", (said,))


def _of_rivals(rivals: Sequence[Weighed], core: float) -> Trust:
    """What the best rival says, beside its runner-up of another kind."""
    if not rivals or rivals[0].bias < core:
        return Trust()
    best, others = rivals[0], [r for r in rivals if r.family != rivals[0].family]
    perhaps = bool(others) and others[0].share > 0.8 * best.share
    beside = f"; next best, that {others[0].says}, {100 * others[0].share:.0f} %" if others else ""
    said = (
        f"{'Perhaps' if perhaps else 'The poses say that'} {best.says}: that explains "
        f"{100 * best.share:.0f} % of what the fit leaves over{beside}. If so, the place of the "
        f"eye errs by {shown(best.bias, 'm')} where noise alone would leave {shown(core, 'm')}."
    )
    against = best.bias > (WIDENED if best.share > MOST_OF_IT else FAR) * core
    return Trust("contradicted" if against else "limited", (said,))


def _of_colour(scores: PairScores, seed: int) -> Trust:
    time, posture = whiteness(scores, seed)
    found = []
    if time < COLOURED:
        found.append(f"neighbours in time err alike (p = {time:.1g})")
    if posture < COLOURED:
        found.append(f"neighbouring postures err alike (p = {posture:.1g})")
    if not found:
        return Trust()
    return Trust("limited", (f"What the fit leaves over is no noise: {' and '.join(found)}.",))


def _of_heaps(found: HandEye, estimate: Estimate, sense: Poses) -> Trust:
    out = found.weights < 0.5
    if outliers_alike(estimate, sense, out) < ALIKE:
        said = (
            f"{int(out.sum())} of {len(sense)} pairs were held off, and all of them err the same "
            f"way: {_since(out, sense) or 'perhaps they are the good ones, or a second target.'}"
        )
        return Trust("limited", (said,))
    r = sense.take(~out).residual(estimate.body)
    if two_heaps(r[:, :3]) or two_heaps(r[:, 3:]):
        return Trust("limited", ("What the fit leaves over lies in two heaps: something was in "
                                 "two places.",))  # fmt: skip
    return Trust()


def _since(out: NDArray[np.bool_], sense: Poses) -> str:
    """Where they part the recording in two, since which row; "" where they lie anywhere."""
    # At a cut before row k: those on the wrong side, for outliers after it and for those before.
    bad_before = np.concatenate([[0], np.cumsum(out)])
    after = bad_before + np.concatenate([np.cumsum(~out[::-1])[::-1], [0]])
    k = int(np.argmin(np.minimum(after, len(out) - after)))
    if min(after[k], len(out) - after[k]) > STRAY * out.sum() or not 0 < k < len(out):
        return ""
    return f"something moved at about row {sense.rows[k]}, perhaps the eye, perhaps the target."
