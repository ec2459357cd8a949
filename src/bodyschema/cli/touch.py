"""`bodyschema touch`: when and where something touches what the wrist holds."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import tyro

from bodyschema.errors import InputError


@dataclass(frozen=True)
class TouchVerb:
    """Find touches of what a wrist holds (see docs/touch.md).

    Exit code 1 if the quiet motion does not tell the load well enough.
    """

    run_file: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RUN.toml")]
    """The recording, which columns are what, the object's shape, and when nothing touches it."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("touched")
    """Folder for the answer and report.html; must not hold anything yet."""
    surface_mm: float = 2.0
    """One standard deviation that the surface of what is held may be off; 0 if it is exact."""
    overwrite: bool = False
    """Replace the output folder."""
    force: bool = False
    """Write the result even when the data contradict it."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Read, learn the load, search, write; returns 1 when the load is not told."""
        from bodyschema.answers.touch import find_touches
        from bodyschema.cli.reading.touch_sections import TouchEntry, solid_of
        from bodyschema.cli.reading.wrist_sections import held_tables
        from bodyschema.cli.result import finish, prepare
        from bodyschema.cli.run_file import read_run_file

        if not self.surface_mm >= 0:
            raise InputError(f"--surface-mm is {self.surface_mm:g}; give 0 or more.")
        run = read_run_file(self.run_file, "touch")
        asked = asdict(run) | {"inputs": run.inputs, "surface_mm": self.surface_mm}
        prepare(self.out, self.overwrite, self.run_file, asked)
        table, _, declared, wrist = held_tables(run)
        touch = wrist.touch or TouchEntry()
        answer = find_touches(
            table,
            declared,
            touch.quiet,
            solid_of(run, table.body),
            gains=touch.gains,
            false_per_hour=touch.false_per_hour,
            window=touch.window,
            motion=wrist.motion,
            described=table.body,
            run=asked,
            surface=self.surface_mm / 1e3,
        )
        return finish(answer, self.out, self.overwrite, self.json, force=self.force)
