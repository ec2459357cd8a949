"""Weighing: one honest number, and whether to believe the answer, from all that disagrees with it.

Uncertainties, in metres at the target:

    core      what noise and too few samples leave open of the largest model, whose numbers are as
              wrong as the rows say that they are (`outlook`, `hierarchy`), times sqrt(kappa) for
              what samples have in common (`inflation`);
    possible  the same, with what else may have shaped what was seen (`explanations`);
    rivals    the error if what explains the residuals best is true (`rival`), or half the
              difference of two halves of the recording where that is no chance;
    field     what follows the posture smoothly (`discrepancy`), and what exceeds stated noise.

    total^2 = max(possible^2, core^2 + max(rival, halves)^2 + field^2 + excess^2)

Where that is much more than the core the answer is limited, and says so with the sum.
Where something happened, or was declared wrong, that makes the robot err by far more than is
stated, and nothing else explains it as well, the answer is contradicted.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.discrepancy import Discrepancy
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.prediction import length_quantile
from bodyschema.senses.sense import Sense
from bodyschema.trust.alike import outliers_alike, two_heaps
from bodyschema.trust.effects import Effects
from bodyschema.trust.families import families
from bodyschema.trust.halves import halves
from bodyschema.trust.outlook import outlook
from bodyschema.trust.reasons import WIDENED, of_rivals, of_size
from bodyschema.trust.rival import Weighed, bias, weigh
from bodyschema.trust.scores import Scores
from bodyschema.trust.target import Target, length_95, targets
from bodyschema.trust.trust import Trust
from bodyschema.trust.whiteness import whiteness

Array = NDArray[np.float64]

RIVAL = 1e-3 / 12
"""Chance of a rival's gain below which it counts: one in a thousand for about twelve families."""

LEFT = 0.05
"""The same of a larger model, above which that has taken the rival of a smaller one for its own."""

COLOURED = 0.0026
"""Chance of so alike neighbours, below which residuals are not noise: three standard errors."""

SPLIT = 0.0025
ALIKE = 1e-4

LENGTH_95 = 2.8
"""95 % of the length of a vector of three normal numbers, in standard deviations."""


@dataclass(frozen=True)
class Weighing:
    """How far an estimate may be believed at its targets."""

    trust: Trust
    total: float
    """m: 95 % of the error, all that is known to be wrong included."""
    core: float
    """m: noise and what the data left open, as the samples agree with one another."""
    stated: float
    """m: the same if they were independent, and the model right."""
    widening: float
    """Total over what the estimate's own covariance states; 1 where that leaves nothing open.
    Below 1 where its priors are wider than the robot's numbers prove to be."""
    rivals: tuple[Weighed, ...]
    """That beat chance, best first."""

    def rather_than(self, family: str) -> str:
        """The best cause in words, if it is another than this one; "" if there is none."""
        best = self.rivals[0] if self.rivals else None
        return best.says if best is not None and best.family != family else ""

    @property
    def causes(self) -> list[dict[str, Any]]:
        """Causes that would explain what is left, best first, in plain values; mm."""
        return [
            {"cause": r.family, "says": r.says, "share": r.share, "p_value": r.p_value,
             "error_mm_95": 1e3 * r.bias}
            for r in self.rivals
        ]  # fmt: skip


def weighed_up(
    fit: Estimate,
    fullest: Estimate,
    senses: Sequence[Sense],
    fields: Mapping[str, Discrepancy],
    pairs: Sequence[tuple[str, str]],
    seed: int = 0,
) -> Weighing:
    """Weigh an estimate against everything that its own samples hold against it.

    Args:
        fit: the chosen model.
        fullest: the largest model that was tried, to the same samples.
        senses: what was seen.
        fields: residual field of each sense, by its label.
        pairs: frames (seen from, seen) whose places matter.
        seed: of postures and shuffles.
    """
    wanted = targets(senses, seed, pairs)
    scores = Scores.of(fit, senses)
    larger = scores if fullest is fit else Scores.of(fullest, senses)
    seen = outlook(fit, larger, Effects.of(larger, wanted), wanted, seed)
    own, core = _stated(scores, wanted), seen.core
    rivals = _standing(scores, larger, wanted)
    by_rival = rivals[0].bias if rivals else 0.0
    split, split_words = _split(scores, wanted)
    # What a larger model explains is in the core.
    field, excess = _field(fullest, senses, fields), _excess(fullest)
    total = float(np.sqrt(core**2 + max(by_rival, split) ** 2 + field**2 + excess**2))
    total = max(total, seen.total)
    trust = Trust()
    if rivals:
        trust = trust.also(of_rivals(rivals, core))
    if total > WIDENED * core:
        trust = trust.also(of_size(core, total, split_words, field, excess, seen))
    trust = trust.also(_of_colour(scores, larger, seed))
    trust = trust.also(_of_heaps(fit, senses))
    widening = total / own if own > 0 else 1.0
    return Weighing(trust, total, core, min(own, core), widening, tuple(rivals))


