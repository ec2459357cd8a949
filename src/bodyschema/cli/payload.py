"""`bodyschema payload`: wrist force/torque + motion -> what hangs on the wrist, with error bars."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated

import tyro


@dataclass(frozen=True)
class PayloadVerb:
    """Find mass, centre of mass and inertia of what a wrist carries (see docs/payload.md).

    Exit code 1 if the motion does not tell the mass or the centre of mass.
    """

    run_file: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RUN.toml")]
    """The recording, and which columns are what."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("payload")
    """Folder for payload.yaml, report.html and the URDF; must not hold anything yet."""
    calibration: Path | None = None
    """A result of `calibrate` that the payload is entered into; a copy is written."""
    overwrite: bool = False
    """Replace the output folder."""
    force: bool = False
    """Write the result even when the data contradict it."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Read, fit, write; returns 1 when mass or centre of mass is not told."""
        from bodyschema.answers.answer import load
        from bodyschema.answers.payload import learn_payload
        from bodyschema.cli.reading.wrist_sections import held_tables
        from bodyschema.cli.result import finish, prepare
        from bodyschema.cli.run_file import read_run_file
        from bodyschema.export.payload import entered

        run = read_run_file(self.run_file, "payload")
        asked = asdict(run) | {"inputs": run.inputs}
        prepare(self.out, self.overwrite, self.run_file, asked)
        table, empty, declared, wrist = held_tables(run)
        answer = learn_payload(
            table, declared, wrist.motion, wrist.segments, empty, table.body, asked
        )
        if self.calibration is not None:
            text = entered(load(self.calibration), answer.details)
            answer = replace(answer, files={"calibration.yaml": text.encode()})
        return finish(answer, self.out, self.overwrite, self.json, force=self.force)
