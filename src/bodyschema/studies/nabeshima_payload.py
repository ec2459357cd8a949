"""The held object of Nabeshima and Kuniyoshi, section 4.4: known after how many seconds of motion?

The wire box of the paper (0.594 kg, the printed centre of mass) is moved along random way points;
the wrist sensor has the noise of a Mini40, an offset, and sits about a degree off. The paper's form
(Eq. 37: mass and centre of mass at rest) and ours (ten inertial parameters, six biases, the
sensor's rotation, motion from noisy encoders) read the same samples. Counted is the time after
which mass stays within 1 % and the centre of mass within 1 mm.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
import tyro

from bodyschema.errors import MissingExtraError
from bodyschema.report.figure import AFTER, BEFORE, log_scale
from bodyschema.simulation.loads import (
    RATE,
    Held,
    draw_motion,
    draw_sensor,
    record,
    wire_box,
)
from bodyschema.studies.payload_runs import learner_run, paper_run
from bodyschema.studies.study import Result, Rows, Task

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SPEEDS = (0.15, 0.5, 1.0)
USUAL = 0.5
METHODS = ("faithful", "better")
PAPER_SECONDS = 6.6


@dataclass(frozen=True)
class Payload:
    """Mass, centre of mass and inertia of a held box, from the wrist sensor alone."""

    paper: ClassVar[str] = "nabeshima"
    figure: ClassVar[str] = "payload"

    runs: Annotated[int, tyro.conf.arg(aliases=["--seeds"])] = 40
    """Motions at each speed, each with another sensor."""
    seed: int = 0
    """The same seed gives the same answer."""
    seconds: float = 40.0
    """Length of a motion; errors are told at its end."""
    turn_deg: float = 1.0
    """How far the sensor is turned on its mount, standard deviation about each axis."""
    force_offset: float = 0.5
    """N, standard deviation of the sensor's offset; that of torque is 0.04 m times as large."""

    def tasks(self) -> Sequence[Task]:
        """A motion at a speed each."""
        return [
            Task(f"speed {speed:g} run {run}", {"speed": speed, "run": run})
            for speed in SPEEDS
            for run in range(self.runs)
        ]

    def work(self, task: Task) -> Result:
        """Both methods on one stream."""
        speed, run = task.settings["speed"], task.settings["run"]
        rng = np.random.default_rng([self.seed, run, round(100 * speed)])
        box = wire_box()
        motion = draw_motion(rng, self.seconds, speed, RATE)
        bias = (self.force_offset, 0.04 * self.force_offset)
        sensor = draw_sensor(rng, float(np.radians(self.turn_deg)), bias)
        samples = record(motion, [Held(0.0, box)], sensor, rng)
        return {
            "faithful": paper_run(samples, box),
            "better": learner_run(samples, box),
        }

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Medians and shares, by method and speed; those at half speed on top."""
        by_speed = {
            speed: [results[f"speed {speed:g} run {run}"] for run in range(self.runs)]
            for speed in SPEEDS
        }
        return {
            method: _shares([r[method] for r in by_speed[USUAL]])
            | {
                "speeds": {
                    f"{speed:g}": _shares([r[method] for r in found])
                    for speed, found in by_speed.items()
                }
            }
            for method in METHODS
        }

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """A line a method and speed."""
        lines = []
        for method in METHODS:
            for speed, found in summary[method]["speeds"].items():
                time = found["seconds_to_1pct_1mm"]
                lines.append(
                    [
                        method,
                        f"x{speed}",
                        _seconds(time["median"]),
                        _seconds(time["p90"]),
                        f"{found['mass_pct']:.2g}",
                        f"{found['com_mm']:.2g}",
                        _shown(found["inertia_pct"]),
                        _shown(found["coverage"], 100),
                        _shown(found["physical_share"], 100),
                        _seconds(found["certified_s"]),
                    ]
                )
        headers = (
            "method",
            "speed",
            "s",
            "90 %",
            "mass %",
            "com mm",
            "I %",
            "in %",
            "real %",
            "sure s",
        )
        return Rows(
            headers,
            lines,
            (
                "s: seconds until mass stays within 1 % and centre of mass within 1 mm, median; "
                "90 %: of nine motions in ten; sure s: until the learner itself certifies it.",
                f"The paper stopped at {PAPER_SECONDS} s, with its sensor's offset removed "
                "beforehand; errors are medians at the end of the motion.",
                "in %: of the ten parameters, those within 1.96 stated standard deviations of the "
                "truth; real %: motions whose answers were bodies that can exist, all the time.",
            ),
        )

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Errors over time, median and 90 % of the runs."""
        try:
            from matplotlib.figure import Figure
        except ImportError:
            raise MissingExtraError("matplotlib", "report", "the picture of a study") from None
        figure = Figure(figsize=(10, 5.5), layout="constrained")
        axes = figure.subplots(2, 3, sharex=True, sharey="row")
        for column, speed in enumerate(SPEEDS):
            runs = [results[f"speed {speed:g} run {run}"] for run in range(self.runs)]
            for row, (name, highest) in enumerate((("mass_pct", 100.0), ("com_mm", 1e3))):
                _draw_errors(axes[row, column], runs, name)
                axes[row, column].set_ylim(1e-3, highest)
            axes[0, column].set_title(f"joint speed x{speed:g}")
            axes[1, column].set_xlabel("s of motion")
        log_scale(axes[0, 0], "%")
        log_scale(axes[1, 0], "mm")
        axes[0, 0].set_ylabel("error of mass")
        axes[1, 0].set_ylabel("of centre of mass")
        axes[0, 2].legend(title="median (dotted: 90 %)", fontsize=9, title_fontsize=9)
        return figure


