"""`bodyschema calibrate`: recording + robot -> corrected URDF, calibration.yaml, report.html."""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from itertools import count, islice
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, cast

import tyro

from bodyschema.cli.markers import marker_senses, skeleton_run
from bodyschema.cli.reading.joint_columns import JointColumns
from bodyschema.cli.reading.run_entries import FrameEntry, FreeEntry
from bodyschema.cli.reading.sense_entry import SenseEntry
from bodyschema.cli.run_file import RunFile, read_run_file
from bodyschema.documents import is_file
from bodyschema.errors import InputError, shown

if TYPE_CHECKING:
    from rich.console import Console

    from bodyschema.answers.answer import Answer
    from bodyschema.cli.loading import Loaded

Group = Literal["offsets", "gears", "axes", "links"]
LearnerName = Literal["batch", "gauss-newton", "smoother", "online-gradient", "pool"]


@dataclass(frozen=True)
class Calibrate:
    """Correct a robot's model from a recording.

    Describe the run in a TOML file (see docs/run_file), or by flags for one sense:

    bodyschema calibrate --robot arm.urdf --recording data.csv --columns x y z --hand gripper

    A camera on the wrist that sees a board on the base, poses of the board in the camera:

    bodyschema calibrate --robot arm.urdf --recording data.csv --camera tool0 --board base_link
    --layout xyz_xyzw --columns x y z qx qy qz qw

    A robot without a description is learned from which joint hangs on which:

    bodyschema calibrate --skeleton arrangement.toml --recording data.csv
    """

    run_file: Annotated[tyro.conf.Positional[Path | None], tyro.conf.arg(metavar="RUN.toml")] = None
    """The run file; without one, the flags describe the run."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("calibrated")
    """Folder for the results; must not hold anything yet."""
    free: tuple[Group, ...] | None = None
    """Joint parameters to correct; chosen by held-out error when absent."""
    joints: tuple[str, ...] | None = None
    """Joints that may be wrong; those between the frames when absent."""
    learner: LearnerName | None = None
    """"batch" takes all samples at once, the others one after the other in one pass."""
    robot: Path | None = None
    """URDF, xacro, or DH table (.toml, .json)."""
    skeleton: Path | None = None
    """Instead of a robot: an arrangement of joints and markers (.toml)."""
    recording: tuple[Path, ...] = ()
    """CSV or Parquet; several files are joined row by row."""
    columns: tuple[str, ...] = ()
    """Columns of what was seen: three for points, as many as --layout needs for poses; three for
    each marker of a skeleton, MARKER_x, MARKER_y and MARKER_z when absent."""
    layout: str = "xyz"
    """"xyz" for a point; matrix3x4, matrix4x4, xyz_xyzw, xyz_wxyz, xyz_rpy or xyz_rotvec."""
    unit: str = "m"
    """Unit of the lengths seen."""
    joint_unit: str = "rad"
    """Unit of the joint columns."""
    hand: str = ""
    """Link that carries the marker or point that was seen."""
    base: str = ""
    """Link that the tracker which gives the coordinates is fixed to; the root when absent."""
    camera: str = ""
    """Link that carries the camera which gives the coordinates, instead of --base; a wrist camera's
    is the tool."""
    board: str = ""
    """Link that the board which the camera saw is fixed to, instead of --hand; a wrist camera's is
    the base."""
    add_frames: bool = False
    """Also add the frames that were estimated to robot.urdf, each a link and a fixed joint."""
    overwrite: bool = False
    """Replace an earlier result in the folder; nothing else is ever replaced."""
    force: bool = False
    """Write the result even when it was refused, or the data contradict it."""
    all: bool = False
    """Also print errors before and after, all parameters, and what the data cannot tell."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Calibrate and write; returns 1 when refused."""
        from rich.console import Console

        from bodyschema.cli.board_overlays import with_held_off, with_overlays
        from bodyschema.cli.result import NO_PAGE, PLAIN, how_to_see_all, prepare
        from bodyschema.report.summary import as_json, finite, print_answer

        run = self.resolved()
        asked = {**asdict(run), "inputs": run.inputs, "command": self.command()}
        asked |= {"add_frames": True} if self.add_frames else {}
        prepare(self.out, self.overwrite, self.run_file, asked)
        notes = Console(stderr=True)
        loaded, answer = self._work(run, asked, notes)
        answer = with_held_off(answer, loaded.photographs)
        found, refused = as_json(answer), answer.withheld and not self.force
        if loaded.photographs and not refused:
            answer = with_overlays(answer, loaded.photographs)
        paths = [] if refused else answer.save(self.out, self.overwrite)
        reported = self.out / "report.html" in paths
        if paths and not reported:
            notes.print(NO_PAGE, **PLAIN)
        if not refused:
            found |= {"folder": str(self.out), "urdf": str(self.out / "robot.urdf")}
        if len(loaded.first_rows) > 1:
            found["first_rows"] = dict(loaded.first_rows)
        if self.json:
            print(json.dumps(finite(found)))
        else:
            console = Console()
            hint = "--all" if refused else how_to_see_all(self.out)
            print_answer(console, answer.document, self.all, hint)
            instead = _instead(answer, bool(run.skeleton)) if refused else ""
            text = self._farewell(instead, reported, bool(run.skeleton))
            console.print(shown(_rows(loaded) + text), **PLAIN)
        return 1 if refused else 0

    def _work(
        self, run: RunFile, asked: Mapping[str, Any], notes: Console
    ) -> tuple[Loaded, Answer]:
        """Load and calibrate, telling what is being done."""
        from bodyschema.cli.loading import load

        with notes.status("reading") as status:
            loaded = load(run)
            return loaded, _calibration(run, loaded, asked, status.update)

    def command(self) -> str:
        """The command line that asks for this result, wherever it goes and whatever is printed."""
        words = ["bodyschema", "calibrate"]
        for entry in fields(self):
            value = getattr(self, entry.name)
            if value == entry.default or entry.name in ("out", "overwrite", "json", "all"):
                continue
            flag = [] if entry.name == "run_file" else [f"--{entry.name.replace('_', '-')}"]
            values = value if isinstance(value, tuple) else (value,)
            words += flag if value is True else [*flag, *map(str, values)]
        return shlex.join(words)

    def resolved(self) -> RunFile:
        """The run file, with the flags laid over it."""
        run = self._described()
        if run.skeleton and not run.senses:
            from bodyschema.model.arrangement import read_arrangement

            markers = marker_senses(read_arrangement(Path(run.skeleton)), self.columns, self.unit)
            run = replace(run, senses=markers)
        groups = run.free.groups if self.free is None else self.free
        free = FreeEntry(groups, self.joints or run.free.joints)
        return replace(run, free=free, learner=self.learner or run.learner)

    def _described(self) -> RunFile:
        if self.run_file is not None:
            return read_run_file(self.run_file)
        if self.skeleton is None:
            return self._from_flags()
        unused = {"--robot": self.robot, "--hand": self.hand, "--base": self.base,
                  "--camera": self.camera, "--board": self.board}  # fmt: skip
        given = [flag for flag, value in unused.items() if value]
        if given:
            raise InputError(
                f"{' and '.join(given)} cannot go with --skeleton, whose arrangement says what "
                "carries the markers and what looks."
            )
        return skeleton_run(self.skeleton, self.recording, self.joint_unit)

    def _from_flags(self) -> RunFile:
        missing = [
            flag
            for flag, given in (
                ("--robot", self.robot),
                ("--recording", self.recording),
                ("--columns", self.columns),
                ("--hand", self.hand or self.board),
            )
            if not given
        ]
        if missing or self.robot is None:
            raise InputError(
                f"give a run file, or also {', '.join(missing)}; "
                "'bodyschema calibrate --help' explains each."
            )
        points = self.layout == "xyz"
        (looks, base), (seen, hand) = self._ends(self.robot)
        sense = SenseEntry(
            kind="points" if points else "poses",
            seen_from=looks,
            seen=seen,
            columns=self.columns,
            unit=self.unit,
            layout="matrix3x4" if points else self.layout,
        )
        return RunFile(
            robot=os.path.abspath(self.robot),
            recording=tuple(map(os.path.abspath, self.recording)),
            joints=JointColumns(unit=self.joint_unit),
            frames={looks: FrameEntry(base), seen: FrameEntry(hand)},
            senses=(sense,),
        )

    def _ends(self, robot: Path) -> tuple[tuple[str, str], tuple[str, str]]:
        """Name and link of what looks, and of what is seen: called what they are."""
        from bodyschema.cli.reading.robot import read_robot

        for one, other, flags in (
            (self.base, self.camera, "--base and --camera"),
            (self.hand, self.board, "--hand and --board"),
        ):
            if one and other:
                raise InputError(f"{flags} name the link of one and the same thing; keep one.")
        frames = read_robot(robot).frames
        looks, link = ("camera", self.camera) if self.camera else ("tracker", self.base)
        seen, hand = ("board", self.board) if self.board else ("marker", self.hand)
        names = (free_name(looks, frames), free_name(seen, frames))
        return (names[0], link or frames[0]), (names[1], hand)

    def _farewell(self, instead: str, reported: bool, learned: bool) -> str:
        if instead:
            return f"\nNothing was written. {instead}, or insist with --force."
        report = f"Report:          {self.out / 'report.html'}\n" if reported else ""
        robot = "Learned robot:  " if learned else "Corrected robot:"
        out = shlex.quote(str(self.out))
        check = f"bodyschema check {out} --recording tomorrow.csv"
        export = f"bodyschema export {out} --robot other.urdf --out corrected.urdf"
        mjcf = self.out / "robot.xml"
        return (
            f"\n{robot} {mjcf if is_file(mjcf) else self.out / 'robot.urdf'}   "
            f"all numbers: {self.out / 'calibration.yaml'}\n{report}"
            f"Next: {check if learned else export}"
        )


