"""Figure 8 of Nabeshima and Kuniyoshi: identify, observe, identify again, as a course of events.

In the paper the tip of the rod is found at 27 s and identified at 59 s; the rod is moved at 75 s,
noticed at 76 s, identified at 102 s; the head is moved at 113 s, noticed at 114 s, identified at
124 s. The same course runs in MuJoCo (`watched_arm`) for the published learner, in several
readings (`watched_readings`), and for ours. The runs are those of figure 9.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from bodyschema.errors import MissingExtraError
from bodyschema.studies.nabeshima_figure9 import Figure9, summarise
from bodyschema.studies.study import Result, Rows
from bodyschema.studies.watched_arm import HEAD, ROD, SECONDS
from bodyschema.studies.watched_readings import PRINTED

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
SHOWN = 4
"""Experiments in the picture, of each reading."""


@dataclass(frozen=True)
class Figure8(Figure9):
    """The course of events of the paper's experiment, second by second."""

    paper: ClassVar[str] = "nabeshima"
    figure: ClassVar[str] = "figure8"
    source: ClassVar[str] = "figure9"
    """Of the runs."""

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Medians over the runs, the paper's course beside."""
        readings: Result = {}
        for reading in self.readings:
            readings[reading.name] = {"premises": self.stated(reading)} | {
                name: summarise(self.of_reading(results, name, reading))
                for name in ("faithful", "better")
            }
        own, printed = (readings[reading.name] for reading in (self.readings[0], PRINTED))
        return {
            "premises": own["premises"],
            "faithful": own["faithful"],
            "faithful_outside": printed["faithful"],
            "better": own["better"],
            "readings": readings,
            "paper_events": PAPER,
        }

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """Seconds at which things happened."""
        headers = (
            "SSD, speed",
            "known",
            "rod noticed",
            "known again",
            "head noticed",
            "known again",
        )
        table = [["paper", "59", "76", "102", "114", "124"]]
        for found in summary["readings"].values():
            own = "{ssd:g}, x{speed:g}".format_map(found["premises"])
            for method, label in (("faithful", own), ("better", "  ours")):
                table.append([label, *course_of(found[method])])
        notes = [
            f"Seconds, median of {self.runs} experiments; the rod is moved at {ROD:.0f} s, the "
            f"head at {HEAD:.0f} s. Nothing is rendered or tracked: the paper spent 27 s to find "
            "the rod's tip in its images.",
            "SSD is the limit below which the published method stops identifying (0.1 is printed), "
            "speed a share of the joints' limits (none is printed).",
        ]
        return Rows(headers, table, notes)

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Bars of observing, a line each of the first experiments."""
        try:
            from matplotlib.figure import Figure
        except ImportError:
            raise MissingExtraError("matplotlib", "report", "the picture of a study") from None
        shown = list(results.values())[:SHOWN]
        lines = [("paper", PAPER)]
        for reading in self.readings:
            of = [result["faithful"][reading.name]["events"] for result in shown]
            lines += [(reading.name if i == 0 else "", events) for i, events in enumerate(of)]
        own = self.readings[0]
        ours = [result["better"][own.name]["events"] for result in shown]
        label = f"ours, speed {own.speed:g}"
        lines += [(label if i == 0 else "", events) for i, events in enumerate(ours)]
        figure = Figure(figsize=(9, 1.5 + 0.16 * len(lines)), layout="constrained")
        axes = figure.subplots()
        for row, (_, events) in enumerate(lines):
            bars = [(begin, end - begin) for begin, end in observed(events)]
            axes.broken_barh(bars, (row - 0.35, 0.7), color="tab:green")
        for moment in (ROD, HEAD):
            axes.axvline(moment, color="0.3", lw=0.8, ls=":")
        axes.set_yticks(range(len(lines)), [label for label, _ in lines])
        axes.invert_yaxis()
        axes.set_xlim(0, SECONDS)
        axes.set_xlabel("time, s (green: observing)")
        return figure


def observed(events: Sequence[Sequence[Any]]) -> list[tuple[float, float]]:
    """Stretches in which the body was taken for known."""
    found, since = [], None
    for t, kind, _ in events:
        if kind in ("identified", "dismissed") and since is None:
            since = t
        elif kind == "alarm" and since is not None:
            found.append((since, t))
            since = None
    return [*found, (since, SECONDS)] if since is not None else found


def course_of(found: Mapping[str, Any]) -> list[str]:
    """Seconds of the five events; known again counts from the alarm."""
    cells = [_at(found["first_known_s"])]
    for block, begin in (("tool", ROD), ("camera", HEAD)):
        noticed = found["delay_by_block_s"][block]
        since = begin + (noticed["median"] or 0.0)
        cells += [_at(noticed, begin), _at(found["known_again_s"][block], since)]
    return cells


def _at(found: Mapping[str, float | None], begin: float = 0.0) -> str:
    return "-" if found["median"] is None else f"{begin + found['median']:.1f}"
