"""Figure 10 of Nabeshima and Kuniyoshi: an arm gets to know the box in its hand, second by second.

The paper's figure shows the robot, and its text what it found: 0.594 kg and a centre of mass, after
6.6 s. Here the same box is waved in MuJoCo; the paper's relation and ours read one stream: slowly,
with the sensor's offset removed, as the paper presumes (`wrist_premises`), and outside of that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
import tyro
from numpy.typing import NDArray

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.published.linear_relation import Moments
from bodyschema.learners.published.paper_payload import (
    UNKNOWNS,
    PaperPayload,
    load_of,
    paper_rows,
)
from bodyschema.model.inertia import Inertia
from bodyschema.report.figure import AFTER, BEFORE
from bodyschema.senses.wrench_means import Averaging
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.simulation.loads import DOWN
from bodyschema.studies.payload_summary import late, seconds_text
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.studies.touch_runs import draw_wrist
from bodyschema.studies.wrist_premises import WristPremises

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

SECONDS = 20.0

STOPPED = 6.6
"""s, when the paper's robot was satisfied."""

TOLD = (2.0, 5.0, STOPPED, 10.0, 20.0)
"""s at which the table looks."""

EVERY = 20
"""Samples between two looks of the paper's relation."""

THRESHOLDS = (0.3, 1.0, 3.0)
"""Readings of the limit on lambda_4, mixed units, which the paper does not print."""

METHODS = {"faithful": "theirs", "better": "ours"}


@dataclass(frozen=True)
class Figure10(WristPremises):
    """Mass and centre of mass of the box in the hand, while it is being waved."""

    paper: ClassVar[str] = "nabeshima"
    figure: ClassVar[str] = "figure10"

    runs: Annotated[int, tyro.conf.arg(aliases=["--seeds"])] = 12
    """Experiments, each with another motion and another sensor."""
    seed: int = 0
    """The same seed gives the same answer."""

    def tasks(self) -> Sequence[Task]:
        """One experiment each."""
        self.check_premises()
        return [Task(f"run {run}", {"run": run}) for run in range(self.runs)]

    def work(self, task: Task) -> Result:
        """Errors of both methods as time goes on, in both cases."""
        answer: Result = {}
        for ending, case in self.cases.items():
            rng = np.random.default_rng([self.seed, task.settings["run"]])
            wrist = draw_wrist("box", "identified", case.speed, rng, case)
            samples = wrist.move(SECONDS, rng)
            answer[f"faithful{ending}"] = watch_paper(samples, wrist.held.load)
            answer[f"better{ending}"] = watch_ours(samples, wrist.held.load)
        return answer

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Medians at a few moments, and when each method was satisfied."""
        answer: Result = self.stated_premises()
        for key in self._keys():
            found = [result[key] for result in results.values()]
            answer[key] = {
                "satisfied_s": late([f["satisfied_s"] for f in found], 0.5),
                "at": {f"{t:g}": _looked_up([f["course"] for f in found], t) for t in TOLD},
            }
            if "stops" in found[0]:
                stops = [f["stops"] for f in found]
                answer[key]["readings"] = {at: _stopped([s[at] for s in stops]) for at in stops[0]}
        return answer

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """A line for each moment."""
        headers = [f"{METHODS[name]}, {case}" for case in ("in", "out") for name in METHODS]
        table = []
        for t in TOLD:
            cells = [summary[key]["at"][f"{t:g}"] for key in self._keys()]
            table.append([f"{t:g} s", *(_text(c["mass_pct"], c["com_mm"]) for c in cells)])
        ends = [summary[key]["satisfied_s"] for key in self._keys()]
        table.append(["satisfied", *("never" if end is None else f"{end:.1f} s" for end in ends)])
        notes = [
            f"in: the paper's premises ({self.within.text}); out: {self.outside.text}.",
            "Error of the mass, % and of its centre, mm; medians. The paper was satisfied after "
            f"{STOPPED:g} s and prints 0.594409 kg; what the box weighed is not printed.",
            "The paper's limit on lambda_4 is not printed either; satisfied is with 1. "
            f"Its readings, in: {_readings_text(summary['faithful']['readings'])}. "
            f"Out: {_readings_text(summary['faithful_outside']['readings'])}.",
            "Ours is satisfied when 99 % bounds are within 1 % and 1 mm.",
        ]
        return Rows(("", *headers), table, notes)

    def _keys(self) -> list[str]:
        return [f"{name}{ending}" for ending in self.cases for name in METHODS]

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Both errors against time, a thin line for each experiment, the median thick."""
        try:
            from matplotlib.figure import Figure
        except ImportError:
            raise MissingExtraError("matplotlib", "report", "the picture of a study") from None
        figure = Figure(figsize=(10, 7), layout="constrained")
        panels = figure.subplots(2, 2, sharex=True, sharey="col")
        for row, (ending, case) in zip(panels, self.cases.items(), strict=True):
            title = f"{'outside' if ending else 'within'}: {case.text}"
            for axes, column, unit in zip(row, (1, 2), ("mass, %", "centre, mm"), strict=True):
                for name, colour in (("faithful", BEFORE), ("better", AFTER)):
                    courses = [
                        np.array(result[f"{name}{ending}"]["course"]) for result in results.values()
                    ]
                    for course in courses:
                        axes.semilogy(course[:, 0], course[:, column], lw=0.5, alpha=0.3,
                                      color=colour)  # fmt: skip
                    time = courses[0][:, 0]
                    all_of_them = [np.interp(time, c[:, 0], c[:, column]) for c in courses]
                    axes.semilogy(time, np.median(all_of_them, axis=0), lw=2, color=colour,
                                  label=f"{METHODS[name]}, median")  # fmt: skip
                axes.axvline(STOPPED, color="0.4", lw=0.8, ls=":")
                axes.set_ylabel(f"error of the {unit}")
                axes.grid(alpha=0.3)
            row[0].set_title(title, fontsize=10)
            row[0].set_ylim(1e-3, 1e2)
            row[1].set_ylim(1e-3, 1e3)
        for axes in panels[-1]:
            axes.set_xlabel("time, s (dotted: the paper's stop)")
        panels[0, 1].legend(fontsize=9, frameon=False)
        return figure


