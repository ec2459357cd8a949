"""Figure 11 of Nabeshima and Kuniyoshi: reliability while identifying, then touches of a table.

(A) shows the eigenvalues lambda_2 .. lambda_5 of Eq. 37 while the box is waved. The print says that
identification ended as lambda_4 reached a threshold: lambda_5 has to become small and lambda_4 to
become LARGE, for one direction alone to be left; no number is given. (B) shows where the robot
believed to touch a table: the points should lie on a plane and were up to 0.1 m off. Here the box
is pressed on a table in MuJoCo, with one of its corners; the published way (mass and centre by
Eq. 37, the line of action of each reading) and ours read the same stream. Touching begins by itself
as soon as a method is sure of the load (`sure_load`); within the paper's premises, and outside.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
import tyro

from bodyschema.errors import MissingExtraError
from bodyschema.report.figure import AFTER, BEFORE
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.simulation.contacts import pushes
from bodyschema.simulation.loads import RATE
from bodyschema.simulation.wrist_sensor import WristSensor, record
from bodyschema.studies.payload_summary import late, seconds_text
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.studies.sure_load import MEASURED, published_load, sure_load
from bodyschema.studies.table_touches import TABLE, Presses, draw_presses
from bodyschema.studies.touch_runs import Wrist, draw_wrist, matched, paper_place
from bodyschema.studies.wrist_premises import Premises, WristPremises

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WAVED = 20.0
"""s in which a method has to become sure of the load."""

SHOWN = 10.0
"""s that (A) shows."""

METHODS = {"faithful": "theirs", "better": "ours"}


@dataclass(frozen=True)
class Figure11(WristPremises):
    """Eigenvalues while identifying, and places of touches on a table once the load is certain."""

    paper: ClassVar[str] = "nabeshima"
    figure: ClassVar[str] = "figure11"

    runs: Annotated[int, tyro.conf.arg(aliases=["--seeds"])] = 6
    """Experiments, each with another sensor and other touches."""
    seed: int = 0
    """The same seed gives the same answer."""
    touches: int = 12
    """Touches in an experiment."""
    force: float = 2.0
    """N"""

    def tasks(self) -> Sequence[Task]:
        """One experiment each."""
        self.check_premises()
        return [Task(f"run {run}", {"run": run}) for run in range(self.runs)]

    def work(self, task: Task) -> Result:
        """Wave until sure, then press; within the premises, and outside."""
        answer: Result = {}
        for ending, case in self.cases.items():
            rng = np.random.default_rng([self.seed, task.settings["run"]])
            answer[ending or "_within"] = self._pressed(case, rng)
        return answer

    def _pressed(self, case: Premises, rng: np.random.Generator) -> Result:
        wrist = draw_wrist("box", "identified", case.speed, rng, case)
        waved = wrist.move(WAVED, rng)
        theirs, ours = published_load(waved), sure_load(waved, wrist)
        presses = draw_presses(wrist.held.solid, self.touches, self.force, rng)
        samples = _press(wrist, presses, rng)
        found = matched(ours.search.touches(samples), presses.contacts)
        answer: Result = {
            "eigenvalues": [look for look in theirs.course if look[0] <= SHOWN],
            "begins_s": {"faithful": theirs.satisfied, "better": ours.certified},
            "true": [],
            **{name: [] for name in METHODS},
        }
        load = (theirs.mass, theirs.com)
        for contact, touch, T in zip(presses.contacts, found, presses.T_world_mount, strict=True):
            places = {
                "true": contact.point,
                "faithful": paper_place(wrist, load, samples, contact),
                "better": None if touch is None else touch.point,
            }
            for name, place in places.items():
                answer[name].append(
                    None if place is None else (T[:3, :3] @ place + T[:3, 3]).tolist()
                )
        return answer

    def summary(self, results: Mapping[str, Result]) -> Result:
        """When touching began, how far from the table, and from the true place."""
        answer: Result = self.stated_premises()
        for ending in self.cases:
            found = [result[ending or "_within"] for result in results.values()]
            for name in METHODS:
                answer[f"{name}{ending}"] = _summed([f | {"place": f[name]} for f in found]) | {
                    "begins_s": late([f["begins_s"][name] for f in found], 0.5)
                }
        return answer

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """Both distances, in both cases."""
        keys = [f"{name}{ending}" for ending in self.cases for name in METHODS]
        every = [summary[key] for key in keys]
        table = [
            ["touching begins, s", "6.6", *(seconds_text(s["begins_s"]) for s in every)],
            ["off the table, mm", "up to 100", *(_text(s["off_table_mm"]) for s in every)],
            ["off the true place, mm", "-", *(_text(s["error_mm"]) for s in every)],
            ["touches noticed", "-", *(f"{s['noticed']:.0%}" for s in every)],
        ]
        notes = [
            f"in: the paper's premises ({self.within.text}); out: {self.outside.text}.",
            f"Median / 95 % / largest of {self.runs} experiments of {self.touches} touches with "
            f"{self.force:g} N. The box is a rigid one; that of the paper was of wire mesh, which "
            "gave way.",
            "Touching begins by itself, when a method is sure of the load: theirs when lambda_5 is "
            "below 0.5 and lambda_4 above 1 (not printed), ours by its certificate and after "
            f"{MEASURED:g} s at the earliest; never: after {WAVED:g} s all the same.",
            "The published way is told when a touch is on; ours has to notice it.",
        ]
        heads = [f"{METHODS[name]}, {case}" for case in ("in", "out") for name in METHODS]
        return Rows(("", "paper", *heads), table, notes)

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """(A) and (b) of the paper's figure."""
        try:
            from matplotlib.figure import Figure
        except ImportError:
            raise MissingExtraError("matplotlib", "report", "the picture of a study") from None
        figure = Figure(figsize=(11, 4.2), layout="constrained")
        panels = figure.subplots(1, 3)
        found = [result["_within"] for result in results.values()]
        _draw_eigenvalues(panels[0], found[0])
        for axes, (ending, case) in zip(panels[1:], self.cases.items(), strict=True):
            for name, colour in (("faithful", BEFORE), ("better", AFTER)):
                runs = [result[ending or "_within"] for result in results.values()]
                places = [p for run in runs for p in run[name] if p is not None]
                y, z = np.reshape(places, (-1, 3))[:, 1:].T
                axes.plot(1e3 * y, 1e3 * z, "o", ms=3, color=colour, label=METHODS[name])
            axes.axhline(1e3 * TABLE, color="0.3", lw=1, label="the table")
            axes.set_title(f"{'outside' if ending else 'within'}:\n{case.text}", fontsize=9)
            axes.set_xlabel("y, mm")
            axes.set_ylabel("z, mm")
        panels[1].sharey(panels[2])
        panels[2].legend(fontsize=8, frameon=False)
        return figure


