"""Figure 11 of Nabeshima and Kuniyoshi: reliability while identifying, then touches of a table.

(A) shows the eigenvalues lambda_2 .. lambda_5 of Eq. 37 while the box is waved. The print says that
identification ended as lambda_4 reached a threshold: lambda_5 has to become small and lambda_4 to
become LARGE, for one direction alone to be left; no number is given. (B) shows where the robot
believed to touch a table: the points should lie on a plane and were up to 0.1 m off. Here the box
is pressed on a table in MuJoCo, with one of its corners; the published way (mass and centre by
Eq. 37, the line of action of each reading) and ours read the same stream.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
import tyro
from numpy.typing import NDArray

from bodyschema.errors import MissingExtraError
from bodyschema.learners.published.linear_relation import Moments
from bodyschema.learners.published.paper_payload import PaperPayload, load_of, paper_rows
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.simulation.contacts import pushes
from bodyschema.simulation.loads import DOWN, RATE
from bodyschema.simulation.wrist_sensor import WristSensor, record
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.studies.table_touches import TABLE, Presses, draw_presses
from bodyschema.studies.touch_runs import Wrist, draw_wrist, learn, matched, paper_place

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

SPEED = 0.15
"""Peak joint speed as a share of the limits, while the load is learned."""

WAVED = 10.0
"""s that (A) shows."""

EVERY = 20
"""Samples between two looks at the eigenvalues."""

METHODS = {"faithful": "its way here", "better": "ours"}


@dataclass(frozen=True)
class Figure11:
    """Eigenvalues while identifying, and places of touches on a table."""

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
        return [Task(f"run {run}", {"run": run}) for run in range(self.runs)]

    def work(self, task: Task) -> Result:
        """Wave, then press."""
        rng = np.random.default_rng([self.seed, task.settings["run"]])
        wrist = draw_wrist("box", "identified", SPEED, rng)
        course, load = watch_eigenvalues(wrist, rng)
        search = learn(wrist, "identified", rng)
        presses = draw_presses(wrist.held.solid, self.touches, self.force, rng)
        samples = _press(wrist, presses, rng)
        found = matched(search.touches(samples), presses.contacts)
        answer: Result = {"eigenvalues": course, "true": [], "faithful": [], "better": []}
        for contact, touch, T in zip(presses.contacts, found, presses.T_world_mount, strict=True):
            read = paper_place(wrist, load, samples, contact)
            places = {"true": contact.point, "faithful": read}
            places["better"] = None if touch is None else touch.point
            for name, place in places.items():
                answer[name].append(
                    None if place is None else (T[:3, :3] @ place + T[:3, 3]).tolist()
                )
        return answer

    def summary(self, results: Mapping[str, Result]) -> Result:
        """How far from the table, and from the true place."""
        answer: Result = {}
        for name in METHODS:
            pairs = [
                (np.array(place), np.array(true))
                for result in results.values()
                for place, true in zip(result[name], result["true"], strict=True)
                if place is not None
            ]
            whole = sum(len(result["true"]) for result in results.values())
            off = [1e3 * abs(float(place[2]) - TABLE) for place, _ in pairs]
            error = [1e3 * float(np.linalg.norm(place - true)) for place, true in pairs]
            answer[name] = {
                "off_table_mm": _spread(off),
                "error_mm": _spread(error),
                "noticed": len(pairs) / whole,
            }
        return answer

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """Both distances."""
        both = [summary[name] for name in METHODS]
        table = [
            ["off the table, mm", "up to 100", *(_text(s["off_table_mm"]) for s in both)],
            ["off the true place, mm", "-", *(_text(s["error_mm"]) for s in both)],
            ["touches noticed", "-", *(f"{s['noticed']:.0%}" for s in both)],
        ]
        notes = [
            f"Median / 95 % / largest of {self.runs} experiments of {self.touches} touches with "
            f"{self.force:g} N. The box is a rigid one; that of the paper was of wire mesh, which "
            "gave way.",
            "The published way is told when a touch is on; ours has to notice it.",
        ]
        return Rows(("", "paper", *METHODS.values()), table, notes)

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """(A) and (b) of the paper's figure."""
        try:
            from matplotlib.figure import Figure
        except ImportError:
            raise MissingExtraError("matplotlib", "report", "the picture of a study") from None
        figure = Figure(figsize=(10, 4.2), layout="constrained")
        panels = figure.subplots(1, 2)
        _draw_eigenvalues(panels[0], next(iter(results.values()))["eigenvalues"])
        for name, colour in (("faithful", "tab:red"), ("better", "tab:blue")):
            places = [p for result in results.values() for p in result[name] if p is not None]
            y, z = np.array(places)[:, 1:].T
            panels[1].plot(1e3 * y, 1e3 * z, "o", ms=3, color=colour, label=METHODS[name])
        panels[1].axhline(1e3 * TABLE, color="0.3", lw=1, label="the table")
        panels[1].set_xlabel("y, mm")
        panels[1].set_ylabel("z, mm")
        panels[1].legend(fontsize=8, frameon=False)
        return figure


def watch_eigenvalues(wrist: Wrist, rng: np.random.Generator) -> tuple[Any, tuple[float, Array]]:
    """Time and lambda_2 .. lambda_5 as the box is waved, and the load in the end."""
    samples = wrist.move(WAVED, rng)
    learner, moments, course = PaperPayload(), Moments.empty(5), []
    for t, A in zip(samples.time, _rows(samples), strict=True):
        moments = moments.add(A)
        if moments.count % EVERY == 0:
            squares = learner.solve(moments).squares
            course.append([float(t), *(float(value) for value in squares[3::-1])])
    return course, load_of(learner.solve(moments).x)


def _rows(samples: WristSamples) -> Array:
    y, R = samples.wrench, samples.rotation
    if R is None:
        raise RuntimeError("the simulated arm knows its orientation.")
    return paper_rows(R, y[:, :3], y[:, 3:], DOWN)


def _press(wrist: Wrist, presses: Presses, rng: np.random.Generator) -> WristSamples:
    time = np.arange(round(presses.seconds * RATE)) / RATE
    push = pushes(presses.contacts, time)
    felt = WristSensor(wrist.held.load).feel(presses.path, time, push)
    return record(felt, wrist.sensor, rng, wrist.gain)


def _draw_eigenvalues(axes: Axes, course: Sequence[Sequence[float]]) -> None:
    points = np.array(course)
    for k in range(4):
        axes.semilogy(points[:, 0], points[:, 1 + k], lw=1, label=f"$\\lambda_{k + 2}$")
    axes.set_xlabel("time, s")
    axes.set_ylabel("eigenvalues of Eq. 37, mixed units")
    axes.legend(fontsize=8, frameon=False, ncols=2, loc="lower right")


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
