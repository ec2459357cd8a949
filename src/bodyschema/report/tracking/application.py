"""How to apply what was found, and how to undo it."""

from __future__ import annotations

import shlex
from dataclasses import dataclass

from bodyschema.export.urdf_edits import described, urdf_edits
from bodyschema.report.page import render
from bodyschema.report.tracking.evidence import TrackEvidence
from bodyschema.units import read_as


@dataclass(frozen=True)
class TrackApplication:
    """The robot's description, and the cameras."""

    evidence: TrackEvidence
    title: str = "How to apply it"

    def render(self) -> str:
        """See `Section`."""
        evidence, settled = self.evidence, self.evidence.settled
        source = str(evidence.run.get("robot") or "")
        edits = urdf_edits(evidence.nominal, described(evidence.nominal, settled.body))
        variables = settled.fit.estimate.variables
        units = dict(zip(variables.names, variables.units, strict=True))
        return render(
            "tracking/application.html",
            lost=settled.fit.lost,
            source=source,
            diff=shlex.join(["diff", source, "robot.urdf"]),
            edits=len(edits),
            offsets=[
                (name, _signed(value, units[name])) for name, value in settled.corrections.items()
            ],
            transforms=settled.transforms,
        )


def _signed(value: float, unit: str) -> str:
    """An offset in deg or mm."""
    scale, name = read_as(unit)
    return f"{scale * value:+.3f} {name}"