def _summed(runs: Sequence[Result]) -> Result:
    """Distances of the places of one method from the table and from the true ones."""
    pairs = [
        (np.array(place), np.array(true))
        for run in runs
        for place, true in zip(run["place"], run["true"], strict=True)
        if place is not None
    ]
    return {
        "off_table_mm": _spread([1e3 * abs(float(place[2]) - TABLE) for place, _ in pairs]),
        "error_mm": _spread([1e3 * float(np.linalg.norm(p - true)) for p, true in pairs]),
        "noticed": len(pairs) / sum(len(run["true"]) for run in runs),
    }


def _press(wrist: Wrist, presses: Presses, rng: np.random.Generator) -> WristSamples:
    time = np.arange(round(presses.seconds * RATE)) / RATE
    push = pushes(presses.contacts, time)
    felt = WristSensor(wrist.held.load).feel(presses.path, time, push)
    return record(felt, wrist.sensor, rng, wrist.gain)


def _draw_eigenvalues(axes: Axes, run: Result) -> None:
    """(A) of one experiment, and where each method was sure."""
    points = np.array(run["eigenvalues"])
    for k in range(4):
        axes.semilogy(points[:, 0], points[:, 1 + k], lw=1, label=f"eigenvalue {k + 2}")
    for name, colour in (("faithful", BEFORE), ("better", AFTER)):
        if run["begins_s"][name] is not None:
            axes.axvline(run["begins_s"][name], color=colour, lw=1, ls=":",
                         label=f"{METHODS[name]}: sure")  # fmt: skip
    axes.set_title("within:\nwhile the box is waved", fontsize=9)
    axes.set_xlabel("time, s")
    axes.set_ylabel("eigenvalues of Eq. 37, mixed units")
    axes.legend(fontsize=8, loc="center right")


def _spread(values: Sequence[float]) -> dict[str, float | None]:
    if not values:
        return {"median": None, "p95": None, "largest": None}
    return {
        "median": float(np.median(values)),
        "p95": float(np.quantile(values, 0.95)),
        "largest": float(np.max(values)),
    }


def _text(found: Mapping[str, float | None]) -> str:
    values = [found[key] for key in ("median", "p95", "largest")]
    return " / ".join("-" if value is None else f"{value:.1f}" for value in values)
