"""How to apply the result: which file goes where, with the commands."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path

from bodyschema.export.result_folder import TABLES, body_to_write
from bodyschema.export.static_transforms import transforms_document
from bodyschema.export.urdf_edits import unwritable, urdf_edits
from bodyschema.report.evidence import Evidence
from bodyschema.report.page import render


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
            table=Path(source).suffix in TABLES,
            transforms=transforms_document(calibration, nominal)["transforms"],
        )
