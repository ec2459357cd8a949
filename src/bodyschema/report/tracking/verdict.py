"""The verdict: whether the body was found, how well the hand is known, what to look at first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bodyschema.report.page import render
from bodyschema.report.tracking.evidence import TrackEvidence
from bodyschema.units import listed, shown

MOST_ROWS = 16
LARGE_BIAS = 1.0
"""pixels that a camera's outline lies off all round the body: the mask, or the mesh."""


@dataclass(frozen=True)
class TrackVerdict:
    """The answer in a sentence and a number."""

    evidence: TrackEvidence
    title: str = "Verdict"

    def render(self) -> str:
        """See `Section`."""
        evidence, fit = self.evidence, self.evidence.settled.fit
        good = ~evidence.lost
        seen = good if good.any() else ~good
        metres, turn = np.median(evidence.std[seen], axis=0)
        shift = np.median(evidence.shift[seen], axis=0)
        return render(
            "tracking/verdict.html",
            lost=fit.lost,
            word="Not found" if fit.lost else "Found",
            explanation=self._explanation(),
            std=shown(float(metres), "m", 2),
            turn=shown(float(turn), "rad", 2),
            shift=f"{shown(float(shift[0]), 'm')} and {shown(float(shift[1]), 'rad')}",
            camera=evidence.cameras[0],
            hand=evidence.hand,
            warnings=self._warnings(),
        )

    def _explanation(self) -> str:
        evidence, fit = self.evidence, self.evidence.settled.fit
        names = fit.estimate.variables.groups
        joints = names.count("offsets")
        placed = len({group for group in names if group != "offsets"})
        found = f"{joints} joint offset{'s' * (joints != 1)}"
        if placed:
            found += f" and the place of {placed} camera{'s' * (placed > 1)}"
        pictures = len(evidence.learned_from) * len(evidence.cameras)
        if fit.lost:
            return (
                f"In {pictures} pictures only {100 * fit.matched:.0f} % of the imagined contour "
                f"could be found whatever the {found} might be. Nothing was corrected."
            )
        return (
            f"{found[0].upper()}{found[1:]} from {pictures} pictures: {100 * fit.matched:.0f} % of "
            f"the imagined contour lies within 2 pixels of what was seen, half of it within "
            f"{fit.residual:.2f}."
        )

    def _warnings(self) -> list[str]:
        evidence, lines = self.evidence, []
        gone = np.flatnonzero(evidence.lost).tolist()
        if len(gone) == len(evidence.poses) and not evidence.settled.fit.lost:
            lines.append(
                f"The body was found, but what carries '{evidence.hand}' shows in no picture as it "
                "is modelled: something may be mounted on it. Name another hand, or correct its "
                "mesh; the offsets come from the other links."
            )
        elif gone:
            numbers = listed([evidence.numbers[i] for i in gone], MOST_ROWS)
            lines.append(
                f"The hand is lost in {len(gone)} of {len(evidence.poses)} moments: pictures "
                f"{numbers}. Their poses are what the encoders say, and nothing confirms them."
            )
        for camera, bias in zip(evidence.cameras, evidence.settled.fit.bias, strict=True):
            if abs(bias) > LARGE_BIAS:
                way = "outside" if bias > 0 else "inside"
                lines.append(
                    f"The outline in camera '{camera}' lies {abs(bias):.1f} pixels {way} the "
                    "imagined one all round: its masks, its focus or the meshes are off."
                )
        if evidence.settled.kept:
            lines.append(
                f"Left as modelled, because the pictures do not tell: "
                f"{listed(evidence.settled.kept, 8)}."
            )
        return lines
