"""Figure 13 of Hersch, Sauser and Billard 2008: a tool becomes part of the body.

The robot holds a stick of 340 mm and looks at its tip. In the paper, gradient descent on a robot
brings the distance between the tip as seen and as predicted from 40 cm to 5 cm, the noise of the
eyes, in about 2000 steps when only the last limb adapts and 1000 when the whole arm does. Here the
robot is simulated (`held_tool`), the same data go to the gradient and to the smoother, and the true
body tells what the distance cannot: the error of the tip, against the least that so many samples
allow, and what became of the elbow. Then parts of the body change in mid-run.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from bodyschema.errors import MissingExtraError
from bodyschema.studies.held_tool import STICK, Change, Motion, Setting
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.studies.tool_runs import AFTER, LEARNERS, LIMITS, changing, learning

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PAPER = {"online_gradient_last_limb": 2000, "online_gradient_whole_arm": 1000}
"""Steps to 5 cm."""

BEFORE, LATER = 400, 320
"""Samples before and after a change."""

CHANGES = {
    "tool dropped": Change("tool", STICK, BEFORE),
    "tip moved 10 cm": Change("tool", 0.10, BEFORE),
    "tip moved 5 cm": Change("tool", 0.05, BEFORE),
    "upper arm moved 10 cm": Change("upper arm", 0.10, BEFORE),
    "camera moved 10 cm": Change("camera", 0.10, BEFORE),
}


@dataclass(frozen=True)
class Figure13:
    """A 340 mm stick becomes part of the arm; then it is dropped, or moves in the hand."""

    paper: ClassVar[str] = "hersch2008"
    figure: ClassVar[str] = "figure13"

    runs: int = 20
    """Robots, each with another stick, another error of its arm and other data."""
    seed: int = 0
    """The same seed gives the same answer."""
    steps: int = 3000
    """Samples for each learner; the robot of the paper took ten a second."""
    noise: float = 0.05
    """m: mean length of the error of the eyes."""
    outliers: float = 0.05
    """Share of samples that are up to 0.5 m off."""
    motion: Motion = "smooth"
    """An arm that is moved about, or independent postures."""
    arm_error: float = 1.0
    """Of the true arm, in units of what the robot believes: 0.01 rad an axis, 3 mm a link."""

    def tasks(self) -> Sequence[Task]:
        """For each robot, the learners on one stream of data, and the changes."""
        kinds = [("tool", ""), *(("change", name) for name in CHANGES)]
        return [
            Task(" ".join([kind, *name.split(), str(run)]), {"run": run, "change": name})
            for run in range(self.runs)
            for kind, name in kinds
        ]

    def work(self, task: Task) -> Result:
        """One robot: all learners, or the monitor through one change."""
        run, name = task.settings["run"], task.settings["change"]
        setting = Setting(self.noise, self.outliers, self.motion, self.arm_error)
        if not name:
            scene = setting.scene(np.random.default_rng([self.seed, run]), self.steps)
            return {learner: learning(learner, scene, run == 0) for learner in LEARNERS}
        change = CHANGES[name]
        rng = np.random.default_rng([self.seed, run, 1 + list(CHANGES).index(name)])
        return changing(change, setting.scene(rng, BEFORE + LATER, change))

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Medians and root mean squares over the robots; mm, and samples."""
        by_kind: dict[str, list[Result]] = {}
        for task in self.tasks():
            by_kind.setdefault(task.settings["change"], []).append(results[task.key])
        tools = by_kind.pop("")
        return {
            "learners": {
                name: _learner_summary([tool[name] for tool in tools]) | _of_paper(name)
                for name in LEARNERS
            },
            "changes": {
                name: _change_summary(CHANGES[name].part, runs) for name, runs in by_kind.items()
            },
        }

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """Learners in the table, changes in the notes."""
        headers = (
            "learner", "5 cm after", "paper", "2 cm", "1 cm", "tip, mm", "over bound", "elbow, mm",
        )  # fmt: skip
        rows = []
        for name, found in summary["learners"].items():
            last = str(self.steps)
            steps = [_count(found["steps"][limit]["median"]) for limit in LIMITS]
            tip, bound = found["tip_mm"][last], found["bound_mm"][last]
            rows.append(
                [
                    _label(name),
                    steps[0],
                    str(PAPER.get(name, "")),
                    *steps[1:],
                    f"{tip:.1f}",
                    f"{tip / bound:.2f}",
                    f"{found['elbow_mm']:.1f}",
                ]
            )
        return Rows(headers, rows, [*self._notes(summary), *_change_notes(summary["changes"])])

    def _notes(self, summary: Mapping[str, Any]) -> list[str]:
        before = summary["learners"]["smoother_whole_arm"]["elbow_before_mm"]
        return [
            f"Steps: samples until the error of the tip at fresh postures stays below, median of "
            f"{self.runs} robots. Tip and elbow: rms error after {self.steps} steps; the elbow "
            f"began with {before:.1f} mm. Bound: the least error that as many samples without "
            "outliers allow, given what the robot knew of its arm.",
            "Where only the last limb adapts, the error of the arm stays: the bound, which takes "
            "the arm as known, is for --arm-error 0.",
            "The paper does not give its step sizes; those of the gradient are chosen to come "
            "near its numbers of steps. Over the whole arm it reaches the tip by ruining the "
            "elbow, which the paper did not measure.",
        ]

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Two panels like the paper's, with the smoother beside the gradient."""
        try:
            from matplotlib.figure import Figure
        except ImportError:
            raise MissingExtraError("matplotlib", "report", "the picture of a study") from None
        first = results[self.tasks()[0].key]
        figure = Figure(figsize=(10, 4), layout="constrained")
        panels = figure.subplots(1, 2, sharey=True)
        for axes, limb in zip(panels, ("last_limb", "whole_arm"), strict=True):
            _panel(axes, limb, first)
            axes.axhline(100 * self.noise, color="0.4", lw=0.8, ls=":", label="noise of the eyes")
        panels[0].set_ylabel("distance of the tip, cm")
        panels[1].legend(loc="upper right", framealpha=0.9, edgecolor="none", fontsize=8)
        return figure


