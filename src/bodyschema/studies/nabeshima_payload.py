"""The held object of Nabeshima and Kuniyoshi, section 4.4: known after how many seconds of motion?

The wire box of the paper (0.594 kg, the printed centre of mass) is moved along random way points;
the wrist sensor has the noise of a Mini40. The paper's form (Eq. 37: mass and centre of mass at
rest) and ours (ten inertial parameters, six biases, the sensor's rotation, motion from noisy
encoders) read the same samples. Counted is the time after which mass stays within 1 % and the
centre of mass within 1 mm: within the paper's premises (`wrist_premises`), and outside them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
import tyro

from bodyschema.errors import MissingExtraError
from bodyschema.learners.published.paper_payload import READINGS
from bodyschema.report.figure import AFTER, BEFORE, log_scale
from bodyschema.simulation.loads import RATE, Held, draw_motion, record, wire_box
from bodyschema.studies.payload_runs import learner_run, paper_run
from bodyschema.studies.payload_summary import seconds_text, shares, shown, times_text
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.studies.wrist_premises import WristPremises

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

METHODS = {"faithful": "theirs", "better": "ours"}
SENSORS = {"": "clean", "_outside": "raw"}
"""What became of the sensor's offset and turn, by the ending of a key."""

PAPER_SECONDS = 6.6


