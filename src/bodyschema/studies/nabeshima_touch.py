"""Section 4.4 of Nabeshima and Kuniyoshi, with numbers: where is the thing in the hand touched?

The paper shows one run with a wire-mesh box on a table and errors up to 0.1 m. Here a box, a rod
and a cup are touched in a MuJoCo simulation (`touch_runs`) at places that are known, with forces
from 0.5 to 5 N; beside them hours without any touch, and contacts that are not points.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
import tyro

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.simulation.contacts import Kind
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.studies.touch_runs import (
    PERIOD,
    Wrist,
    draw_contacts,
    draw_wrist,
    learn,
    matched,
    miss,
    paper_load,
    paper_place,
)
from bodyschema.studies.touch_summary import at_force, percent, span_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SURFACES = ("box", "rod", "mesh")
FORCES = (0.5, 1.0, 2.0, 5.0)
CONDITIONS = ("identified", "known", "gain")
OTHERS: tuple[Kind, ...] = ("soft", "moving")

LABELS = {
    "paper": "paper's way",
    "gain": "1 % gains",
    "identified": "load learned",
    "known": "load known",
}

BLOCK = 20
"""Touches of one sensor and one identification."""

PIECE = 0.25
"""h of free motion of one sensor and one identification."""


@dataclass(frozen=True)
class TouchStudy:
    """Where is the thing in the hand touched, how often falsely, and what is refused?"""

    paper: ClassVar[str] = "nabeshima"
    figure: ClassVar[str] = "touch"

    runs: Annotated[int, tyro.conf.arg(aliases=["--seeds"])] = 200
    """Touches of each surface with each force; a quarter as many contacts of each other kind."""
    seed: int = 0
    """The same seed gives the same answer."""
    hours: float = 1.0
    """Free motion of each thing, for false touches."""
    speed: float = 0.5
    """Peak joint speed as a share of the limits, while learning, waiting and being touched."""

    def tasks(self) -> Sequence[Task]:
        """Blocks of touches, blocks of contacts that are no points, pieces of free motion."""
        if not (self.hours > 0 and 0 < self.speed <= 2):
            raise InputError("--hours is above 0, and --speed above 0 and at most 2.")
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
            return {
                condition: self._touched(settings, condition, [self.seed, *at, *place])
                for condition in CONDITIONS
            }
        return self._refused(settings, [self.seed, *at, *place])

    def _touched(self, settings: Mapping[str, Any], condition: str, seed: list[int]) -> Result:
        rng = np.random.default_rng(seed)
        wrist = draw_wrist(settings["surface"], condition, self.speed, rng)
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
            answer["paper"] = self._paper(wrist, samples, contacts, [*seed, 1])
        return answer

    def _paper(self, wrist: Wrist, samples: Any, contacts: Any, seed: list[int]) -> list[float]:
        load = paper_load(wrist, np.random.default_rng(seed))
        places = [(paper_place(wrist, load, samples, contact), contact) for contact in contacts]
        return [float(np.linalg.norm(place - contact.point)) for place, contact in places]

    def _refused(self, settings: Mapping[str, Any], seed: list[int]) -> Result:
        rng = np.random.default_rng(seed)
        wrist = draw_wrist(settings["surface"], "identified", self.speed, rng)
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
            wrist = draw_wrist(settings["surface"], condition, self.speed, rng)
            search = learn(wrist, condition, rng)
            left = search.unexplained(wrist.move(3600 * settings["hours"], rng))
            begun = time.process_time()
            answer[condition] = len(search.finder.touches(left))
            answer["seconds_a_sample"] = (time.process_time() - begun) / len(left)
        return answer

    def summary(self, results: Mapping[str, Result]) -> Result:
        """By surface and force: millimetres, rates and shares."""
        tasks = {task.key: task.settings for task in self.tasks()}
        answer: Result = {}
        for surface in SURFACES:
            mine = [(tasks[key], result) for key, result in results.items()
                    if tasks[key]["surface"] == surface]  # fmt: skip
            free = [result for settings, result in mine if settings["kind"] == "free"]
            hours = sum(result["hours"] for result in free)
            false = {c: sum(result[c] for result in free) / hours for c in CONDITIONS}
            cells = {f"{force:g}": at_force(force, mine, OTHERS, false) for force in FORCES}
            answer[surface] = cells | {"free_hours": hours}
        blocks = [r["identified"] for key, r in results.items() if tasks[key]["kind"] == "point"]
        free = [r for key, r in results.items() if tasks[key]["kind"] == "free"]
        for name, parts in (("touched", blocks), ("free", free)):
            seconds = np.mean([part["seconds_a_sample"] for part in parts])
            answer[f"microseconds_a_sample_{name}"] = 1e6 * float(seconds)
        return answer

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """A line for each surface and force."""
        headers = ("N", "paper's", "known", "learned", "gains", "held", "false", "refused")
        table = []
        for surface in SURFACES:
            for force in FORCES:
                s = summary[surface][f"{force:g}"]
                cells = [span_text(part) for part in (s["paper"], s["known"], s, s["gain"])]
                refused = "/".join(percent(s["refused"][kind]) for kind in OTHERS)
                rest = [percent(s["coverage"]), f"{s['false_per_hour']:.2f}", refused]
                table.append([f"{surface} {force:g}", *cells, *rest])
        notes = [
            "Millimetres between the place and the true one, median/95 %: by the paper's load and "
            "one reading; with load and sensor known; with both learned from 20 s of motion; the "
            "same when the gains of the six readings are off by 1 %. The paper says that errors on "
            "its table went up to 100 mm.",
            "Held: % of the true places in the stated 95 % ellipse. Refused: % of soft and of "
            "moving contacts that are not taken for a point.",
            f"False touches: {summary['box']['free_hours']:g} h of motion of each thing, load "
            "learned; the same for every force.",
            f"A sample of the finder took {summary['microseconds_a_sample_free']:.0f} "
            f"microseconds without a touch, {summary['microseconds_a_sample_touched']:.0f} when "
            "a third of the time something touched.",
        ]
        return Rows(headers, table, notes)

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Error against force, a panel for each surface."""
        try:
            from matplotlib.figure import Figure
        except ImportError:
            raise MissingExtraError("matplotlib", "report", "the picture of a study") from None
        figure = Figure(figsize=(10, 3.8), layout="constrained")
        panels = figure.subplots(1, len(SURFACES), sharey=True)
        for axes, surface in zip(panels, SURFACES, strict=True):
            cells = [summary[surface][f"{force:g}"] for force in FORCES]
            for name, label in LABELS.items():
                spans = [cell if name == "identified" else cell[name] for cell in cells]
                medians = [span["median_mm"] for span in spans]
                line = axes.loglog(FORCES, medians, "o-", ms=4, label=label)[0]
                tails = [span["p95_mm"] for span in spans]
                axes.loglog(FORCES, tails, "--", lw=0.8, color=line.get_color())
            axes.set_title(surface)
            axes.set_xlabel("force, N")
            axes.set_xticks(FORCES, [f"{force:g}" for force in FORCES])
            axes.minorticks_off()
            axes.grid(alpha=0.3)
        panels[0].set_ylabel("error of the place, mm\n(line median, dashes 95 %)")
        panels[-1].legend(fontsize=8, frameon=False)
        return figure


def _parts(whole: int, most: int) -> list[int]:
    """A number cut into parts of at most so many."""
    return [min(most, whole - begun) for begun in range(0, whole, most)]
