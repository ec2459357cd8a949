"""`bodyschema calibrate`: recording + robot -> corrected URDF and calibration.yaml."""

from __future__ import annotations

import json
import math
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, Literal

import tyro

from bodyschema.cli.run_file import (
    FrameEntry,
    FreeEntry,
    JointColumns,
    RunFile,
    SenseEntry,
    read_run_file,
)
from bodyschema.errors import InputError

Group = Literal["offsets", "gears", "axes", "links"]


@dataclass(frozen=True)
class Calibrate:
    """Correct a robot's model from a recording.

    Describe the run in a TOML file (see docs/run_file), or by flags for one sense:

    bodyschema calibrate --robot arm.urdf --recording data.csv --columns x y z --hand gripper
    """

    run_file: Annotated[tyro.conf.Positional[Path | None], tyro.conf.arg(metavar="RUN.toml")] = None
    """The run file; without one, the flags describe the run."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("calibrated")
    """Folder for the results; must not hold anything yet."""
    free: tuple[Group, ...] | None = None
    """Joint parameters to correct; chosen by held-out error when absent."""
    joints: tuple[str, ...] | None = None
    """Joints that may be wrong; those between the frames when absent."""
    robot: Path | None = None
    """URDF, xacro, or DH table (.toml, .json)."""
    recording: tuple[Path, ...] = ()
    """CSV or Parquet; several files are joined row by row."""
    columns: tuple[str, ...] = ()
    """Columns of what was seen: three for points, as many as --layout needs for poses."""
    layout: str = "xyz"
    """"xyz" for a point; matrix3x4, matrix4x4, xyz_xyzw, xyz_wxyz, xyz_rpy or xyz_rotvec."""
    unit: str = "m"
    """Unit of the lengths seen."""
    joint_unit: str = "rad"
    """Unit of the joint columns."""
    hand: str = ""
    """Link that carries the marker, point or camera."""
    base: str = ""
    """Link that the tracker, board or camera which gives the coordinates is fixed to; the root."""
    overwrite: bool = False
    """Replace the output folder."""
    force: bool = False
    """Write the result even when the held-out error got worse."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Calibrate and write; returns 1 when refused."""
        from rich.console import Console

        from bodyschema.cli.answer import as_json, print_answer
        from bodyschema.cli.loading import load
        from bodyschema.export.result_folder import check_place, write_result
        from bodyschema.learning.calibration import calibrate

        run = self.resolved()
        check_place(self.out, self.overwrite)
        notes = Console(stderr=True)
        with notes.status("reading") as status:
            loaded = load(run)
            calibration = calibrate(
                loaded.body,
                loaded.senses,
                loaded.frames,
                groups=run.free.groups,
                joints=run.free.joints,
                folds=run.folds,
                seed=run.seed,
                progress=status.update,
            )
        answer = as_json(calibration)
        refused = calibration.verdict == "refused" and not self.force
        if not refused:
            source = Path(run.robot)
            write_result(calibration, loaded.nominal, source, self.out, asdict(run), self.overwrite)
            answer["folder"] = str(self.out)
            answer["urdf"] = str(self.out / "robot.urdf")
        if self.json:
            print(json.dumps(_finite(answer)))
        else:
            console = Console()
            print_answer(console, calibration)
            console.print(self._farewell(refused), highlight=False, soft_wrap=True)
        return 1 if refused else 0

    def resolved(self) -> RunFile:
        """The run file, with the flags laid over it."""
        if self.run_file is not None:
            run = read_run_file(self.run_file)
        else:
            run = self._from_flags()
        free = FreeEntry(self.free or run.free.groups, self.joints or run.free.joints)
        return replace(run, free=free)

    def _from_flags(self) -> RunFile:
        missing = [
            flag
            for flag, given in (
                ("--robot", self.robot),
                ("--recording", self.recording),
                ("--columns", self.columns),
                ("--hand", self.hand),
            )
            if not given
        ]
        if missing or self.robot is None:
            raise InputError(
                f"give a run file, or also {', '.join(missing)}; "
                "'bodyschema calibrate --help' explains each."
            )
        from bodyschema.cli.loading import read_robot

        points = self.layout == "xyz"
        base = self.base or read_robot(self.robot).frames[0]
        sense = SenseEntry(
            kind="points" if points else "poses",
            seen_from="tracker",
            seen="marker",
            columns=self.columns,
            unit=self.unit,
            layout="matrix3x4" if points else self.layout,
        )
        return RunFile(
            robot=str(self.robot.resolve()),
            recording=tuple(str(path.resolve()) for path in self.recording),
            joints=JointColumns(unit=self.joint_unit),
            frames={"tracker": FrameEntry(base), "marker": FrameEntry(self.hand)},
            senses=(sense,),
        )

    def _farewell(self, refused: bool) -> str:
        if refused:
            return "\nNothing was written. Free less with --free, or insist with --force."
        return (
            f"\nCorrected robot: [bold]{self.out / 'robot.urdf'}[/]   "
            f"all numbers: {self.out / 'calibration.yaml'}\n"
            f"Next: bodyschema export {self.out} --robot other.urdf --out corrected.urdf"
        )


def _finite(value: object) -> object:
    """JSON has no NaN and no infinity: null says that there is no number."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
