"""Section 4.4 of Nabeshima and Kuniyoshi, with numbers: where is the thing in the hand touched?

The paper shows one run with a wire-mesh box on a table and errors up to 0.1 m. Here a box, a rod
and a cup are touched in a MuJoCo simulation (`touch_runs`) at places that are known, with forces
from 0.5 to 5 N, within the paper's premises (`wrist_premises`) and outside them; there also hours
without any touch, and contacts that are not points.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
import tyro

from bodyschema.errors import InputError
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.simulation.contacts import Contact, Kind
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.studies.touch_picture import draw_touch
from bodyschema.studies.touch_runs import (
    PERIOD,
    READINGS,
    Wrist,
    draw_contacts,
    draw_wrist,
    learn,
    matched,
    miss,
    paper_load,
    paper_place,
)
from bodyschema.studies.touch_summary import Part, compared, refusals, span
from bodyschema.studies.touch_table import HEADERS, touch_lines, touch_notes
from bodyschema.studies.wrist_premises import Premises, WristPremises

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SURFACES = ("box", "rod", "mesh")
FORCES = (0.5, 1.0, 2.0, 5.0)
CONDITIONS = ("identified", "known", "gain")
OTHERS: tuple[Kind, ...] = ("soft", "moving")

BLOCK = 20
"""Touches of one sensor and one identification."""

PIECE = 0.25
"""h of free motion of one sensor and one identification."""


@dataclass(frozen=True)
class TouchStudy(WristPremises):
    """Where is the thing in the hand touched, how often falsely, and what is refused?"""

    paper: ClassVar[str] = "nabeshima"
    figure: ClassVar[str] = "touch"

    runs: Annotated[int, tyro.conf.arg(aliases=["--seeds"])] = 200
    """Touches of each surface with each force; a quarter as many contacts of each other kind."""
    seed: int = 0
    """The same seed gives the same answer."""
    hours: float = 1.0
    """Free motion of each thing, for false touches."""

    def tasks(self) -> Sequence[Task]:
        """Blocks of touches, blocks of contacts that are no points, pieces of free motion."""
        self.check_premises()
        if not self.hours > 0:
            raise InputError(f"--hours is above 0; got {self.hours:g}.")
        found = []
        for surface in SURFACES:
            for force in FORCES:
                for kind in ("point", *OTHERS):
                    whole = self.runs if kind == "point" else max(self.runs // 4, 1)
                    for block, count in enumerate(_parts(whole, BLOCK)):
                        settings = {"surface": surface, "force": force, "kind": kind}
                        name = f"{surface} {force:g} N {kind} {block}"
                        found.append(Task(name, settings | {"block": block, "count": count}))
            pieces = _parts(max(round(self.hours / PIECE * 60), 1), 60)
            for block, sixtieths in enumerate(pieces):
                hours = PIECE * sixtieths / 60
                settings = {"surface": surface, "kind": "free", "hours": hours, "block": block}
                found.append(Task(f"{surface} free {block}", settings))
        return found

    def work(self, task: Task) -> Result:
        """One block or piece."""
        settings = task.settings
        place = [SURFACES.index(settings["surface"]), settings["block"]]
        if settings["kind"] == "free":
            return self._free(settings, [self.seed, 9, *place])
        kinds = ("point", *OTHERS)
        at = [kinds.index(settings["kind"]), FORCES.index(settings["force"])]
        if settings["kind"] == "point":
            return self._points(settings, [self.seed, *at, *place])
        return self._refused(settings, [self.seed, *at, *place])

    def _points(self, settings: Mapping[str, Any], seed: list[int]) -> Result:
        """The harder case with what is known of its load; both cases at all speeds."""
        answer: Result = {
            condition: self._touched(settings, condition, self.outside, self.outside.speed, seed)
            for condition in CONDITIONS
        }
        answer["compared"] = {
            ending: {
                f"{speed:g}": self._touched(settings, "identified", case, speed, seed)
                for speed in self.speeds
            }
            for ending, case in self.cases.items()
        }
        return answer

    def _touched(
        self,
        settings: Mapping[str, Any],
        condition: str,
        case: Premises,
        speed: float,
        seed: list[int],
    ) -> Result:
        rng = np.random.default_rng(seed)
        wrist = draw_wrist(settings["surface"], condition, speed, rng, case)
        search = learn(wrist, condition, rng)
        count = settings["count"]
        contacts = draw_contacts(wrist, settings["force"], "point", count, rng)
        samples = wrist.move(PERIOD * count + 1, rng, contacts)
        left = search.unexplained(samples)
        begun = time.process_time()
        found = search.finder.touches(left)
        seconds = time.process_time() - begun
        pairs = list(zip(matched(found, contacts), contacts, strict=True))
        misses = [miss(t, c) for t, c in pairs if t is not None]
        answer: Result = {
            "error": [error for error, _ in misses],
            "held": [inside for _, inside in misses],
            "point": [t.verdict == "point" for t, _ in pairs if t is not None],
            "unnoticed": sum(t is None for t, _ in pairs),
            "false": len(found) - len(misses),
            "seconds_a_sample": seconds / len(left),
        }
        if condition == "identified":
            answer["faithful"] = _published(wrist, samples, contacts, [*seed, 1])
        return answer

    def _refused(self, settings: Mapping[str, Any], seed: list[int]) -> Result:
        rng = np.random.default_rng(seed)
        wrist = draw_wrist(settings["surface"], "identified", self.outside.speed, rng, self.outside)
        search = learn(wrist, "identified", rng)
        count = settings["count"]
        contacts = draw_contacts(wrist, settings["force"], settings["kind"], count, rng)
        found = search.touches(wrist.move(PERIOD * count + 1, rng, contacts))
        verdicts = [t.verdict for t in matched(found, contacts) if t is not None]
        return {"verdicts": verdicts, "unnoticed": count - len(verdicts)}

    def _free(self, settings: Mapping[str, Any], seed: list[int]) -> Result:
        answer: Result = {"hours": settings["hours"]}
        for condition in CONDITIONS:
            rng = np.random.default_rng(seed)
            wrist = draw_wrist(
                settings["surface"], condition, self.outside.speed, rng, self.outside
            )
            search = learn(wrist, condition, rng)
            left = search.unexplained(wrist.move(3600 * settings["hours"], rng))
            begun = time.process_time()
            answer[condition] = len(search.finder.touches(left))
            answer["seconds_a_sample"] = (time.process_time() - begun) / len(left)
        return answer

    def summary(self, results: Mapping[str, Result]) -> Result:
        """By method and case, surface and force: millimetres; of ours outside rates and shares."""
        tasks = {task.key: task.settings for task in self.tasks()}
        answer: Result = self.stated_premises() | {"free_hours": {}}
        for name in ("faithful", "better"):
            answer |= {f"{name}{ending}": {s: {} for s in SURFACES} for ending in self.cases}
        for surface in SURFACES:
            mine = [
                (tasks[key], r) for key, r in results.items() if tasks[key]["surface"] == surface
            ]
            free = [result for settings, result in mine if settings["kind"] == "free"]
            hours = answer["free_hours"][surface] = sum(result["hours"] for result in free)
            false = {c: sum(result[c] for result in free) / hours for c in CONDITIONS}
            touched = [part for part in mine if part[0]["kind"] != "free"]
            for force in FORCES:
                for key, cell in self._cells(touched, force).items():
                    answer[key][surface][f"{force:g}"] = cell
                ours = answer["better_outside"][surface][f"{force:g}"]
                ours["false_per_hour"] = false["identified"]
                for condition in CONDITIONS[1:]:
                    ours[condition]["false_per_hour"] = false[condition]
        blocks = [r["identified"] for key, r in results.items() if tasks[key]["kind"] == "point"]
        free = [r for key, r in results.items() if tasks[key]["kind"] == "free"]
        for name, parts in (("touched", blocks), ("free", free)):
            seconds = np.mean([part["seconds_a_sample"] for part in parts])
            answer[f"microseconds_a_sample_{name}"] = 1e6 * float(seconds)
        return answer

    def _cells(self, touched: Sequence[Part], force: float) -> Result:
        """Of a surface and a force, by the keys of the answer."""
        here = [(settings, r) for settings, r in touched if settings["force"] == force]
        blocks = [r for settings, r in here if settings["kind"] == "point"]
        speeds = [f"{speed:g}" for speed in self.speeds]
        cells: Result = {}
        for ending, case in self.cases.items():
            both = compared(blocks, ending, f"{case.speed:g}", speeds)
            cells |= {f"{name}{ending}": cell for name, cell in both.items()}
        more = {c: span([block[c] for block in blocks]) for c in CONDITIONS[1:]}
        cells["better_outside"] |= more | {"refused": refusals(here, force, OTHERS)}
        return cells

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """Two lines for each surface and force: within the premises, and outside."""
        notes = [
            f"in: the paper's premises ({self.within.text}); out: {self.outside.text}.",
            *touch_notes(summary, SURFACES),
        ]
        return Rows(HEADERS, touch_lines(summary, SURFACES, FORCES, OTHERS), notes)

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Error against force: a panel for each surface, above within the premises, below not."""
        return draw_touch(summary, SURFACES, FORCES)


def _published(
    wrist: Wrist, samples: WristSamples, contacts: Sequence[Contact], seed: list[int]
) -> dict[str, list[float]]:
    """Errors of the published places, m, in each reading."""
    load = paper_load(wrist, np.random.default_rng(seed))
    return {
        reading: [
            float(np.linalg.norm(paper_place(wrist, load, samples, c, reading) - c.point))
            for c in contacts
        ]
        for reading in READINGS
    }


def _parts(whole: int, most: int) -> list[int]:
    """A number cut into parts of at most so many."""
    return [min(most, whole - begun) for begun in range(0, whole, most)]