def free_name(name: str, taken: Sequence[str]) -> str:
    """A name for a frame, with a number if the robot has one of that name."""
    others = (f"{name}_{i}" for i in count(2))
    return next(one for one in (name, *islice(others, len(taken))) if one not in taken)


def _calibration(
    run: RunFile, loaded: Loaded, asked: Mapping[str, Any], progress: Callable[[str], None]
) -> Answer:
    """Correct the robot, or learn its skeleton."""
    from bodyschema.answers.calibrate import calibrate
    from bodyschema.answers.skeleton import learn_skeleton

    learner = cast(LearnerName, run.learner)
    if run.skeleton:
        body, senses = loaded.body, loaded.senses
        return learn_skeleton(body, senses, run.folds, run.seed, progress, learner, asked)
    return calibrate(
        loaded.body,
        loaded.senses,
        loaded.frames,
        groups=run.free.groups,
        joints=run.free.joints,
        folds=run.folds,
        seed=run.seed,
        progress=progress,
        learner=learner,
        parts=loaded.parts,
        described=loaded.nominal,
        wanted=[(one.seen_from or loaded.body.frames[0], one.seen) for one in run.wanted],
        run=asked,
    )


def _instead(answer: Answer, learned: bool) -> str:
    """What to do where nothing was written."""
    if answer.verdict == "contradicted":
        return "Mend what is said above"
    return "Record more" if learned else "Free less with --free"


def _rows(loaded: Loaded) -> str:
    """Where the rows of each of several recordings begin."""
    if len(loaded.first_rows) < 2:
        return ""
    begins = (f"those of {name} from {row}" for name, row in loaded.first_rows.items())
    return f"\nRows are numbered through all recordings: {', '.join(begins)}.\n"
