"""`bodyschema plan`: the next poses that would tell most of a robot that was calibrated."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
import tyro
from numpy.typing import NDArray

from bodyschema.errors import InputError, MissingExtraError, shown

if TYPE_CHECKING:
    from bodyschema.acting.next_poses import Plan
    from bodyschema.answers.answer import Answer
    from bodyschema.cli.recall import Recalled
    from bodyschema.estimation.estimate import Estimate
    from bodyschema.model.tree import Body
    from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Group = Literal["offsets", "gears", "axes", "links"]

IN_WORDS = ("payload", "touch", "track", "find-body")
"""Verbs whose next step is no list of postures."""

MOST = 10**6
"""Of poses and candidates."""

FULL: tuple[Group, ...] = ("offsets", "axes", "links")
"""What may be wrong with the joints where a result corrected none."""


@dataclass(frozen=True)
class PlanPoses:
    """Choose the next poses: those that most reduce the tool error, or open a null direction.

    Poses are within limits, in the view of the recording, and free of self-collision as far as the
    meshes of the robot description tell. Writes a table for the robot and a picture beside it.

    bodyschema plan calibrated -n 10 --out plan.csv
    """

    result: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RESULT")]
    """Folder that a verb wrote; of those without senses only what to do next is said."""
    poses: Annotated[int, tyro.conf.arg(aliases=["-n"])] = 10
    """How many poses."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("plan.csv")
    """CSV or Parquet to write, one row a pose, one column a joint; the picture goes beside it."""
    unit: Literal["rad", "deg"] = "rad"
    """Of the angles in the file; sliding joints are in m."""
    order: Literal["travel", "telling"] = "travel"
    """Order in the file: least joint travel, or the most telling first."""
    aim: Literal["tool", "all"] = "tool"
    """The least tool error, or all parameters alike."""
    tool: str = ""
    """Frame whose error counts; what was seen when absent."""
    seen_from: str = ""
    """Frame in which it counts; what it was seen from when absent."""
    robot: Path | None = None
    """URDF with meshes, for self-collision; the one that was calibrated when absent."""
    free: tuple[Group, ...] | None = None
    """Joint parameters that may be wrong; those that were corrected when absent."""
    anywhere: bool = False
    """Also poses that the recorded view would not hold."""
    ignore_collisions: bool = False
    """Do not look for self-collision."""
    candidates: int = 4000
    """Poses to choose from."""
    seed: int = 0
    """Of the candidates."""
    overwrite: bool = False
    """Replace the file that --out names and the picture of an earlier plan beside it."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Plan and write; see the module's text."""
        from rich.console import Console

        from bodyschema.acting.candidates import find_candidates
        from bodyschema.acting.next_poses import plan_poses
        from bodyschema.answers.answer import load
        from bodyschema.cli.plan_answer import plan_json, print_plan
        from bodyschema.cli.recall import recall

        stored = load(self.result)
        if stored.verb in IN_WORDS:
            return self._say(stored)
        self._check(stored)
        recalled = recall(stored.run, stored.body, self.robot)
        estimate, notes = self._belief(stored.estimate, recalled)
        body, senses = estimate.body, recalled.senses
        pairs = self._pairs(body, senses)
        rng = np.random.default_rng(self.seed)
        free, note = self._collisions(body, recalled, rng)
        found = find_candidates(body, senses, self.candidates, rng, self.anywhere, free)
        plan = plan_poses(
            estimate, senses, self.poses,
            candidates=found, pairs=pairs, criterion=self.aim, seed=self.seed,
        )  # fmt: skip
        order = self._ordered(plan, senses)
        self._write(plan, body, order)
        picture, lack = self._draw(plan, body, senses)
        notes = [*recalled.notes, *notes, note, *lack]
        if self.json:
            answer = plan_json(plan, body, order, notes)
            print(json.dumps({**answer, "file": str(self.out), "picture": picture}))
        else:
            print_plan(Console(), plan, body, order, [*notes, _CAUTION])
            drawn = f"   picture: {picture}" if picture else ""
            print(shown(f"\nPoses: {self.out}{drawn}"))
        return 0

    def _say(self, stored: Answer) -> int:
        """What would tell more, where it is no list of postures."""
        from bodyschema.answers.next_step import next_sentences

        sentences = next_sentences(stored)
        if self.json:
            print(json.dumps({"verb": stored.verb, "sentences": list(sentences)}))
        else:
            print(shown("\n".join(sentences)))
        return 0

    def _check(self, stored: Answer) -> None:
        from bodyschema.acting.plan_picture import is_plan_picture
        from bodyschema.atomic import check_new_file
        from bodyschema.export.result_folder import inputs_of, refuse_inputs

        if self.out.suffix not in (".csv", ".parquet"):
            raise InputError(f"'{self.out}' is neither .csv nor .parquet; name such a file.")
        picture = self.out.with_suffix(".png")
        for path in (self.out, picture):
            refuse_inputs(path, [self.result, *inputs_of(self.robot, stored.run)])
            check_new_file(path, self.overwrite)
        if picture.exists() and not is_plan_picture(picture):
            raise InputError(
                f"'{picture}', where the picture of the plan would go, is not one that "
                "bodyschema drew; move it away, or name another file with --out."
            )
        for flag, value in (("--poses", self.poses), ("--candidates", self.candidates)):
            if not 1 <= value <= MOST:
                raise InputError(f"{flag} {value}: give at least 1 and at most {MOST}.")
        if self.seed < 0:
            raise InputError(f"--seed {self.seed}: give 0 or more.")

    def _belief(self, estimate: Estimate, recalled: Recalled) -> tuple[Estimate, list[str]]:
        """The belief to plan for, widened where asked or where no joint was corrected."""
        from bodyschema.acting.wider_model import widen

        joints = [g for g in estimate.variables.groups if not g.startswith("frame:")]
        if self.free is not None:
            return widen(estimate, recalled.senses, self.free), []
        if joints:
            return estimate, []
        note = "No joint was corrected; the poses are to tell joint offsets, axes and links."
        return widen(estimate, recalled.senses, FULL), [note]

    def _pairs(self, body: Body, senses: Sequence[Sense]) -> list[tuple[str, str]]:
        """The frames between which the tool error counts."""
        for frame in filter(None, (self.tool, self.seen_from)):
            body.frame_index(frame)
        ends = [pair for sense in senses for pair in sense.pairs]
        pairs = [(self.seen_from or looks, self.tool or seen) for looks, seen in ends]
        return list(dict.fromkeys(pairs))

    def _collisions(
        self, body: Body, recalled: Recalled, rng: np.random.Generator
    ) -> tuple[Callable[[Array], NDArray[np.bool_]] | None, str]:
        """The test of self-collision, and a sentence on what it covers."""
        from bodyschema.acting.self_collision import SelfCollision
        from bodyschema.estimation.problem import moved_joints

        if self.ignore_collisions:
            return None, "Self-collision was not checked, as asked."
        recorded = np.concatenate([sense.q for sense in recalled.senses])
        moved = moved_joints(body, recalled.senses)
        try:
            test = SelfCollision.of(body, recalled.visuals, moved, recorded, rng)
        except MissingExtraError as error:
            return None, f"Self-collision was not checked: {error}"
        if test is None:
            return None, (
                "Self-collision was not checked: no mesh of the robot was found; "
                "name a URDF beside its meshes with --robot."
            )
        lost = f", without {len(test.unread)} meshes that were not found" if test.unread else ""
        return test.free, (
            f"Self-collision was checked by the convex hulls of {len(test.hulls)} shapes, "
            f"{len(test.pairs)} pairs{lost}."
        )

    def _ordered(self, plan: Plan, senses: Sequence[Sense]) -> NDArray[np.int64]:
        """Rows of the plan in the order of the file."""
        from bodyschema.acting.candidates import travel_order

        if self.order == "telling":
            return np.arange(len(plan.q))
        last = [sense.q[-1] for sense in senses if len(sense)]
        return travel_order(plan.q, last[0] if last else np.zeros(plan.q.shape[1]))

    def _write(self, plan: Plan, body: Body, order: NDArray[np.int64]) -> None:
        from bodyschema.cli.plan_answer import in_unit
        from bodyschema.sources.tables import write_table

        values = in_unit(plan.q[order], body, self.unit)
        columns = {j: np.round(values[:, body.joint_index(j)], 6) for j in plan.joints}
        write_table(self.out, columns, self.overwrite)

    def _draw(
        self, plan: Plan, body: Body, senses: Sequence[Sense]
    ) -> tuple[str | None, list[str]]:
        """Path of the picture, or why there is none."""
        from bodyschema.acting.plan_picture import draw_plan
        from bodyschema.atomic import new_file

        path = self.out.with_suffix(".png")
        try:
            with new_file(path, self.overwrite) as temporary:
                draw_plan(plan, body, senses, temporary)
        except MissingExtraError as error:
            return None, [f"No picture was drawn: {error}"]
        return str(path), []


_CAUTION = (
    "Nobody described tables, cables and walls, nor the ways between the poses: let the robot's "
    "own planner drive, slowly the first time."
)
