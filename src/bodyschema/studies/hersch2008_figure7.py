"""Hersch et al. 2008, Fig. 7 right: two limbs that touch each other learn both arms."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.published.online_gradient import OnlineGradient, from_nothing
from bodyschema.learners.skeletons.samples import SkeletonSamples
from bodyschema.model.skeleton import Skeleton
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_skeleton
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.studies.touching_arms import LINK, touches, two_arms

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

SKINS = (0.03, 0.1, 0.2)
"""m: how far from the hands' origins the limbs feel."""
STARTS = ("nothing", "rough")
LEAST = 1e-3
"""mm: the foot of the picture."""
ROUGH = (0.3, 0.03)
"""rad and m: how wrong each coordinate of an axis and of a link is in a rough body."""
FRESH = 300
"""Touches that are kept for the test."""
LEARNED = 0.01
"""m: 95 % of the fresh touches are predicted within this."""


@dataclass(frozen=True)
class Figure7:
    """Two arms learn by touching each other, nothing is seen: from nothing, and from a rough body.

    The paper describes tactile learning and shows no result. How large the skin is decides.
    """

    paper: ClassVar[str] = "hersch2008"
    figure: ClassVar[str] = "figure7"

    runs: int = 40
    """Random pairs of arms for each size of the skin and each kind of start."""
    seed: int = 0
    """The same seed gives the same results."""
    samples: int = 60_000
    """Gradient steps; the touches are gone through again and again."""
    epsilon: float = 1.0
    """mu of the normalised step."""

    def tasks(self) -> Sequence[Task]:
        """One for each pair of arms and each size of the skin."""
        return [
            Task(f"{skin:g} m, run {run}", {"skin": skin, "run": run})
            for skin in SKINS
            for run in range(self.runs)
        ]

    def work(self, task: Task) -> Result:
        """95 % of the fresh touches are within this, m, for each kind of start."""
        skin, run = task.settings["skin"], task.settings["run"]
        rng = np.random.default_rng([self.seed, SKINS.index(skin), run])
        truth = two_arms(rng)
        felt = touches(truth, skin, 2000, rng)
        few = min(FRESH, len(felt))
        shown, fresh = felt.take(range(few, len(felt))), felt.take(range(few))
        if not len(shown):
            return {"touches": 0, **dict.fromkeys(STARTS)}
        found: Result = {"touches": len(shown)}
        starts = (from_nothing(truth, free_skeleton(truth), LINK, rng), rough(truth, rng))
        for name, start in zip(STARTS, starts, strict=True):
            learner = OnlineGradient(self.epsilon, "normalised", length=LINK)
            state = learner.start(start, free_skeleton(start))
            seen = SkeletonSamples.of(shown, start, state.R0)
            while state.steps < self.samples:
                state, _ = learner.descend(state, seen)
            missed = np.linalg.norm(fresh.residual(state.body), axis=1)
            found[name] = float(np.percentile(missed, 95))
        return found

    def summary(self, results: Mapping[str, Result]) -> Result:
        """How many learned, by size of the skin and start."""
        return {"runs": self.runs, "skins": {str(skin): _found(skin, results) for skin in SKINS}}

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """One row a size of the skin."""
        rows = [
            [f"{100 * float(skin):.0f} cm", *(f"{of[s]} of {of['pairs']}" for s in STARTS)]
            for skin, of in summary["skins"].items()
        ]
        notes = [
            f"Learned: 95 % of {FRESH} fresh touches are predicted within {100 * LEARNED:.0f} cm, "
            f"after {self.samples:,} steps over up to 1700 touches. Pairs of arms that can "
            "hardly touch each other are not counted.",
            "From nothing, a body of no size explains the touches of two small finger tips almost "
            "as well as the true one: the skin must be large.",
            f"Rough: axes off by {ROUGH[0]:g} and links by {ROUGH[1]:g} m a coordinate.",
        ]
        return Rows(["skin", "learned from nothing", "from a rough body"], rows, notes)

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Error of each run, sorted."""
        from matplotlib.figure import Figure

        from bodyschema.report.figure import AFTER, BEFORE, log_scale

        figure = Figure(figsize=(9, 3.6), layout="constrained")
        panels = figure.subplots(1, len(SKINS), sharey=True)
        for panel, skin in zip(panels, SKINS, strict=True):
            for start, colour in zip(STARTS, (BEFORE, AFTER), strict=True):
                missed = [r[start] for r in _counted(skin, results)]
                share = np.linspace(0, 100, len(missed) + 1)[1:]
                panel.plot(share, np.maximum(1000 * np.sort(missed), LEAST), "o-", ms=3,
                           color=colour, label=f"from {start}")  # fmt: skip
            panel.set(title=f"skin of {100 * skin:.0f} cm", xlabel="% of runs")
            log_scale(panel, "mm")
        panels[0].set_ylabel("95 % of fresh touches within")
        panels[-1].legend()
        return figure


def rough(body: Body, rng: np.random.Generator) -> Body:
    """The body with all axes and links somewhat wrong."""
    old = Skeleton.of(body)
    axes = old.axes + ROUGH[0] * rng.normal(size=old.axes.shape)
    links = old.links + ROUGH[1] * rng.normal(size=old.links.shape)
    return replace(old, axes=axes / np.linalg.norm(axes, axis=1)[:, None], links=links).into(body)


def _counted(skin: float, results: Mapping[str, Result]) -> list[Result]:
    """Runs with enough touches."""
    parts = [part for key, part in results.items() if key.startswith(f"{skin:g} m")]
    return [part for part in parts if part["touches"] >= FRESH]


def _found(skin: float, results: Mapping[str, Result]) -> Result:
    parts = _counted(skin, results)
    learned = {start: sum(part[start] < LEARNED for part in parts) for start in STARTS}
    return {"pairs": len(parts), **learned}