def _standing(scores: Scores, larger: Scores, wanted: Sequence[Target]) -> list[Weighed]:
    """Causes that beat chance, best first; of a smaller model those that a larger one leaves."""
    of_larger = {w.family: w for w in best_of_families(larger, wanted)}
    found = {name: w for name, w in of_larger.items() if w.p_value < RIVAL}
    if larger is not scores:
        left = {name for name, w in of_larger.items() if w.p_value < LEFT}
        mine = best_of_families(scores, wanted)
        found |= {w.family: w for w in mine if w.p_value < RIVAL and w.family in left}
    return sorted(found.values(), key=lambda w: -w.criterion)


def best_of_families(scores: Scores, wanted: Sequence[Target]) -> list[Weighed]:
    """The best rival of each family, with its bias."""
    effects = Effects.of(scores, wanted)
    B = scores.A @ scores.root
    found = []
    for family in families(effects):
        pairs = [(weigh(rival, len(family), scores, B), rival) for rival in family]
        kept = [(w, rival) for w, rival in pairs if w is not None]
        if kept:
            best, rival = max(kept, key=lambda pair: pair[0].criterion)
            found.append(replace(best, bias=bias(best, rival, scores.estimate, tuple(wanted))))
    return found


def _stated(scores: Scores, wanted: Sequence[Target]) -> float:
    """95 % of the worst target as the estimate has it, m."""
    fit, found = scores.estimate, []
    for target in wanted:
        J = target.slopes(fit).by_parameter[:, :3] * fit.variables.scale
        rows = J @ scores.root
        found.append(length_quantile(list(rows @ np.swapaxes(rows, 1, 2)), scores.freedom, 0.95))
    return max(found, default=0.0)


def _split(scores: Scores, wanted: Sequence[Target]) -> tuple[float, str]:
    """Half the difference of halves that is no chance, m at the targets, and of which halves."""
    found = (0.0, "")
    for half in halves(scores):
        if half.p_value < SPLIT:
            for target in wanted:
                slopes = target.slopes(scores.estimate).by_parameter[:, :3]
                moved = slopes @ (half.difference * scores.estimate.variables.scale)
                found = max(found, (length_95(moved) / 2, half.words))
    return found


def _field(fit: Estimate, senses: Sequence[Sense], fields: Mapping[str, Discrepancy]) -> float:
    """95 % of the field's length, m, where positions were seen; never more than residuals have."""
    found = 0.0
    for i, sense in enumerate(senses):
        field, good = fields.get(sense.label), ~fit.outliers[i] if fit.outliers else slice(None)
        if field is None:
            continue
        r = sense.residual(fit.body)[good]
        for (_, unit, part), size, noise in zip(
            sense.components, field.amplitude, field.noise, strict=True
        ):
            if unit == "m" and part.stop - part.start == 3 and size > 0 and len(r):
                left = float(np.mean(r[:, part] ** 2)) - noise**2
                found = max(found, LENGTH_95 * min(size, np.sqrt(max(left, 0.0))))
    return found


def _excess(fit: Estimate) -> float:
    """95 % of what exceeds the noise that was stated of positions, m."""
    sizes = [e for name, e in (fit.model_error or {}).items() if name.endswith("(m)")]
    return LENGTH_95 * max(sizes, default=0.0)


def _of_colour(scores: Scores, larger: Scores, seed: int) -> Trust:
    in_time = whiteness(scores, seed)[0]
    time, posture = whiteness(larger, seed)
    found = []
    if min(in_time, time) < COLOURED:
        found.append(f"neighbours in time err alike (p = {min(in_time, time):.1g})")
    if posture < COLOURED:
        found.append(f"neighbouring postures err alike (p = {posture:.1g})")
    if not found:
        return Trust()
    said = f"What the fit leaves over is no noise: {' and '.join(found)}."
    return Trust("limited", (said,))


def _of_heaps(fit: Estimate, senses: Sequence[Sense]) -> Trust:
    trust = Trust()
    for i, sense in enumerate(senses):
        out = fit.outliers[i] if fit.outliers else np.zeros(len(sense), dtype=bool)
        if outliers_alike(fit, sense, out) < ALIKE:
            said = (
                f"{int(out.sum())} of {len(sense)} samples of {sense.label} were held off, and all "
                "err the same way: one cause, which may be the truth. Look at them."
            )
            trust = trust.also(Trust("limited", (said,)))
        if two_heaps(sense.residual(fit.body)[~out]):
            said = f"What was seen of {sense.label} lies in two heaps: two robots in one recording."
            trust = trust.also(Trust("limited", (said,)))
    return trust