@dataclass(frozen=True)
class Payload(WristPremises):
    """Mass, centre of mass and inertia of a held box, from the wrist sensor alone."""

    paper: ClassVar[str] = "nabeshima"
    figure: ClassVar[str] = "payload"

    runs: Annotated[int, tyro.conf.arg(aliases=["--seeds"])] = 40
    """Motions at each speed, each with another sensor."""
    seed: int = 0
    """The same seed gives the same answer."""
    seconds: float = 40.0
    """Length of a motion; errors are told at its end."""

    def tasks(self) -> Sequence[Task]:
        """A motion at a speed each."""
        self.check_premises()
        return [
            Task(f"speed {speed:g} run {run}", {"speed": speed, "run": run})
            for speed in self.speeds
            for run in range(self.runs)
        ]

    def work(self, task: Task) -> Result:
        """Both methods on one motion, felt by the paper's sensor and by the harder one."""
        speed, run = task.settings["speed"], task.settings["run"]
        box, answer = wire_box(), {}
        for ending, case in self.cases.items():
            rng = np.random.default_rng([self.seed, run, round(100 * speed)])
            motion = draw_motion(rng, self.seconds, speed, RATE)
            sensor = case.draw_sensor(rng)
            samples = record(motion, [Held(0.0, box)], sensor, rng)
            answer[f"faithful{ending}"] = paper_run(samples, box, sensor.noise)
            answer[f"better{ending}"] = learner_run(samples, box)
        return answer

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Medians and shares, by method and case; those at the speed of the case on top."""
        answer: Result = self.stated_premises()
        for ending, case in self.cases.items():
            for name in METHODS:
                key = f"{name}{ending}"
                runs = {speed: self._runs(results, speed, key) for speed in self.speeds}
                speeds = {f"{speed:g}": shares(found) for speed, found in runs.items()}
                answer[key] = speeds[f"{case.speed:g}"] | {"speeds": speeds}
        return answer

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """A line a case and speed."""
        headers = ("sensor", "theirs s", "at rest s", "ours s", "sure s", "mass %", "com mm",
                   "in %")  # fmt: skip
        lines = []
        for ending in SENSORS:
            for speed in self.speeds:
                sensor = SENSORS[ending]
                theirs, ours = (
                    summary[f"{name}{ending}"]["speeds"][f"{speed:g}"] for name in METHODS
                )
                if speed == self.cases[ending].speed:
                    sensor = "out" if ending else "in"
                lines.append(
                    [
                        f"{sensor} x{speed:g}",
                        times_text(theirs["seconds_to_1pct_1mm"]),
                        times_text(theirs["readings"]["at rest"]["seconds_to_1pct_1mm"]),
                        times_text(ours["seconds_to_1pct_1mm"]),
                        seconds_text(ours["certified_s"]),
                        *(f"{theirs[key]:.1g}/{ours[key]:.1g}" for key in ("mass_pct", "com_mm")),
                        shown(ours["coverage"], 100),
                    ]
                )
        return Rows(headers, lines, (*self._premises_told(summary), *self._columns_told()))

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Errors over time, median and 90 % of the runs; a line of panels a case and an error."""
        try:
            from matplotlib.figure import Figure
        except ImportError:
            raise MissingExtraError("matplotlib", "report", "the picture of a study") from None
        figure = Figure(figsize=(10, 9.5), layout="constrained")
        axes = figure.subplots(4, len(self.speeds), sharex=True, squeeze=False)
        quantities = (("mass_pct", 1e2, "mass", "%"), ("com_mm", 1e3, "centre", "mm"))
        for block, ending in enumerate(SENSORS):
            for row, (name, highest, what, unit) in enumerate(quantities, start=2 * block):
                for column, speed in enumerate(self.speeds):
                    panel = axes[row, column]
                    for method, colour in (("faithful", BEFORE), ("better", AFTER)):
                        found = self._runs(results, speed, f"{method}{ending}")
                        _draw_errors(panel, found, name, METHODS[method], colour)
                    log_scale(panel, unit)
                    panel.set_ylim(1e-3, highest)
                    panel.set_title(self._title(ending, speed), fontsize=10)
                axes[row, 0].set_ylabel(f"error of {what}")
        for panel in axes[-1]:
            panel.set_xlabel("s of motion")
        axes[0, -1].legend(title="median (dotted: 90 %)", fontsize=9, title_fontsize=9)
        return figure

    def _title(self, ending: str, speed: float) -> str:
        case = self.cases[ending]
        where = ("outside" if ending else "within") if speed == case.speed else SENSORS[ending]
        return f"{where}: offset {case.force_offset:g} N, x{speed:g}"

    def _runs(self, results: Mapping[str, Result], speed: float, key: str) -> list[Result]:
        return [results[f"speed {speed:g} run {run}"][key] for run in range(self.runs)]

    def _premises_told(self, summary: Mapping[str, Any]) -> list[str]:
        speeds = " / ".join(f"x{speed:g}" for speed in self.speeds)
        told = [
            f"in: the paper's premises ({self.within.text}); out: {self.outside.text}. "
            "Clean: offset and turn of the sensor were removed before, as the paper presumes; raw: "
            "they are left in."
        ]
        for ending, sensor in SENSORS.items():
            found = summary[f"faithful{ending}"]["speeds"].values()
            readings = []
            for reading in READINGS:
                times = [f["readings"][reading]["seconds_to_1pct_1mm"]["median"] for f in found]
                readings.append(f"{reading} {' / '.join(map(seconds_text, times))}")
            told.append(f"Theirs in each reading, {sensor}, s at {speeds}: {'; '.join(readings)}.")
        return told

    def _columns_told(self) -> list[str]:
        return [
            "s: seconds until mass stays within 1 % and centre of mass within 1 mm, median / of "
            "nine motions in ten; at rest: theirs, from samples at which the arm stands still; "
            f"sure s: until our learner certifies it. The paper stopped at {PAPER_SECONDS} s.",
            f"mass, com: theirs/ours, medians after {self.seconds:g} s; in %: of our ten "
            "parameters, those within 1.96 stated standard deviations of the truth.",
        ]


def _draw_errors(panel: Axes, runs: Sequence[Result], name: str, label: str, colour: str) -> None:
    """Errors over time of a method; the grey line is what was asked for."""
    panel.set_yscale("log")
    time = np.array(runs[0]["time"])
    curves = np.array([r["curve"][name] for r in runs])
    panel.plot(time, np.median(curves, axis=0), color=colour, label=label)
    panel.plot(time, np.quantile(curves, 0.9, axis=0), ":", color=colour)
    panel.axhline(1.0, color="0.6", lw=0.8)
