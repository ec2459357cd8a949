"""Figure 8 of Nabeshima and Kuniyoshi: identify, observe, identify again, as a course of events.

In the paper the tip of the rod is found at 27 s and identified at 59 s; the rod is moved at 75 s,
noticed at 76 s, identified at 102 s; the head is moved at 113 s, noticed at 114 s, identified at
124 s. The same course runs in MuJoCo (`watched_arm`) for the published learner and for ours.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
import tyro

from bodyschema.errors import MissingExtraError
from bodyschema.studies.nabeshima_figure9 import METHODS, summarise
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.studies.watched_arm import HEAD, ROD, SECONDS, Course, score

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAPER = [
    [59.0, "identified", ""],
    [76.0, "alarm", ""],
    [102.0, "identified", ""],
    [114.0, "alarm", ""],
    [124.0, "identified", ""],
]
"""s: the printed course."""


@dataclass(frozen=True)
class Figure8:
    """The course of events of the paper's experiment, second by second."""

    paper: ClassVar[str] = "nabeshima"
    figure: ClassVar[str] = "figure8"

    runs: Annotated[int, tyro.conf.arg(aliases=["--seeds"])] = 6
    """Experiments; the picture has one line for each."""
    seed: int = 0
    """The same seed gives the same answer."""
    noise_px: float = 0.5
    """pixels"""

    def tasks(self) -> Sequence[Task]:
        """One experiment each."""
        return [Task(f"run {run}", {"run": run}) for run in range(self.runs)]

    def work(self, task: Task) -> Result:
        """The events of both methods on one stream."""
        rng = np.random.default_rng([self.seed, task.settings["run"]])
        seen = Course(self.noise_px).stream(rng)
        return {
            name: {"events": watch(seen, self.noise_px)["events"]}
            for name, watch in METHODS.items()
        }

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Medians over the runs, the paper's course beside."""
        answer = {
            name: summarise([score(result[name]["events"]) for result in results.values()])
            for name in METHODS
        }
        return answer | {"paper_events": PAPER}

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """Seconds at which things happened."""
        table = [["identified", "59", *(_at(summary[name]["first_known_s"]) for name in METHODS)]]
        for block, begin, noticed, again in (("tool", ROD, 76, 102), ("camera", HEAD, 114, 124)):
            cells = [summary[name]["delay_by_block_s"][block] for name in METHODS]
            table.append([f"{block} noticed", str(noticed), *(_at(c, begin) for c in cells)])
            # Known again counts from the alarm.
            known = [
                _at(summary[name]["known_again_s"][block], begin + (cell["median"] or 0.0))
                for name, cell in zip(METHODS, cells, strict=True)
            ]
            table.append([f"{block} known again", str(again), *known])
        notes = [
            f"Seconds, median of {self.runs} experiments; the rod is moved at {ROD:.0f} s, the "
            f"head at {HEAD:.0f} s. Nothing is rendered or tracked: the paper spent 27 s to find "
            "the rod's tip in its images.",
        ]
        return Rows(("", "paper", "its method here", "ours"), table, notes)

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Bars of observing, one line an experiment."""
        try:
            from matplotlib.figure import Figure
        except ImportError:
            raise MissingExtraError("matplotlib", "report", "the picture of a study") from None
        figure = Figure(figsize=(9, 1.5 + 0.3 * 2 * self.runs), layout="constrained")
        axes = figure.subplots()
        lines = [("paper", PAPER)]
        for name, label in (("faithful", "its method"), ("better", "ours")):
            lines += [(label, result[name]["events"]) for result in results.values()]
        for row, (_, events) in enumerate(lines):
            bars = [(begin, end - begin) for begin, end in _observed(events)]
            axes.broken_barh(bars, (row - 0.35, 0.7), color="tab:green")
        for moment in (ROD, HEAD):
            axes.axvline(moment, color="0.3", lw=0.8, ls=":")
        axes.set_yticks(range(len(lines)), [label for label, _ in lines])
        axes.invert_yaxis()
        axes.set_xlim(0, SECONDS)
        axes.set_xlabel("time, s (green: observing)")
        return figure


def _observed(events: Sequence[Sequence[Any]]) -> list[tuple[float, float]]:
    """Stretches in which the body was taken for known."""
    found, since = [], None
    for t, kind, _ in events:
        if kind in ("identified", "dismissed") and since is None:
            since = t
        elif kind == "alarm" and since is not None:
            found.append((since, t))
            since = None
    return [*found, (since, SECONDS)] if since is not None else found


def _at(found: Mapping[str, float | None], begin: float = 0.0) -> str:
    return "-" if found["median"] is None else f"{begin + found['median']:.1f}"
