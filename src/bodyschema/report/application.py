"""How to apply the result: which file goes where, with the commands."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path

from bodyschema.export.result_folder import body_to_write
from bodyschema.export.static_transforms import transforms_document
from bodyschema.export.urdf_edits import unwritable, urdf_edits
from bodyschema.judging.settled import settled
from bodyschema.model.description import is_urdf
from bodyschema.report.evidence import Evidence
from bodyschema.report.page import render
from bodyschema.units import read_as


@dataclass(frozen=True)
class Application:
    """Steps for the robot's description, its cameras and tools, and other copies of it."""

    evidence: Evidence
    title: str = "How to apply it"

    def render(self) -> str:
        """See `Section`."""
        calibration, nominal = self.evidence.calibration, self.evidence.nominal
        body = body_to_write(calibration, nominal)
        source = str(self.evidence.run.get("robot") or "")
        return render(
            "application.html",
            refused=calibration.verdict == "refused",
            notes=unwritable(nominal, body),
            edits=sorted(urdf_edits(nominal, body)),
            source=source,
            diff=shlex.join(["diff", source, "robot.urdf"]),
            table=not is_urdf(Path(source)),
            offsets=self._offsets(),
            transforms=transforms_document(calibration, nominal)["transforms"],
        )

    def _offsets(self) -> list[tuple[str, str]]:
        """Where offsets alone were corrected: for drivers that take them, in deg or mm."""
        calibration, kept = self.evidence.calibration, settled(self.evidence.calibration)
        variables = calibration.estimate.variables
        if calibration.groups != ("offsets",):
            return []
        rows = zip(
            variables.names, variables.groups, kept.x, variables.units, kept.changed, strict=True
        )
        return [
            (name, _signed(float(x), unit))
            for name, group, x, unit, changed in rows
            if group == "offsets" and changed
        ]


def _signed(value: float, unit: str) -> str:
    scale, name = read_as(unit)
    return f"{scale * value:+.3f} {name}"
