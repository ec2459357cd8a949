"""Weighing: one honest number, and whether to believe the answer, from all that disagrees with it.

Three uncertainties, in metres at the target:

    core      what noise and too few samples leave open: 95 % of J C J^T, times sqrt(kappa) for what
              samples have in common (`inflation`); or the difference to the largest model, or to
              where the samples would take a learner, if that is larger;
    rivals    the error if what explains the residuals best is true (`rival`), or half the
              difference of two halves of the recording where that is no chance;
    field     what follows the posture smoothly (`discrepancy`), and what exceeds stated noise.

    total^2 = core^2 + max(rival, halves)^2 + field^2 + excess^2

Where the sum is much more than its first term the answer is limited, and says so with the sum.
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
from bodyschema.trust.inflation import inflation
from bodyschema.trust.rival import Weighed, bias, weigh
from bodyschema.trust.scores import Scores
from bodyschema.trust.target import Target, length_95, targets
from bodyschema.trust.trust import Trust
from bodyschema.trust.whiteness import whiteness
from bodyschema.units import shown

Array = NDArray[np.float64]

WIDENED = 1.41
"""Total over core above which an answer is limited: as much again as was stated."""

FAR = 3.0
"""Error by a rival over core above which the answer is contradicted."""

MOST_OF_IT = 0.5
"""Share of what the fit leaves over, above which a rival is named whatever it does, and contradicts
the answer if it widens the error."""

RIVAL = 1e-3 / 12
"""Chance of a rival's gain below which it counts: one in a thousand for about twelve families."""

LEFT = 0.05
"""The same of a larger model, above which that has taken the rival of a smaller one for its own."""

COLOURED = 0.0026
"""Chance of so alike neighbours, below which residuals are not noise: three standard errors."""

SPLIT = 0.0025
ALIKE = 1e-4

LITTLE = 0.25
"""Share of what is left over, below which a cause is a perhaps."""

AS_GOOD = 10.0
"""Log likelihood by which the best cause must beat the next of another kind to be no perhaps."""

EVENTS = ("frame moved", "joint slipped", "lag", "gear", "frame misplaced", "scale")
"""Causes that can be mended, or told apart by cutting the recording: nobody should take an answer
that they contradict. With the others (a joint that gives way, a lens) a robot has to live."""

REMEDIES = {
    "frame moved": "Cut the recording there and calibrate each part alone.",
    "joint slipped": "Cut the recording there and calibrate each part alone.",
    "drift": "Fix the mounting, and record anew.",
    "warming": "Record with a warm robot.",
    "lag": "Bring both to one clock, or free the lag: a clock in [parts].",
    "gear": "Free gears too.",
    "wave": "No number in a URDF describes it.",
    "sag": "No number in a URDF describes it.",
    "hysteresis": "Approach each posture from one side, and let it settle.",
    "frame misplaced": "Say that its place is known roughly, or not at all.",
    "scale": "Measure the board or target, or free its scale.",
    "field": "Calibrate the lens or tracker by itself first.",
}
"""What to do about a cause."""

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
    """m: the same if they were independent."""
    rivals: tuple[Weighed, ...]
    """That beat chance, best first."""

    @property
    def widening(self) -> float:
        """Total over what independent samples would state; 1 where they leave nothing open."""
        return self.total / self.stated if self.stated > 0 else 1.0

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
    stated, core = _core(scores, fullest, wanted)
    rivals = _standing(scores, larger, wanted)
    by_rival = rivals[0].bias if rivals else 0.0
    split, split_words = _split(scores, wanted)
    # What a larger model explains is in the core.
    field, excess = _field(fullest, senses, fields), _excess(fullest)
    total = float(np.sqrt(core**2 + max(by_rival, split) ** 2 + field**2 + excess**2))
    trust = Trust()
    if rivals:
        trust = trust.also(_of_rivals(rivals, core))
    if total > WIDENED * core:
        trust = trust.also(_of_size(core, total, split_words, field, excess))
    trust = trust.also(_of_colour(scores, larger, seed))
    trust = trust.also(_of_heaps(fit, senses))
    return Weighing(trust, total, core, stated, tuple(rivals))


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


def _core(scores: Scores, fullest: Estimate, wanted: Sequence[Target]) -> tuple[float, float]:
    """Stated 95 % of the worst target, and with what samples share and a larger model would say."""
    fit, pairs = scores.estimate, []
    for target in wanted:
        J = target.slopes(fit).by_parameter[:, :3] * fit.variables.scale
        rows = J @ scores.root
        stated = length_quantile(list(rows @ np.swapaxes(rows, 1, 2)), scores.freedom, 0.95)
        between = 0.0 if fullest is fit else target.between(fit, fullest)
        # An online learner may not have arrived.
        ahead = length_95(J @ scores.step)
        pairs.append((stated, max(stated * np.sqrt(inflation(scores, J)), between, ahead)))
    return max((s for s, _ in pairs), default=0.0), max((float(c) for _, c in pairs), default=0.0)


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


def _of_rivals(rivals: Sequence[Weighed], core: float) -> Trust:
    """What the best rival says, beside its runner-up of another kind."""
    best = rivals[0]
    if best.bias < core and best.share < MOST_OF_IT:
        return Trust()
    others = [r for r in rivals if r.family != best.family]
    rivalled = bool(others) and others[0].criterion > best.criterion - AS_GOOD
    perhaps = rivalled or best.share < LITTLE
    beside = f"; next best, that {others[0].says}, {100 * others[0].share:.0f} %" if others else ""
    said = (
        f"{'Perhaps' if perhaps else 'What was seen says that'} {best.says}: that explains "
        f"{100 * best.share:.0f} % of what the fit leaves over{beside}. If so, the result errs by "
        f"{shown(best.bias, 'm')} where noise alone would leave {shown(core, 'm')}. "
        f"{REMEDIES[best.family]}"
    )
    far = best.bias > (WIDENED if best.share > MOST_OF_IT else FAR) * core
    against = far and not perhaps and best.family in EVENTS
    return Trust("contradicted" if against else "limited", (said,))


def _of_size(core: float, total: float, split: str, field: float, excess: float) -> Trust:
    """Why the number is wider than noise alone would make it."""
    parts = []
    if split:
        parts.append(f"{split} disagree")
    if field > core:
        parts.append(f"{shown(field, 'm')} follow the posture smoothly")
    if excess > core:
        parts.append(f"{shown(excess, 'm')} exceed the noise that was stated")
    why = f" ({'; '.join(parts)})" if parts else ""
    return Trust(
        "limited",
        (
            f"Count on {shown(total, 'm')} (95 %), not on the {shown(core, 'm')} that noise "
            f"alone would leave: the data do not agree with the model to that degree{why}.",
        ),
    )


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
