"""The verdict: whether to use this calibration, how well, and what must be known beforehand."""

from __future__ import annotations

from dataclasses import dataclass

from bodyschema.report.evidence import Evidence
from bodyschema.report.page import render
from bodyschema.report.units import listed, shown

WORDS = {"calibrated": "Calibrated", "only frames": "Only frames placed", "refused": "Refused"}
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
        return render(
            "verdict.html",
            word=WORDS[c.verdict],
            kind=c.verdict.replace(" ", "-"),
            explanation=c.explanation,
            before=shown(c.nominal.position.rms, "m"),
            after=shown(c.held_out.position.rms, "m"),
            median=shown(c.held_out.position.median, "m"),
            worst=shown(c.held_out.position.max, "m"),
            rows=c.n_rows - len(c.outliers),
            trust=self._trust(),
            warnings=self._warnings(),
            openness=self._openness(),
            sentences=c.identifiability.sentences[:MOST_SENTENCES],
            more=max(len(c.identifiability.sentences) - MOST_SENTENCES, 0),
        )

    def _trust(self) -> list[str]:
        """How far off the body itself still is, and whether to believe that."""
        evidence, c = self.evidence, self.evidence.calibration
        worst = max(evidence.predictions, key=lambda p: p.position_overall)
        bound = shown(worst.position_overall, "m", 2)
        shares = [100 * share for shares in evidence.within for share in shares.values()]
        low, high = min(shares), max(shares)
        inside = f"{low:.0f} %" if high - low < 0.5 else f"{low:.0f} to {high:.0f} %"
        lines = [
            "The number above holds the noise of what was seen as well. The model itself is "
            f"predicted to place {worst.seen} in {worst.seen_from} to within {bound} (95 %)"
            + (", the worst of all that was seen." if len(evidence.senses) > 1 else "."),
        ]
        if evidence.agrees:
            lines.append(
                f"The held-out errors agree with the prediction: {inside} of them lie within "
                "their 95 % bounds, noise included."
            )
        else:
            lines.append(
                f"Do not rely on that prediction: only {inside} of the held-out errors lie within "
                "their 95 % bounds. The robot errs in a way that this model lacks; go by the "
                "held-out error."
            )
        share = c.with_field.position.rms / max(c.held_out.position.rms, 1e-12)
        if share < SYSTEMATIC:
            lines.append(
                f"{100 * (1 - share):.0f} % of the held-out error follows the posture smoothly. "
                "That part is no noise, and no number in a URDF describes it: a camera's own "
                "distortion, links that bend, gears. The prediction does not contain it."
            )
        return lines

    def _warnings(self) -> list[str]:
        c, lines = self.evidence.calibration, []
        if c.verdict == "refused":
            lines.append("This calibration was refused: do not put these files on a robot.")
        if not c.fit.converged:
            lines.append("The fit had not settled when its iterations ran out.")
        if c.clock.faulty:
            rows = listed(c.clock.late_rows, 12) or "none singly certain"
            lines.append(
                f"Clock fault (p = {c.clock.p_value:.2g}): the robot was seen after it had begun to "
                f"move on; rows {rows}. Compare the clocks of joints and tracker."
            )
        if c.outliers:
            lines.append(
                f"{len(c.outliers)} of {c.n_rows} rows are outliers and do not count in the errors: "
                f"{listed(c.outliers, 16)} (rows are counted from 0)."
            )
        return lines

    def _openness(self) -> str:
        known = self.evidence.calibration.identifiability
        total = len(self.evidence.calibration.estimate.parameters)
        if not known.directions:
            return f"The data determine all {total} parameters." if total else "Nothing was free."
        n, inherent = len(known.directions), sum(d.inherent for d in known.directions)
        which = "no motion can" if inherent == n else "other postures would" if not inherent else ""
        which = which or f"other postures would determine {n - inherent} of these, none the others"
        tail = f"{which} determine {'it' if n == 1 else 'them'}" if inherent in (0, n) else which
        return (
            f"{n} of {total} combinations of parameters {'is' if n == 1 else 'are'} not determined; "
            f"{tail}. The error above does not suffer: within each combination the effects cancel "
            "in everything that was seen. The single values, however, mean little."
        )
