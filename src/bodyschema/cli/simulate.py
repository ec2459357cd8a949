"""`bodyschema simulate`: record a simulated robot with a known wrong body."""

from __future__ import annotations

import json
import shlex
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Literal

import tyro

from bodyschema.errors import InputError, shown


@dataclass(frozen=True)
class Simulate:
    """Record a simulated robot that is not as its model says, to try things with.

    An iCub whose right arm and eye are wrong watches its hand; or an arm with wrong joint zeros
    looks at a board with the camera on its wrist, recorded as a table, a ROS 2 bag or a LeRobot
    data set.
    """

    scene: Literal["icub", "wrist-camera"] | None = None
    """Which robot; the iCub when absent, the other where its extra `sim` is not installed."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("simulated")
    """Folder for the robot's URDF, the recording, run.toml and truth.json."""
    form: Literal["csv", "bag", "lerobot"] = "csv"
    """What the recording is written as; of the wrist camera."""
    samples: int = 60
    """Number of postures."""
    seed: int = 0
    """The same seed gives the same bytes."""
    pixel_noise: float = 0.3
    """Noise of each image coordinate, px; of the iCub."""
    outliers: float = 0.05
    """Share of wrong matches, 0 to 1; of the iCub."""
    zero_error: float = 3.0
    """Joint zeros are wrong by up to this, deg; of the wrist camera's arm."""
    overwrite: bool = False
    """Replace an older simulation in the folder."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Simulate and write; see the module's text."""
        if self.seed < 0:
            raise InputError(f"--seed is {self.seed}; give 0 or more.")
        words = self._icub() if self._chosen() == "icub" else self._wrist_camera()
        if self.json:
            print(json.dumps({"folder": str(self.out), "run": str(self.out / "run.toml")}))
        else:
            print(words)
            run = shlex.quote(str(self.out / "run.toml"))
            print(shown(f"Recorded in {self.out}. Next: bodyschema calibrate {run}"))
        return 0

    def _chosen(self) -> str:
        """The scene; what needs nothing beyond the core where the simulated iCub is not there."""
        if self.scene is not None:
            return self.scene
        if self.form == "csv" and all(find_spec(name) for name in ("mujoco", "icub_models")):
            return "icub"
        if self.form == "csv":
            print(
                "The simulated iCub is not installed (extra sim): an arm with a wrist camera.",
                file=sys.stderr,
            )
        return "wrist-camera"

    def _icub(self) -> str:
        """Record the iCub; in words what is wrong with it."""
        from bodyschema.atomic import check_new_folder
        from bodyschema.simulation.folder import is_earlier, write_simulation
        from bodyschema.simulation.world import Simulation, describe_simulation, simulate

        if self.form != "csv":
            raise InputError(
                f"the iCub is recorded as csv, not as {self.form}; add --scene wrist-camera."
            )
        check_new_folder(self.out, self.overwrite, is_earlier)
        settings = Simulation(
            n_samples=self.samples,
            seed=self.seed,
            pixel_noise=self.pixel_noise,
            outliers=self.outliers,
        )
        write_simulation(simulate(settings), self.out, self.overwrite)
        return describe_simulation(settings)

    def _wrist_camera(self) -> str:
        """Record the arm; in words what is wrong with it."""
        from bodyschema.simulation.wrist_camera import (
            WristCamera,
            describe_wrist_camera,
            simulate_wrist_camera,
        )
        from bodyschema.simulation.wrist_folder import write_wrist_folder

        settings = WristCamera(self.samples, self.seed, self.zero_error)
        recorded = simulate_wrist_camera(settings)
        write_wrist_folder(recorded, self.out, self.form, self.overwrite)
        return describe_wrist_camera(recorded)
