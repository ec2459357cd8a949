"""Figure 9 of Nabeshima and Kuniyoshi: reliability while identifying, error while observing.

The paper's curves are singular values lambda_13 .. lambda_16, SSD, and the observed error beside
100 lambda_16; the rod is moved at 75 s and noticed at 76 s, the head at 113 s and noticed at 114 s.
Here the same course runs in MuJoCo (`watched_arm`); the published learner, in several readings
(`watched_readings`), and ours read the same streams, over many seeds, so that delays, blame and
false alarms become shares and rates.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
import tyro

from bodyschema.errors import MissingExtraError
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.studies.watched_arm import HEAD, ROD, Course
from bodyschema.studies.watched_readings import FRESH, PRINTED, ReadingSettings, spurious_a_run

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BLOCKS = ("tool", "camera")


@dataclass(frozen=True)
class Figure9(ReadingSettings):
    """A rod is moved, then the head: noticed when, blamed on what, known again when?"""

    paper: ClassVar[str] = "nabeshima"
    figure: ClassVar[str] = "figure9"

    runs: Annotated[int, tyro.conf.arg(aliases=["--seeds"])] = 20
    """Experiments, each with another scene and another motion."""
    seed: int = FRESH
    """The same seed gives the same answer; the default reading was chosen on seed 0."""
    rod_mm: float = 42.0
    """By how much the rod is moved."""
    head_deg: float = 5.8
    """By how much the head is turned; it also shifts, by 11.4 mm a degree."""
    ramp_s: float = 0.0
    """How long each change takes."""

    def tasks(self) -> Sequence[Task]:
        """One experiment each."""
        return [Task(f"run {run}", {"run": run}) for run in range(self.runs)]

    def work(self, task: Task) -> Result:
        """All readings on their streams, ours beside; curves of the first run only."""
        turn = float(np.radians(self.head_deg))
        course = Course(self.noise_px, 1e-3 * self.rod_mm, turn, self.ramp_s)
        return self.watch_all(task, self.seed, course, curves=task.settings["run"] == 0)

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Shares, seconds and rates; ours on top, the published method beside, all readings."""
        readings: Result = {}
        for reading in self.readings:
            readings[reading.name] = {"premises": self.stated(reading)}
            for name in ("faithful", "better"):
                scores = self.of_reading(results, name, reading)
                found = summarise(scores) | {"spurious_a_run": spurious_a_run(scores)}
                readings[reading.name][name] = found
        own, printed = (readings[reading.name] for reading in (self.readings[0], PRINTED))
        beside = {
            "premises": own["premises"],
            "faithful": own["faithful"],
            "faithful_outside": printed["faithful"],
            "readings": readings,
        }
        return dict(own["better"]) | beside

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """The paper, its method in each reading, and ours on the same stream."""
        headers = ("SSD, speed", "known", "noticed", "after", "rod again", "head again", "false",
                   "an hour")  # fmt: skip
        table = [["paper", "59", "2 of 2", "1", "26", "10", "0", "0"]]
        for found in summary["readings"].values():
            own = "{ssd:g}, x{speed:g}".format_map(found["premises"])
            for method, label in (("faithful", own), ("better", "  ours")):
                table.append([label, *_line(found[method])])
        return Rows(headers, table, self._notes(summary))

    def _notes(self, summary: Mapping[str, Any]) -> list[str]:
        return [
            f"Seconds, medians of {self.runs} experiments; false alarms in one of 130 s, and in an "
            "hour of watching. The first reading is that of the flags. SSD is the limit below "
            "which the published method stops identifying (0.1 is printed), speed a share of the "
            "joints' limits (none is printed).",
            "The arm's kinematics and the pixels come from MuJoCo; nothing is rendered, tracked or "
            "lost, so the paper's seconds hold more than these.",
            f"Ours blames the right part in {_share(summary['blamed_right'])}; what it calls known "
            "is 0.2 degrees, 5 mm, 2 mm at 99 %. The published method names no part.",
        ]

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """The paper's four curves, and ours below."""
        try:
            from matplotlib.figure import Figure
        except ImportError:
            raise MissingExtraError("matplotlib", "report", "the picture of a study") from None
        first = results[self.tasks()[0].key]
        own = self.readings[0].name
        figure = Figure(figsize=(9, 9), layout="constrained")
        panels = figure.subplots(5, 1, sharex=True)
        _draw_faithful(panels[:3], first["faithful"][own]["curves"])
        _draw_better(panels[3:], first["better"][own]["curves"])
        for axes in panels:
            for moment in (ROD, HEAD):
                axes.axvline(moment, color="0.5", lw=0.8, ls=":")
        panels[0].set_title(
            f"published method, {own}; rod moved at {ROD:.0f} s, head at {HEAD:.0f} s"
        )
        panels[-1].set_xlabel("time, s")
        return figure


