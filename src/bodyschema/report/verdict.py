"""The verdict: whether to use this calibration, how well, and what must be known beforehand."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bodyschema.export.static_transforms import place_entries
from bodyschema.judging.accuracy import in_words, main_in_words
from bodyschema.report.answer_first import MOST_NAMED, angles, known, position, quaternion
from bodyschema.report.evidence import Evidence
from bodyschema.report.page import render
from bodyschema.units import listed, shown

WORDS = {
    "calibrated": "Calibrated",
    "learned": "Learned",
    "only frames": "Only frames placed",
}
SYSTEMATIC = 0.85
"""With the residual field, the held-out error falls below this share of itself: it is no noise."""
MOST_SENTENCES = 3


@dataclass(frozen=True)
class Verdict:
    """The answer in a sentence and a number."""

    evidence: Evidence
    title: str = "Verdict"

    def render(self) -> str:
        """See `Section`."""
        c = self.evidence.calibration
        tested = bool(c.held_out.errors)
        return render(
            "verdict.html",
            word=WORDS.get(c.verdict, c.verdict.capitalize()),
            tone=c.tone,
            level=c.trust.level,
            reasons=c.trust.reasons,
            explanation=c.explanation,
            places=[_place(entry) for entry in place_entries(c)],
            stated="" if c.withheld or c.stated_95 is None else shown(c.stated_95, "m", 2),
            stated_of=self._stated_of(),
            before=main_in_words(c.nominal) if tested else "",
            what_before=c.before,
            after=main_in_words(c.held_out) if tested else "",
            median=in_words(c.held_out.main[2].median, c.held_out.main[1]) if tested else "",
            worst=in_words(c.held_out.main[2].max, c.held_out.main[1]) if tested else "",
            rows=c.n_rows - len(c.outliers),
            findings=c.findings,
            trust=self._trust() if c.predicted else [],
            warnings=self._warnings(),
            openness=self._openness(),
            sentences=c.identifiability.sentences[:MOST_SENTENCES],
            more=max(len(c.identifiability.sentences) - MOST_SENTENCES, 0),
        )

    def _stated_of(self) -> str:
        """What the large number speaks of."""
        c = self.evidence.calibration
        pairs = dict.fromkeys(c.wanted or [(p.seen_from, p.seen) for p in c.predicted])
        what = " and ".join(f"'{seen}' in '{looks}'" for looks, seen in pairs)
        what = what if 1 <= len(pairs) <= MOST_NAMED else "what was seen"
        return f"{what}, over the joint ranges recorded" if c.weighing is not None else what

    def _trust(self) -> list[str]:
        """How far off the body itself still is, and whether to believe that."""
        evidence, c = self.evidence, self.evidence.calibration
        stated, weighing = c.stated_95, c.weighing
        over_all = (
            ""
            if weighing is None
            else f" Over the joint ranges that were recorded: {shown(stated, 'm', 2)}, where noise "
            f"alone would leave {shown(weighing.stated, 'm', 2)}."
        )
        worst = max(c.predicted, key=lambda p: p.position_overall)
        anywhere = max(p.position_overall for p in c.predicted_anywhere)
        lines = [
            "The held-out error holds the noise of what was seen as well. The model itself is "
            f"predicted to place '{worst.seen}' in '{worst.seen_from}' to within "
            f"{shown(worst.position_overall, 'm', 2)} (95 %) in the postures that were seen, and "
            f"to within {shown(anywhere, 'm', 2)} anywhere in joint space"
            + (", the worst of all that was seen." if len(c.predicted) > 1 else ".")
            + over_all,
        ]
        low, high = 100 * min(evidence.shares, default=1), 100 * max(evidence.shares, default=1)
        inside = f"{low:.0f} %" if high - low < 0.5 else f"{low:.0f} to {high:.0f} % (by sense)"
        if evidence.agrees:
            lines.append(
                f"The held-out errors agree with that: {inside} of them lie within their 95 % "
                "bounds, noise included."
            )
        else:
            lines.append(
                f"Do not rely on that prediction: only {inside} of the held-out errors lie within "
                "their 95 % bounds. The robot errs in a way that this model lacks; go by the "
                "held-out error."
            )
        if not c.with_field.errors:
            return lines
        (_, unit, plain), (_, _, smoothed) = c.held_out.main, c.with_field.main
        whole, rest = plain.rms, smoothed.rms
        if rest < SYSTEMATIC * whole:
            smooth = shown(math.sqrt(whole**2 - rest**2), unit, 2)
            lines.append(
                f"But {smooth} rms of the held-out error follow the posture smoothly. That is no "
                "noise, and no number in a URDF describes it: a camera's own distortion, links "
                "that bend, gears. The prediction does not contain it: count on both."
            )
        return lines

    def _warnings(self) -> list[str]:
        c = self.evidence.calibration
        lines = list(c.notes)
        if c.withheld:
            lines.append("This calibration was refused: do not put these files on a robot.")
        if not c.fit.converged:
            when = "its iterations" if c.learner == "batch" else f"the samples for {c.learner}"
            lines.append(f"The fit had not settled when {when} ran out.")
        if c.clock.faulty:
            rows = listed(c.clock.late_rows, 12) or "none singly certain"
            lines.append(
                f"{'Perhaps a clock' if c.clock.instead else 'Clock'} fault "
                f"(p = {c.clock.p_value:.2g}): the robot was seen after it had begun to move on; "
                f"rows {rows}. Compare the clocks of joints and tracker."
                + (f" Or rather, {c.clock.instead}: that explains more." if c.clock.instead else "")
            )
        if c.outliers:
            lines.append(
                f"{len(c.outliers)} of {c.n_rows} rows are outliers and do not count in the "
                f"errors: {listed(c.outliers, 16)} (rows are counted from 0)."
            )
        return lines

    def _openness(self) -> str:
        known = self.evidence.calibration.identifiability
        total = len(self.evidence.calibration.estimate.variables)
        if not known.directions:
            if not total and not self.evidence.calibration.corrects:
                return ""
            return f"The data determine all {total} parameters." if total else "Nothing was free."
        n, inherent = len(known.directions), sum(d.inherent for d in known.directions)
        them = "it" if n == 1 else "them"
        if inherent == n:
            remedy = f"no motion can determine {them}"
        elif inherent:
            remedy = f"other postures would determine {n - inherent}, no motion the others"
        else:
            remedy = f"other postures would determine {them}"
        return (
            f"{n} of {total} combinations of parameters {'is' if n == 1 else 'are'} not "
            f"determined; {remedy}. The error above does not suffer: within each combination the "
            "effects cancel in everything that was seen. Single values of the parameters named, "
            "however, mean little."
        )


def _place(entry: Mapping[str, Any]) -> dict[str, Any]:
    """One frame that was asked for, as the page shows it."""
    return {
        "name": entry["name"],
        "position": position(entry),
        "angles": angles(entry),
        "quaternion": quaternion(entry),
        "known": known(entry),
        "origin": entry.get("origin", ""),
        "command": entry.get("command", ""),
    }