COLOURS = {"faithful": ("paper's form", BEFORE), "better": ("ours", AFTER)}


def _draw_errors(panel: Axes, runs: Sequence[Result], name: str) -> None:
    """Errors over time of both methods; the grey line is what was asked for."""
    panel.set_yscale("log")
    for method, (label, colour) in COLOURS.items():
        time = np.array(runs[0][method]["time"])
        curves = np.array([r[method]["curve"][name] for r in runs])
        panel.plot(time, np.median(curves, axis=0), color=colour, label=label)
        panel.plot(time, np.quantile(curves, 0.9, axis=0), ":", color=colour)
    panel.axhline(1.0, color="0.6", lw=0.8)


def _shares(runs: Sequence[Result]) -> dict[str, Any]:
    """What the runs of one method at one speed come to; a time that is never reached is None."""
    inside = [r["inside"] for r in runs]
    stated = inside[0] is not None
    hits = np.array(inside, dtype=float) if stated else np.full((1, 10), np.nan)
    return {
        "seconds_to_1pct_1mm": {
            "median": _late([r["seconds"] for r in runs], 0.5),
            "p90": _late([r["seconds"] for r in runs], 0.9),
        },
        "mass_pct": float(np.median([r["mass_pct"] for r in runs])),
        "com_mm": float(np.median([r["com_mm"] for r in runs])),
        "inertia_pct": float(np.median([r["inertia_pct"] for r in runs])) if stated else None,
        "coverage": float(hits.mean()) if stated else None,
        "coverage_of": {
            "mass": float(hits[:, 0].mean()),
            "first_moments": float(hits[:, 1:4].mean()),
            "moments": float(hits[:, 4:].mean()),
        }
        if stated
        else None,
        "physical_share": float(np.mean([r["physical"] for r in runs])),
        "certified_s": _late([r["certified"] for r in runs], 0.5),
    }


def _late(times: Sequence[float | None], share: float) -> float | None:
    """A quantile of times of which some are never; None if it falls among these."""
    ordered = sorted(np.inf if time is None else time for time in times)
    found = ordered[min(len(ordered) - 1, max(0, int(np.ceil(share * len(ordered))) - 1))]
    return found if np.isfinite(found) else None


def _seconds(time: float | None) -> str:
    return "never" if time is None else f"{time:.1f}"


def _shown(value: float | None, factor: float = 1.0) -> str:
    return "-" if value is None else f"{factor * value:.3g}"
