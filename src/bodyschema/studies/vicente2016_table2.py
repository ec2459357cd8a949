"""Vicente et al. 2016, Table 2 and Fig. 9: the estimation error by the number of particles.

Every number sees the same movements and the same images.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np

from bodyschema.acting.servoing import Servoing
from bodyschema.learners.published.image_likelihood import Edges
from bodyschema.report.figure import AFTER, BEFORE
from bodyschema.simulation.seeing_icub import Scene
from bodyschema.studies.hand_methods import METHODS, premises
from bodyschema.studies.hand_movements import FINALS, INITIALS
from bodyschema.studies.hand_summary import mean_and_sd
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.studies.vicente2016_table1 import MODELS
from bodyschema.studies.watched_hand import Trace, watch

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PARTICLES = (100, 200, 500, 1000, 2000)
PAPER = {100: (8.61, 8.48), 200: (5.35, 6.85), 500: (4.40, 5.73), 1000: (3.87, 4.50),
         2000: (3.09, 4.34)}  # fmt: skip
"""Table 2: mean mm and degrees over 40 movements."""
PAPER_WITHOUT = (41.29, 14.50)


@dataclass(frozen=True)
class Table2:
    """Estimation error at the end of the open loop with 100 to 2000 particles."""

    paper: ClassVar[str] = "vicente2016"
    figure: ClassVar[str] = "table2"

    method: Literal["particle-filter", "track"] = "particle-filter"
    """Who learns: the filter as published, or outlines in information form."""
    runs: int = 40
    """Movements, the same for each number of particles."""
    seed: int = 0
    """The same seed gives the same results."""
    scene: Scene = "plain"
    """Before a plain background masks are compared, before a cluttered one the images."""
    edges: Edges = "hand"
    """Of the filter before a cluttered background: those of the whole hand, or its outline."""
    frames: int = 120
    """Of the open loop."""
    closed_frames: int = 50
    """Of the closed loop, for the reaching error; the paper's Table 2 ends before it."""

    def tasks(self) -> Sequence[Task]:
        """One movement with one number; those of a movement follow each other."""
        return [
            Task(f"run {i}, {m} particles", {"run": i, "particles": m})
            for i in range(self.runs)
            for m in PARTICLES
        ]

    def work(self, task: Task) -> Result:
        """Errors at the end of one movement, with both models."""
        run, m = task.settings["run"], task.settings["particles"]
        seed = int(np.random.SeedSequence([self.seed, run, m]).generate_state(1)[0])
        return {
            model: _end(
                watch(
                    METHODS[self.method](self.edges), run % (FINALS * INITIALS), self.scene, model,
                    m, seed, self.frames, self.closed_frames, Servoing(),
                ),
                self.frames,
            )
            for model in MODELS
        }  # fmt: skip

    def summary(self, results: Mapping[str, Result]) -> Result:
        """By the number of particles; under "mismatched" those of the wrong model."""
        found = {model: {str(m): self._of(results, model, m) for m in PARTICLES}
                 for model in MODELS}  # fmt: skip
        return {
            "method": self.method,
            "runs": self.runs,
            "scene": self.scene,
            "premises": premises(self.scene, self.edges),
            "particles": found["identical"],
            "mismatched": {"particles": found["mismatched"]},
        }

    def _of(self, results: Mapping[str, Result], model: str, m: int) -> Result:
        ends = [results[f"run {i}, {m} particles"][model] for i in range(self.runs)]
        return {
            "estimation": mean_and_sd([end["estimation"] for end in ends]),
            "reaching": mean_and_sd([end["reaching"] for end in ends]),
            "without_adaptation": mean_and_sd([end["without"] for end in ends]),
            "frames_per_second": sum(end["frames"] for end in ends)
            / sum(end["seconds"] for end in ends),
            "ess_last": float(np.mean([end["ess_last"] for end in ends])),
        }

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """One row a number of particles."""
        ours, wrong = summary["particles"], summary["mismatched"]["particles"]
        rows = [
            self._row(
                "no adaptation", PAPER_WITHOUT, ours["200"], wrong["200"], "without_adaptation"
            )
        ]
        rows += [
            self._row(str(m), PAPER[m], ours[str(m)], wrong[str(m)], "estimation")
            for m in PARTICLES
        ]
        head = ["particles", "mm: paper", "same model", "wrong model", "deg: paper", "same model",
                "wrong model", "ESS / M", "frames / s"]  # fmt: skip
        notes = [
            f"{self.runs} movements (paper: 40); {summary['premises']['scene']}; means, as in the "
            "paper; standard deviations are in the picture and in the JSON.",
            *(f"{summary['premises'][model].capitalize()}." for model in MODELS),
            *self._closed(ours),
            "Frames per second of one core's time; the paper's GPU made 1.25 with 200 particles "
            "and 0.13 with 2000.",
        ]
        if self.method == "particle-filter":
            notes.append(
                "ESS / M is of the last ten frames of the open loop. At 1 the likelihood prefers "
                "no particle: more of them help only in the first frames."
            )
        return Rows(head, rows, notes)

    def _closed(self, ours: Mapping[str, Any]) -> list[str]:
        """What the closed loop reached, where there was one."""
        ends = [f"{m}: {ours[str(m)]['reaching']['position_mm']['mean']:.2f}" for m in PARTICLES]
        said = f"Reaching error after the closed loop, mean mm by particles: {', '.join(ends)}."
        return [said] if self.closed_frames else []

    def _row(
        self, name: str, paper: tuple[float, float], ours: Mapping[str, Any],
        wrong: Mapping[str, Any], key: str,
    ) -> list[str]:  # fmt: skip
        cells = [name]
        for value, part in zip(paper, ("position_mm", "orientation_deg"), strict=True):
            means = (found[key][part]["mean"] for found in (ours, wrong))
            cells += [f"{value:.2f}", *(f"{mean:.2f}" for mean in means)]
        if key != "estimation":
            return [*cells, "", ""]
        return [*cells, f"{ours['ess_last']:.3f}", f"{ours['frames_per_second']:.1f}"]

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Fig. 9."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(10, 4), layout="constrained")
        for i, (axes, name) in enumerate(
            zip(figure.subplots(1, 2), ("position_mm", "orientation_deg"), strict=True)
        ):
            ours = [summary["particles"][str(m)]["estimation"][name] for m in PARTICLES]
            mean, sd = [o["mean"] for o in ours], [o["sd"] for o in ours]
            axes.errorbar(PARTICLES, mean, sd, color=AFTER, capsize=3, marker="o", label="ours")
            paper = [PAPER[m][i] for m in PARTICLES]
            axes.plot(PARTICLES, paper, "s--", color=BEFORE, label="paper")
            axes.set(xscale="log", xlabel="particles", ylabel=name.replace("_", ", "))
            axes.set_xticks(PARTICLES, [str(m) for m in PARTICLES])
            axes.minorticks_off()
            axes.legend(frameon=False)
        return figure


@dataclass(frozen=True)
class Figure9(Table2):
    """Estimation error by the number of particles, with its spread; runs of Table 2."""

    figure: ClassVar[str] = "figure9"
    source: ClassVar[str] = "table2"


def _end(trace: Trace, open_frames: int) -> Result:
    """What is kept of one movement: the end of the open loop, and of the closed one."""
    end = open_frames - 1
    return {
        "estimation": trace.estimation[end].tolist(),
        "without": trace.without[end].tolist(),
        "reaching": trace.reaching[-1].tolist(),
        "ess_last": float(np.mean(trace.sizes[max(end - 9, 0) : end + 1])),
        "frames": len(trace.sizes),
        "seconds": trace.seconds,
    }
