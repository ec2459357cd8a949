"""`bodyschema simulate`: record a simulated robot with a known wrong body."""

from __future__ import annotations

import json
import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from bodyschema.errors import shown


@dataclass(frozen=True)
class Simulate:
    """Record a simulated iCub whose right arm and eye are not where its model says."""

    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("simulated")
    """Folder for robot.urdf, recording.csv, run.toml and truth.json."""
    samples: int = 60
    """Number of postures."""
    seed: int = 0
    """The same seed gives the same bytes."""
    pixel_noise: float = 0.3
    """Noise of each image coordinate, px."""
    outliers: float = 0.05
    """Share of wrong matches, 0 to 1."""
    overwrite: bool = False
    """Replace an older simulation in the folder."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Simulate and write; see the module's text."""
        from bodyschema.simulation.folder import write_simulation
        from bodyschema.simulation.world import Simulation, describe_simulation, simulate

        settings = Simulation(
            n_samples=self.samples,
            seed=self.seed,
            pixel_noise=self.pixel_noise,
            outliers=self.outliers,
        )
        folder = write_simulation(simulate(settings), self.out, self.overwrite)
        if self.json:
            print(json.dumps({"folder": str(folder), "run": str(folder / "run.toml")}))
        else:
            print(describe_simulation(settings))
            run = shlex.quote(str(folder / "run.toml"))
            print(shown(f"Recorded in {folder}. Next: bodyschema calibrate {run}"))
        return 0
