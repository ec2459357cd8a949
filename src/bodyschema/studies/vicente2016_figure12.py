"""Vicente et al. 2016, Fig. 12-13: both hands meet, before and after the eyes have taught the arms.

In the paper both hands of the real robot are sent to one place, palm to palm, 12 cm apart. After
the open loop they are about 16 cm apart and stand askew; after the closed loop on the adapted body
schema about 12 cm. There are photographs and no table; here the same is measured in simulation.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from bodyschema.acting.servoing import Servoing
from bodyschema.learners.published.image_likelihood import Edges
from bodyschema.report.figure import AFTER, BEFORE, GREY
from bodyschema.simulation.seeing_icub import Scene, SeeingIcub
from bodyschema.studies.hand_methods import METHODS, check_particles, premises
from bodyschema.studies.hand_summary import band, mean_and_sd, text
from bodyschema.studies.meeting_hands import APART, ARMS, BEGINNINGS, ENDS, both_offsets
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.studies.vicente2016_table1 import MODELS
from bodyschema.studies.watched_hands import MeetingTrace, watch_meeting

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEARNERS = ("particle-filter", "track")
COLOURS = {"particle-filter": BEFORE, "track": AFTER}
SAYS = {"particle-filter": "filter", "track": "tracker"}
HANDS = ("right", "left")
RIGHT_GREY, LEFT_GREY = 60, 150
"""Of the arms' masks in Fig. 13."""


@dataclass(frozen=True)
class Figure12:
    """Distance of the fingertips of both hands on their way to each other.

    Both arms of MuJoCo's iCub have wrong joint offsets. They go to the aims by the uncorrected
    body, while the eyes watch; then by what was learned. Every method sees the same open loop.
    """

    paper: ClassVar[str] = "vicente2016"
    figure: ClassVar[str] = "figure12"

    runs: int = ENDS * BEGINNINGS
    """Meetings: 10 different ones, then those again with other random numbers."""
    seed: int = 0
    """The same seed gives the same results."""
    particles: int = 200
    """Hypotheses, or first guesses, of each arm."""
    scene: Scene = "plain"
    """Before a plain background masks are compared, before a cluttered one the images."""
    edges: Edges = "hand"
    """Of the filter before a cluttered background: those of the whole hand, or its outline."""
    frames: int = 120
    """Of the open loop."""
    closed_frames: int = 50
    """Of the closed loop."""

    def __post_init__(self) -> None:
        check_particles(self.particles)

    def tasks(self) -> Sequence[Task]:
        """One meeting with one method."""
        return [
            Task(f"run {i}, {method}", {"run": i, "method": method})
            for i in range(self.runs)
            for method in LEARNERS
        ]

    def work(self, task: Task) -> Result:
        """The traces of one meeting, with both models."""
        run, method = task.settings["run"], METHODS[task.settings["method"]](self.edges)
        seed = int(np.random.SeedSequence([self.seed, run]).generate_state(1)[0])
        return {
            model: _stored(
                watch_meeting(
                    method, run % (ENDS * BEGINNINGS), self.scene, model, self.particles, seed,
                    self.frames, self.closed_frames, Servoing(),
                ),
                self.frames - 1,
            )
            for model in MODELS
        }  # fmt: skip

    def summary(self, results: Mapping[str, Result]) -> Result:
        """By method; under "mismatched" those of the wrong model."""
        found = {
            model: {method: self._of(results, method, model) for method in LEARNERS}
            for model in MODELS
        }
        head: Result = {"runs": self.runs, "particles": self.particles, "scene": self.scene}
        head |= {"desired_mm": 1e3 * APART, "premises": premises(self.scene, self.edges)}
        return head | {
            "methods": found["identical"],
            "mismatched": {"methods": found["mismatched"]},
        }

    def _of(self, results: Mapping[str, Result], method: str, model: str) -> Result:
        traces = [results[f"run {i}, {method}"][model] for i in range(self.runs)]
        gap = np.array([trace["gap"] for trace in traces])
        end = self.frames - 1
        return {
            when: {
                "distance_mm": _mean_and_sd(gap[:, frame]),
                "distance_error_mm": _mean_and_sd(np.abs(gap[:, frame] - 1e3 * APART)),
                "between": mean_and_sd([trace["between"][frame] for trace in traces]),
                "reaching": {
                    hand: mean_and_sd([trace["reaching"][frame][i] for trace in traces])
                    for i, hand in enumerate(HANDS)
                },
                "estimation": {
                    hand: mean_and_sd([trace["estimation"][frame][i] for trace in traces])
                    for i, hand in enumerate(HANDS)
                },
            }
            for when, frame in (("before", end), ("after", -1))
        }

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """Before, and after with each method; below with a model that is a little wrong."""
        rows = self._block(summary["methods"], "")
        for hand in HANDS:
            for unit in ("mm", "deg"):
                cells = [text(c["reaching"][hand], unit) for c in _cells(summary["methods"])]
                rows += [[f"{hand} hand to aim, {unit}", "", *cells]]
        rows += self._block(summary["mismatched"]["methods"], "wrong model: ")
        return Rows(
            ["mean ± SD", "paper", "before", "filter", "tracker"], rows, self._notes(summary)
        )

    def _block(self, methods: Mapping[str, Any], model: str) -> list[list[str]]:
        cells = _cells(methods)
        gap = [f"{c['distance_mm']['mean']:.2f} ± {c['distance_mm']['sd']:.2f}" for c in cells]
        rows = [[f"{model}fingertips, mm", "160 to 120", *gap]]
        for unit in ("mm", "deg"):
            rows += [
                [f"{model}hand to hand, {unit}", "", *(text(c["between"], unit) for c in cells)]
            ]
        return rows

    def _notes(self, summary: Mapping[str, Any]) -> list[str]:
        learned = ", ".join(
            f"{SAYS[m]} " + " and ".join(
                text(summary["methods"][m]["before"]["estimation"][hand], "mm") for hand in HANDS
            )
            for m in LEARNERS
        )  # fmt: skip
        return [
            f"{self.runs} meetings, {self.particles} particles (filter as published) or first "
            f"guesses (tracker) an arm; aim: {1e3 * APART:.0f} mm; {summary['premises']['scene']}.",
            *(f"{summary['premises'][model].capitalize()}." for model in MODELS),
            "The paper's figures are of one meeting of the real robot, read off photographs; its "
            "postures and offsets are not published.",
            "Hand to hand: the pose of the right hand in the left one against the desired one.",
            f"Estimation error of the right and left hand at the end of the open loop, mm: "
            f"{learned}.",
        ]

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Distance of the fingertips, and how askew the hands stand, frame by frame."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(12, 4.5), layout="constrained")
        panels = figure.subplots(1, 2)
        shown = np.arange(self.frames + self.closed_frames)
        for method in LEARNERS:
            traces = [results[f"run {i}, {method}"]["identical"] for i in range(self.runs)]
            gap = np.array([trace["gap"] for trace in traces])
            turn = np.array([trace["between"] for trace in traces])[..., 1]
            for panel, values in zip(panels, (gap, turn), strict=True):
                band(panel, shown, values, SAYS[method], COLOURS[method], "-")
        panels[0].axhline(1e3 * APART, color=GREY, linestyle="--", label="desired")
        panels[0].set(ylabel="distance of the index fingertips, mm")
        panels[1].set(ylabel="hand to hand, deg off", ylim=(0, None))
        for panel in panels:
            panel.axvline(self.frames, color=GREY, linestyle=":")
            panel.set(xlabel="frame; from the dotted line on by what was learned")
            panel.legend(frameon=False)
        return figure


