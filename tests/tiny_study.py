"""The smallest study: enough for runner and command line, importable by their processes."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from bodyschema.studies.study import Result, Rows, Task


@dataclass(frozen=True)
class TinyStudy:
    """Mean of random numbers."""

    paper: ClassVar[str] = "nobody1900"
    figure: ClassVar[str] = "figure1"

    runs: int = 4
    """Number of tasks."""
    seed: int = 0
    """Of the random numbers."""
    pause: float = 0.0
    """s that a task takes."""

    def tasks(self) -> Sequence[Task]:
        return [Task(f"run {i}", {"number": i}) for i in range(self.runs)]

    def work(self, task: Task) -> Result:
        time.sleep(self.pause)
        rng = np.random.default_rng([self.seed, task.settings["number"]])
        return {"mean": float(rng.normal(size=10).mean()), "ends": (0, 1)}

    def summary(self, results: Mapping[str, Result]) -> Result:
        return {"means": [result["mean"] for result in results.values()], "paper": 0.0}

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        mean = float(np.mean(summary["means"]))
        return Rows(("", "ours", "paper"), [("mean", f"{mean:.3f}", "0")], ("Nothing is learned.",))

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Any:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(4, 3))
        figure.add_subplot().plot(summary["means"])
        return figure
