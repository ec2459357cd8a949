"""Vicente et al. 2016, Fig. 10: one movement with 200 particles and with 2000, frame by frame.

The paper's "two representative cases". The movement with 200 particles is the first of Table 1 and
is taken from there where the two share a folder; the one with 2000 sees the same images.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from bodyschema.report.figure import AFTER, BEFORE
from bodyschema.studies.hand_methods import premises
from bodyschema.studies.hand_summary import curves
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.studies.vicente2016_table1 import MODELS, Table1

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MANY = 2000
"""Particles of the second case."""
SETTLED = 20
"""Frames at the end whose median a run has settled at."""
UNITS = ("position_mm", "orientation_deg")
PAPER_SECONDS = {200: 0.8, MANY: 7.5}
"""A frame, section 5.1.2."""


@dataclass(frozen=True)
class Figure10(Table1):
    """Estimation error of one movement with --particles and with 2000, frame by frame.

    A figure of Table 1 with the same settings: its first movement, once more with 2000 particles.
    """

    figure: ClassVar[str] = "figure10"
    source: ClassVar[str] = "table1"

    def tasks(self) -> Sequence[Task]:
        """The first movement of Table 1, and the same with many."""
        first = Table1.tasks(self)[0]
        return [first, Task(f"run 0, {MANY} particles", {"run": 0, "particles": MANY})]

    def summary(self, results: Mapping[str, Result]) -> Result:
        """By the number of particles; under "mismatched" those of the wrong model."""
        found = {
            model: {
                str(m): self._settled(results[task.key][model])
                for m, task in zip(self._numbers, self.tasks(), strict=True)
            }
            for model in MODELS
        }
        return {
            "method": self.method,
            "runs": 1,
            "premises": premises(self.scene, self.edges),
            "particles": found["identical"],
            "mismatched": {"particles": found["mismatched"]},
        }

    @property
    def _numbers(self) -> tuple[int, int]:
        return self.particles, MANY

    def _settled(self, trace: Mapping[str, Any]) -> Result:
        """Errors (mm, degrees) without learning and at the end, the median of the last frames, the
        frame from which on none is twice as large; and clocks."""
        errors = np.array(trace["estimation"])[: self.frames]
        middle = np.median(errors[-SETTLED:], axis=0)
        settled = [
            int(np.max(np.flatnonzero(errors[:, i] > 2 * middle[i]), initial=-1)) + 1
            for i in range(2)
        ]
        return {
            "without_adaptation": _named(trace["without"][self.frames - 1]),
            "end": _named(errors[-1].tolist()),
            "last_frames_median": _named(middle.tolist()),
            "settled_after": _named(settled),
            "seconds_per_frame": trace["seconds"] / len(trace["sizes"]),
            "ess_last": float(np.mean(trace["sizes"][self.frames - 1])),
        }

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """One row a case."""
        rows = []
        for says, found in (
            ("within premises", summary["particles"]),
            ("outside (wrong model)", summary["mismatched"]["particles"]),
        ):
            rows += [[f"{m} particles, {says}", *_cells(case)] for m, case in found.items()]
        head = ["one movement", "mm: none", "end", "median of the last 20", "deg: none", "end",
                "median of the last 20", "s / frame"]  # fmt: skip
        return Rows(head, rows, self._notes(summary))

    def _notes(self, summary: Mapping[str, Any]) -> list[str]:
        few, many = (summary["particles"][str(m)]["seconds_per_frame"] for m in self._numbers)
        return [
            f"The first of the movements of Table 1; {summary['premises']['scene']}.",
            f"One core needs {many / few:.1f} times as long for {MANY} particles; the paper's GPU "
            f"{PAPER_SECONDS[MANY] / PAPER_SECONDS[200]:.1f} times ({PAPER_SECONDS[200]} and "
            f"{PAPER_SECONDS[MANY]} s a frame).",
            "One movement shows how the error goes, not how large it is: that is Table 2.",
        ]

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Orientation and position, as in the paper."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(10, 4), layout="constrained")
        panels = figure.subplots(1, 2)
        for m, task, colour in zip(self._numbers, self.tasks(), (BEFORE, AFTER), strict=True):
            errors = curves([results[task.key]["identical"]], "estimation")[0, : self.frames]
            for i, says in ((1, "orientation, deg"), (0, "position, mm")):
                panel = panels[1 - i]
                panel.plot(errors[:, i], color=colour, label=f"{m} particles")
                panel.set(xlabel="frame", ylabel=f"estimation error, {says}", ylim=(0, None))
        panels[0].legend(frameon=False)
        return figure


def _named(pair: Sequence[float]) -> Result:
    """Of position and orientation."""
    return dict(zip(UNITS, pair, strict=True))


def _cells(case: Mapping[str, Any]) -> list[str]:
    errors = [
        f"{case[key][unit]:.2f}"
        for unit in UNITS
        for key in ("without_adaptation", "end", "last_frames_median")
    ]
    return [*errors, f"{case['seconds_per_frame']:.3f}"]