@dataclass(frozen=True)
class Figure13(Figure12):
    """What both eyes see before and after the body schema is adapted; runs of Fig. 12.

    Before a plain background: the masks of both arms, of which they learned.
    """

    figure: ClassVar[str] = "figure13"
    source: ClassVar[str] = "figure12"

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """The first meeting; one row after the open loop, one each after a closed loop."""
        from matplotlib.figure import Figure

        traces = {method: results[f"run 0, {method}"]["identical"] for method in LEARNERS}
        views = [("before", traces["track"]["q"][0], traces["track"]["gap"][self.frames - 1])]
        views += [(SAYS[m], trace["q"][1], trace["gap"][-1]) for m, trace in traces.items()]
        robot = SeeingIcub(both_offsets(), self.scene)
        figure = Figure(figsize=(9, 3.5 * len(views)), layout="constrained")
        for panels, (says, q, gap) in zip(figure.subplots(len(views), 2), views, strict=True):
            robot.command(q)
            for panel, picture, eye in zip(panels, _seen(robot), HANDS[::-1], strict=True):
                panel.imshow(picture)
                panel.set(xticks=[], yticks=[], title=f"{says}: {eye} eye, {gap:.0f} mm apart")
        return figure


def _seen(robot: SeeingIcub) -> list[NDArray[np.uint8]]:
    """What the learners see in the left and the right eye, (height, width, 3): images, or the
    masks of the right and of the left arm in a grey each before white."""
    views = []
    for right, left in zip(*(robot.look(arm.links).pictures for arm in ARMS), strict=True):
        grey = np.full(right.shape[:2], 255, dtype=np.uint8)
        if right.dtype == np.bool_:
            grey[right], grey[left] = RIGHT_GREY, LEFT_GREY
            views.append(np.repeat(grey[..., None], 3, axis=2))
        else:
            views.append(np.asarray(right, dtype=np.uint8))
    return views


def _stored(trace: MeetingTrace, end: int) -> Result:
    """A trace in JSON types; postures at the end of the open and of the closed loop."""
    curves: Result = {
        name: np.round(getattr(trace, name), 6).tolist()
        for name in ("gap", "between", "reaching", "estimation")
    }
    return curves | {"q": [trace.q[end].tolist(), trace.q[-1].tolist()]}


def _mean_and_sd(values: Any) -> dict[str, float]:
    return {"mean": float(np.mean(values)), "sd": float(np.std(values))}


def _cells(methods: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Before, which is the same for all methods, and after with each."""
    return [methods["track"]["before"], *(methods[method]["after"] for method in LEARNERS)]
