"""Hersch et al. 2008, Fig. 10: a humanoid of 24 joints learns its body by looking at itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.determinable import determinable
from bodyschema.model.variables import free_skeleton
from bodyschema.simulation.humanoid import humanoid
from bodyschema.studies.gradient_trees import bin_ends, gradient_tree_run
from bodyschema.studies.self_watching import CASES, FRESH, SelfWatching
from bodyschema.studies.study import Result, Rows, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

TO_ONE_PERCENT = 0.01

SEEN = {"ends": "hands and feet", "alternating": "in turn with joints between"}
PAPER = {"ends": "converges", "alternating": "faster"}
"""In words: one run is plotted, without numbers."""


@dataclass(frozen=True)
class Figure10:
    """A humanoid of 24 joints learns its body from nothing, by looking at its hands and feet.

    Two cases: only hands and feet are seen, or they take turns with elbows, knees, shoulders and
    waist. Answers how many samples (postures) it takes until every marker is where it is expected.
    """

    paper: ClassVar[str] = "hersch2008"
    figure: ClassVar[str] = "figure10"

    learner: Literal["online-gradient", "pool"] = "pool"
    """Gradient descent as published, or a pool of hypotheses."""
    runs: int = 300
    """Repetitions of each case; each has other samples and another start."""
    seed: int = 0
    """The same seed gives the same results."""
    reach_deg: float | None = None
    """Every joint moves this far either way; the ranges of the real joints when absent."""
    epsilon: float = 0.05
    """Step of the gradient, in squared typical links (0.103 m)."""
    limit: int | None = None
    """Samples after which a run has failed; 1,000,000 for the gradient, 60 for the pool."""

    def tasks(self) -> Sequence[Task]:
        """A run of the gradient each, ten runs of the pool."""
        size = 10 if self.learner == "pool" else 1
        return [
            Task(f"{case}_{first}", {"case": case, "first": first, "runs": size})
            for case in CASES
            for first in range(0, self.runs, size)
        ]

    def work(self, task: Task) -> Result:
        """Samples to convergence of each run, -1 if none, and the errors on the way."""
        case, first = task.settings["case"], task.settings["first"]
        runs = [
            self._run(case, run)
            for run in range(first, min(first + task.settings["runs"], self.runs))
        ]
        return {
            "samples": [-1 if samples is None else samples for samples, _ in runs],
            "curves": [_json(curve) for _, curve in runs],
        }

    def _run(self, case: str, run: int) -> tuple[int | None, Array]:
        """Samples to convergence, and mean error (n_points, n_groups) m on the way."""
        watching = self.watching(case)
        rng = np.random.default_rng([self.seed, list(CASES).index(case), run])
        if self.learner == "pool":
            from bodyschema.studies.pool_trees import pool_tree_run

            pooled = pool_tree_run(watching, TO_ONE_PERCENT, self.most, rng)
            return pooled.samples, pooled.curve
        taught = gradient_tree_run(watching, self.epsilon, TO_ONE_PERCENT, self.most, rng)
        return taught.iterations, taught.curve

    def watching(self, case: str) -> SelfWatching:
        """The robot and what it sees."""
        reach = None if self.reach_deg is None else float(np.deg2rad(self.reach_deg))
        return SelfWatching(humanoid(reach), CASES[case])

    @property
    def most(self) -> int:
        """Samples of a run."""
        return self.limit or (60 if self.learner == "pool" else 1_000_000)

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Hands and feet at the top level; the other case under its name."""
        found = {case: self._case(case, results) for case in CASES}
        return {
            "learner": self.learner,
            "runs": self.runs,
            **found["ends"],
            "alternating": found["alternating"],
        }

    def _case(self, case: str, results: Mapping[str, Result]) -> Result:
        parts = [result for key, result in results.items() if key.startswith(case)]
        samples = np.array([count for part in parts for count in part["samples"]])
        good = samples[samples > 0]
        watching = self.watching(case)
        told = determinable(watching.body, free_skeleton(watching.body), watching.looks())
        quantile = {
            f"samples_{name}": float(np.quantile(good, share)) if len(good) else None
            for name, share in (("median", 0.5), ("p95", 0.95), ("max", 1.0))
        }
        return {
            "failed": int(np.sum(samples < 0)),
            **quantile,
            "identifiable": told.rank,
            "parameters": told.variables,
            "condition": round(told.condition, 1),
        }

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """One row a case."""
        rows = []
        for case in CASES:
            of = summary if case == "ends" else summary[case]
            rows.append([
                SEEN[case], f"{of['failed']} of {self.runs}", _count(of["samples_median"]),
                _count(of["samples_p95"]), f"{of['identifiable']} of {of['parameters']}",
                PAPER[case],
            ])  # fmt: skip
        head = ["seen", "failed", "samples, median", "95 %", "identifiable", "paper"]
        return Rows(head, rows, self._notes())

    def _notes(self) -> list[str]:
        ranges = "the ranges of the real joints"
        if self.reach_deg is not None:
            ranges = f"+-{self.reach_deg:g} deg for every joint"
        known = (
            f"all markers within 1 % of their path's length in {FRESH} fresh postures"
            if self.learner == "pool"
            else "500 samples in a row with all markers within 1 % of their path's length"
        )
        return [
            f"A sample is one posture, anywhere in {ranges}. Converged: {known}.",
            f"Failed: not within {self.most:,} samples.",
            "Not all parameters can be told from what is seen: a joint's centre may slide along "
            "its axis, and nothing is seen of the pelvis. The paper calls the second case free of "
            "ambiguity; that is so for the joints whose own centre is seen.",
        ]

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Error of the expected positions against samples, all runs and their median."""
        from matplotlib.figure import Figure
        from matplotlib.ticker import FuncFormatter, NullLocator

        from bodyschema.report.figure import AFTER, BEFORE, log_scale

        figure = Figure(figsize=(9, 3.8), layout="constrained")
        panels = figure.subplots(1, 2, sharex=True, sharey=True)
        for axes, case, colour in zip(panels, CASES, (AFTER, BEFORE), strict=True):
            parts = [result for key, result in results.items() if key.startswith(case)]
            curves = [curve for part in parts for curve in part["curves"]]
            for curve in curves[:40]:
                axes.plot(*self._line(curve), color=colour, lw=0.7, alpha=0.3)
            axes.plot(*self._median(curves), color=colour, lw=2.4)
            axes.set_title(SEEN[case])
            axes.set_xlabel("samples" if self.learner == "pool" else "iterations")
            if self.learner != "pool":
                axes.set_xscale("log")
                axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))
                axes.xaxis.set_minor_locator(NullLocator())
            log_scale(axes, "mm")
        panels[0].set_ylabel("error of limb positions")
        return figure

    def _line(self, curve: Sequence[float]) -> tuple[Array, Array]:
        """Samples, and the error in mm."""
        ends = np.arange(1.0, len(curve) + 1)
        if self.learner != "pool":
            ends = bin_ends(self.most)[: len(curve)].astype(np.float64)
        # A logarithmic axis has no place for a body that is exactly right.
        return ends, np.maximum(1000 * np.array(curve), 1e-3)

    def _median(self, curves: Sequence[Sequence[float]]) -> tuple[Array, Array]:
        """The same of the median over runs; a run that has ended stays where it was."""
        samples, _ = self._line(max(curves, key=len))
        lines = [self._line(curve)[1] for curve in curves]
        padded = [np.append(line, [line[-1]] * (len(samples) - len(line))) for line in lines]
        return samples, np.asarray(np.median(padded, axis=0))


def _json(curve: Array) -> list[float]:
    """Mean over the markers that were seen, until the run ended."""
    lived = curve[np.isfinite(curve).any(axis=1)]
    return [float(f"{value:.4g}") for value in np.nanmean(lived, axis=1)]


def _count(samples: float | None) -> str:
    return "-" if samples is None else f"{samples:,.0f}"