def summarise(scores: Sequence[Result]) -> Result:
    """Shares, quantiles and rates over runs."""
    changes = [score[block] | {"truth": block} for score in scores for block in BLOCKS]
    noticed = [change for change in changes if change["delay"] is not None]
    hours = sum(score["hours"] for score in scores)
    alarms = sum(score["false_alarms"] for score in scores)
    named = [change for change in noticed if change["blamed"] is not None]
    return {
        "detected": len(noticed) / len(changes),
        "delay_s": quantiles([change["delay"] for change in noticed]),
        "blamed_right": (
            float(np.mean([change["blamed"] == change["truth"] for change in named]))
            if named
            else None
        ),
        "first_blamed_right": (
            float(np.mean([change["first_blamed"] == change["truth"] for change in named]))
            if named
            else None
        ),
        "false_alarms_per_hour": alarms / hours if hours else 0.0,
        "false_alarms": alarms,
        "hours_watched": hours,
        "delay_by_block_s": {
            block: quantiles([c["delay"] for c in noticed if c["truth"] == block])
            for block in BLOCKS
        },
        "known_again_s": {
            block: quantiles([c["known_again"] for c in noticed if c["truth"] == block])
            for block in BLOCKS
        },
        "first_known_s": quantiles([score["first_identified"] for score in scores]),
    }


def quantiles(values: Sequence[float | None]) -> dict[str, float | None]:
    """Median and 90 % of what is not None."""
    known = [value for value in values if value is not None]
    if not known:
        return {"median": None, "p90": None}
    return {"median": float(np.median(known)), "p90": float(np.quantile(known, 0.9))}


def _line(found: Mapping[str, Any]) -> list[str]:
    """Cells of one method in one reading."""
    known = found["known_again_s"]
    return [
        _middle(found["first_known_s"]), f"{found['detected']:.0%}", _middle(found["delay_s"]),
        _middle(known["tool"]), _middle(known["camera"]), f"{found['spurious_a_run']:.2f}",
        f"{found['false_alarms_per_hour']:.1f}",
    ]  # fmt: skip


def _middle(found: Mapping[str, float | None]) -> str:
    return "-" if found["median"] is None else f"{found['median']:.1f}"


def _share(value: float | None) -> str:
    return "-" if value is None else f"{value:.0%}"


def _draw_faithful(panels: Sequence[Axes], curves: Sequence[Result]) -> None:
    time = [point["time"] for point in curves]
    for i in range(4):
        squares = [point["squares"][i] if point["squares"] else np.nan for point in curves]
        panels[0].semilogy(time, squares, lw=1, label=f"$\\lambda_{{{16 - i}}}$")
    panels[0].legend(loc="center", bbox_to_anchor=(0.4, 0.85), ncols=4, fontsize=7, frameon=False)
    panels[0].set_ylabel("published:\nsingular values, m²")
    for key, axes, label in (("closeness", panels[1], "SSD"), ("error", panels[2], "error, m²")):
        values = [np.nan if point[key] is None else point[key] for point in curves]
        axes.plot(time, values, lw=1, color="tab:red" if key == "error" else "tab:blue")
        axes.set_ylabel(f"published:\n{label}")
    limit = [np.nan if point["limit"] is None else point["limit"] for point in curves]
    panels[2].plot(time, limit, lw=1, color="tab:blue")
    panels[2].set_yscale("log")


def _draw_better(panels: Sequence[Axes], curves: Sequence[Result]) -> None:
    time = [point["time"] for point in curves]
    for part, factor, unit in (("rotation", 180 / np.pi, "deg"), ("camera", 1e3, "mm"),
                               ("tip", 1e3, "mm")):  # fmt: skip
        values = [factor * point["bounds"].get(part, np.nan) for point in curves]
        panels[0].semilogy(time, values, lw=1, label=f"{part}, {unit}")
    panels[0].legend(loc="upper right", ncols=3, fontsize=7, frameon=False)
    panels[0].set_ylabel("ours:\n99 % bounds")
    panels[1].plot(time, [point["sum"] for point in curves], lw=1)
    panels[1].set_ylabel("ours:\nevidence of change")