def watch_paper(samples: WristSamples, truth: Inertia) -> Result:
    """Course of the paper's relation: time, error of mass (%) and centre (mm); and its stops."""
    learner, moments, course, y = PaperPayload(), Moments.empty(UNKNOWNS), [], samples.wrench
    stops: dict[str, list[float] | None] = {f"{limit:g}": None for limit in THRESHOLDS}
    rows = paper_rows(_known(samples.rotation), y[:, :3], y[:, 3:], DOWN)
    for t, A in zip(samples.time, rows, strict=True):
        moments = moments.add(A)
        if moments.count % EVERY:
            continue
        found = learner.solve(moments)
        course.append([float(t), *_errors(*load_of(found.x), truth)])
        for limit in THRESHOLDS:
            if stops[f"{limit:g}"] is None and replace(learner, second=limit).satisfied(found):
                stops[f"{limit:g}"] = course[-1]
    usual = stops[f"{learner.second:g}"]
    return {"course": course, "satisfied_s": usual and usual[0], "stops": stops}


def watch_ours(samples: WristSamples, truth: Inertia) -> Result:
    """Course of our learner, likewise."""
    learner = LoadLearner()
    belief, course, satisfied = learner.start(), [], None
    means = Averaging().means(samples)
    for k in range(len(means)):
        belief, _ = learner.step(belief, (means.take([k]),))
        if belief.load is None:
            continue
        t = float(means.time[k])
        course.append([t, *_errors(belief.load.mass, belief.load.com, truth)])
        if satisfied is None and learner.certificate(belief).holds:
            satisfied = t
    return {"course": course, "satisfied_s": satisfied}


def _errors(mass: float, com: Array, truth: Inertia) -> tuple[float, float]:
    off = 1e3 * float(np.linalg.norm(com - truth.com))
    return min(100 * abs(mass / truth.mass - 1), 1e6), min(off, 1e6)


def _known(rotation: Array | None) -> Array:
    if rotation is None:
        raise InputError("the paper's relation needs the sensor's orientation in the world.")
    return rotation


def _looked_up(courses: Sequence[Sequence[Sequence[float]]], t: float) -> Result:
    """Medians of the last points before a moment."""
    points = [[p for p in course if p[0] <= t][-1] for course in courses]
    _, mass, com = np.median(points, axis=0)
    return {"mass_pct": float(mass), "com_mm": float(com)}


def _stopped(stops: Sequence[Sequence[float] | None]) -> Result:
    """When a threshold ended the identification, and the errors of the answer then; medians."""
    ended = [stop for stop in stops if stop is not None]
    _, mass, com = np.median(ended, axis=0) if ended else (None, None, None)
    return {
        "satisfied_s": late([None if stop is None else stop[0] for stop in stops], 0.5),
        "mass_pct": None if mass is None else float(mass),
        "com_mm": None if com is None else float(com),
    }


def _readings_text(readings: Mapping[str, Any]) -> str:
    return "; ".join(
        f"{limit} after {seconds_text(r['satisfied_s'])} s"
        + ("" if r["mass_pct"] is None else f" with {_text(r['mass_pct'], r['com_mm'])}")
        for limit, r in readings.items()
    )


def _text(mass: float, com: float) -> str:
    return f"{mass:.2f} %  {com:.2f} mm"
