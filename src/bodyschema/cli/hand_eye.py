"""`bodyschema hand-eye`: pose lists without a robot description -> where the eye sits."""

from __future__ import annotations

import os
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, cast

import tyro

from bodyschema.errors import InputError

if TYPE_CHECKING:
    from bodyschema.cli.reading.sense_entry import SenseEntry
    from bodyschema.cli.run_file import RunFile

COUNTED = {16: "matrix4x4", 12: "matrix3x4"}
"""Layouts that a number of columns is enough to know."""


@dataclass(frozen=True)
class HandEyeVerb:
    """Find where a camera or tracker sits, from poses of the hand and of what was seen.

    Exit code 1 if the poses do not tell it, or do not belong together as declared.

    Describe the run in a TOML file (see docs/hand_eye.md), or by flags:

    bodyschema hand-eye --robot-poses hand.csv --seen-poses tag.csv --seen-layout xyz_xyzw
    """

    run_file: Annotated[tyro.conf.Positional[Path | None], tyro.conf.arg(metavar="RUN.toml")] = None
    """The run file, with [hand_eye]; without one, the flags describe the run."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("hand_eye")
    """Folder for transforms.yaml, answer.json and report.html; must not hold anything yet."""
    robot_poses: Path | None = None
    """CSV or Parquet with the hand's poses in its base."""
    seen_poses: Path | None = None
    """The target's poses in the eye, row by row; the same file when absent."""
    robot_columns: tuple[str, ...] = ()
    """Columns of the hand's poses, "T1_*" for all that begin so; all but the times when absent."""
    seen_columns: tuple[str, ...] = ()
    """Columns of what was seen; all but the times when absent."""
    robot_layout: str = ""
    """matrix3x4, matrix4x4, xyz_xyzw, xyz_wxyz, xyz_rpy or xyz_rotvec; by 12 or 16 columns."""
    seen_layout: str = ""
    """The same of what was seen."""
    robot_unit: str = "m"
    """Unit of the hand's positions."""
    seen_unit: str = "m"
    """Unit of the positions seen."""
    robot_inverse: bool = False
    """The columns hold the base seen from the hand."""
    seen_inverse: bool = False
    """The columns hold the eye seen from the target."""
    eye_on: Literal["hand", "base"] | None = None
    """What carries the eye; the hand when absent."""
    join: Literal["rows", "time"] | None = None
    """Rows are pairs, or both are streams with times of their own; rows when absent."""
    overwrite: bool = False
    """Replace the output folder."""
    force: bool = False
    """Write the result even when the data contradict it."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Read, solve, write; returns 1 when the answer is no."""
        from bodyschema.answers.hand_eye import learn_hand_eye
        from bodyschema.cli.reading.pose_lists import read_pose_lists
        from bodyschema.cli.result import finish, prepare
        from bodyschema.learners.hand_eye.full_poses import Mount

        run = self.resolved()
        asked = {**asdict(run), "inputs": run.inputs}
        prepare(self.out, self.overwrite, self.run_file, asked)
        lists, entry = read_pose_lists(run), run.hand_eye
        if entry is None:
            raise InputError("the run has no [hand_eye]; add it, with eye_on.")
        answer = learn_hand_eye(
            lists.T_base_hand,
            lists.T_eye_target,
            cast(Mount, entry.eye_on),
            lists.times,
            lists.rows,
            lists.names,
            lists.layouts,
            entry.free_scale,
            entry.accepted_mm / 1e3,
            run.seed,
            asked,
        )
        return finish(answer, self.out, self.overwrite, self.json, force=self.force)

    def resolved(self) -> RunFile:
        """The run file, with the flags laid over it."""
        from bodyschema.cli.reading.run_entries import HandEyeEntry
        from bodyschema.cli.run_file import read_run_file

        if self.run_file is None:
            run = self._from_flags()
        else:
            given = [flag for flag, value in self._lists().items() if value]
            if given:
                raise InputError(f"{', '.join(given)} cannot go with a run file, which says it.")
            run = read_run_file(self.run_file, "hand-eye")
        entry = run.hand_eye or HandEyeEntry()
        return replace(
            run,
            hand_eye=replace(
                entry, eye_on=self.eye_on or entry.eye_on, join=self.join or entry.join
            ),
        )

    def _lists(self) -> dict[str, object]:
        """Flags that describe the lists."""
        return {
            "--robot-poses": self.robot_poses,
            "--seen-poses": self.seen_poses,
            "--robot-columns": self.robot_columns,
            "--seen-columns": self.seen_columns,
            "--robot-layout": self.robot_layout,
            "--seen-layout": self.seen_layout,
            "--robot-inverse": self.robot_inverse,
            "--seen-inverse": self.seen_inverse,
        }

    def _from_flags(self) -> RunFile:
        from bodyschema.cli.reading.joint_columns import JointColumns
        from bodyschema.cli.run_file import RunFile

        if self.robot_poses is None:
            raise InputError(
                "give a run file, or --robot-poses and --seen-poses; 'bodyschema hand-eye --help' "
                "explains each."
            )
        seen = self.seen_poses or self.robot_poses
        robot = _entry(
            self.robot_poses, self.robot_columns, self.robot_layout, "--robot", ("base", "hand")
        )
        eye = _entry(seen, self.seen_columns, self.seen_layout, "--seen", ("eye", "target"))
        senses = (
            replace(robot, unit=self.robot_unit, inverse=self.robot_inverse),
            replace(eye, unit=self.seen_unit, inverse=self.seen_inverse),
        )
        if robot.recording == eye.recording:
            alone = tuple(replace(entry, recording=()) for entry in senses)
            return RunFile("", robot.recording, JointColumns(), {}, alone)
        return RunFile("", (), JointColumns(), {}, senses)


def _entry(
    path: Path, columns: tuple[str, ...], layout: str, flag: str, ends: tuple[str, str]
) -> SenseEntry:
    """The sense of one list, its columns and layout found in the file where they are not given."""
    from bodyschema.cli.reading.columns import expanded
    from bodyschema.cli.reading.sense_entry import SenseEntry
    from bodyschema.sources.recording import TIME_COLUMNS
    from bodyschema.sources.tables import open_recording

    known = tuple(open_recording(path).columns)
    named = expanded(columns, known) or tuple(c for c in known if c not in TIME_COLUMNS)
    if not layout and len(named) not in COUNTED:
        raise InputError(
            f"'{path.name}' has {len(named)} columns of poses; name their {flag}-columns and "
            f"{flag}-layout, such as xyz_xyzw."
        )
    files = (os.path.abspath(path),)
    return SenseEntry(
        "poses", *ends, columns=named, recording=files, layout=layout or COUNTED[len(named)]
    )
