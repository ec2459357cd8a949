"""The offsets with their errors, what the pictures do not tell, and which posture would."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bodyschema.acting.telling_posture import TellingPosture
from bodyschema.model.kernels import REVOLUTE
from bodyschema.report.page import render
from bodyschema.report.parameters import parameter_html
from bodyschema.report.tracking.evidence import TrackEvidence
from bodyschema.units import read_as, significant

MOST_GAINS = 3
GAIN = 0.9
"""Share of its standard deviation below which a parameter is named as gaining."""


@dataclass(frozen=True)
class Offsets:
    """The table of what was wanted."""

    evidence: TrackEvidence
    title: str = "Corrections"

    def render(self) -> str:
        """See `Section`."""
        fit = self.evidence.settled.fit
        held = "offsets stay as modelled in the files, but for those that go together with a camera"
        return parameter_html(fit.estimate, fit.identifiability, held)


@dataclass(frozen=True)
class NotTold:
    """Open directions, and the next posture."""

    evidence: TrackEvidence
    title: str = "What is not determined"

    def render(self) -> str:
        """See `Section`."""
        known, telling = self.evidence.settled.fit.identifiability, self.evidence.telling
        return render(
            "tracking/not_told.html",
            directions=known.directions,
            kept=self.evidence.settled.kept,
            posture=[] if telling is None else self._posture(telling),
            gains=[] if telling is None else self._gains(telling),
        )

    def _posture(self, telling: TellingPosture) -> list[tuple[str, str]]:
        """Joints that would move, and their readings."""
        body, q = self.evidence.body, self.evidence.q
        listed = []
        for j in np.flatnonzero(telling.q != q[0]):
            turns = bool(np.any(body.kind[body.driver == j] == REVOLUTE))
            scale, unit = read_as("rad" if turns else "m")
            listed.append((body.joints[j], f"{scale * telling.q[j]:.0f} {unit}"))
        return listed

    def _gains(self, telling: TellingPosture) -> list[str]:
        """The parameters that would gain most."""
        variables = self.evidence.settled.fit.estimate.variables
        share = telling.then / telling.std
        lines = []
        for i in np.argsort(share)[:MOST_GAINS]:
            scale, unit = read_as(variables.units[i])
            now, then = (significant(scale * float(s[i]), 2) for s in (telling.std, telling.then))
            if share[i] < GAIN:
                lines.append(f"{variables.names[i]} from ± {now} to ± {then} {unit}")
        return lines