def _learner_summary(runs: Sequence[Result]) -> Result:
    return {
        "steps": {limit: _quantiles(run["steps"][limit] for run in runs) for limit in LIMITS},
        "tip_mm": {k: _rms(run["tip"][k] for run in runs) for k in runs[0]["tip"]},
        "bound_mm": {k: _rms(run["bound"][k] for run in runs) for k in runs[0]["bound"]},
        "elbow_mm": _rms(run["elbow"] for run in runs),
        "elbow_before_mm": _rms(run["elbow_before"] for run in runs),
    }


def _of_paper(name: str) -> Result:
    return {"paper_steps_to_5cm": PAPER[name]} if name in PAPER else {}


def _change_summary(part: str, runs: Sequence[Result]) -> Result:
    return {
        "false_alarms_before": sum(run["false_alarms"] for run in runs),
        "samples_to_notice": _quantiles(run["noticed"] for run in runs),
        "samples_to_decide": _quantiles(run["decided"] for run in runs),
        "right_part": float(np.mean([run["blamed"] == part for run in runs])),
        "steps": {limit: _quantiles(run["steps"][limit] for run in runs) for limit in LIMITS},
        "tip_before_mm": _rms(run["tip_before"] for run in runs),
        "tip_mm": {str(k): _rms(run["tip"][str(k)] for run in runs) for k in AFTER},
        "elbow_before_mm": _rms(run["elbow_before"] for run in runs),
        "elbow_after_mm": _rms(run["elbow_after"] for run in runs),
    }


def _change_notes(changes: Mapping[str, Any]) -> list[str]:
    notes = []
    for name, found in changes.items():
        noticed, steps = found["samples_to_notice"], found["steps"]["5cm"]
        notes.append(
            f"{name.capitalize()}: noticed after {_count(noticed['median'])} samples (95 %: "
            f"{_count(noticed['p95'])}), the right part named in {found['right_part']:.0%}, the "
            f"tip back under 5 cm after {_count(steps['median'])} (95 %: {_count(steps['p95'])}), "
            f"elbow {found['elbow_before_mm']:.1f} mm before and {found['elbow_after_mm']:.1f} mm "
            f"{LATER} samples later."
        )
    return notes


def _quantiles(counts: Iterable[int | None]) -> dict[str, float | None]:
    """Median and 95 %; None where the count was not reached."""
    values = [np.inf if count is None else float(count) for count in counts]
    at = np.quantile(values, [0.5, 0.95], method="inverted_cdf")
    return {
        k: float(v) if np.isfinite(v) else None for k, v in zip(("median", "p95"), at, strict=True)
    }


def _rms(errors: Iterable[float]) -> float:
    """m -> mm"""
    return float(1000 * np.sqrt(np.mean(np.square(list(errors)))))


def _label(learner: str) -> str:
    return learner.removeprefix("online_").replace("_", " ")


def _count(value: float | None) -> str:
    return "never" if value is None else f"{value:.0f}"


def _panel(axes: Axes, limb: str, first: Result) -> None:
    for learner, color in (("online_gradient", "0.55"), ("smoother", "tab:blue")):
        step, seen, true = np.array(first[f"{learner}_{limb}"]["curve"]).T
        name = _label(learner)
        axes.plot(step, 100 * seen, ".", ms=2, color=color, alpha=0.5, label=f"{name}: as seen")
        axes.plot(step, 100 * true, color=color, label=f"{name}: true error, fresh postures")
    axes.set_title(f"{limb.replace('_', ' ')} adapts")
    axes.set_xlabel("step")
    axes.set_ylim(0, 60)
    axes.grid(alpha=0.3)
