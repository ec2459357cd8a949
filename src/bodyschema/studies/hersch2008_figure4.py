"""Hersch et al. 2008, Fig. 4: the axes of a chain wander over the sphere until they are right."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.published.online_gradient import OnlineGradient
from bodyschema.learners.skeletons.samples import SkeletonSamples
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_joints
from bodyschema.senses.touches import Touches
from bodyschema.studies.random_chains import (
    LONGEST,
    SHORTEST,
    chain_body,
    draw_chain,
    draw_untaught,
    run_generator,
)
from bodyschema.studies.study import Result, Rows, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

JOINTS = 3
CLOSE = 1.0
"""deg."""
EVERY = 5
"""Samples between two places of an axis that are kept."""


@dataclass(frozen=True)
class Figure4:
    """A chain of three joints learns from nothing; the paths of its estimated axes are drawn."""

    paper: ClassVar[str] = "hersch2008"
    figure: ClassVar[str] = "figure4"

    runs: int = 1
    """Random chains; the first is drawn."""
    seed: int = 0
    """The same seed gives the same results."""
    samples: int = 4000
    """Samples of a run."""
    reach_deg: float = 90.0
    """Joints are uniform within this either way."""
    epsilon: float = 0.03
    """Step, in squared mean links."""

    def tasks(self) -> Sequence[Task]:
        """A run each."""
        return [Task(f"run {run}", {"run": run}) for run in range(self.runs)]

    def work(self, task: Task) -> Result:
        """The true axes, and the estimated ones after every `EVERY` samples."""
        rng = run_generator(self.seed, JOINTS, task.settings["run"])
        truth, start = _drawn(rng, draw_chain), _drawn(rng, draw_untaught)
        learner = OnlineGradient(self.epsilon, length=1.0)
        state = learner.start(start, free_joints(start, ("axes", "links")))
        places = [state.body.axis[1:-1].tolist()]
        for _ in range(self.samples // EVERY):
            seen = self._shown(truth, rng)
            state, _ = learner.descend(state, SkeletonSamples.of(seen, start, state.R0))
            places.append(state.body.axis[1:-1].tolist())
        return {"true": truth.axis[1:-1].tolist(), "learned": places}

    def _shown(self, truth: Body, rng: np.random.Generator) -> Touches:
        """Known points of the last segment, another at each sample, seen from the base."""
        last = truth.frames[-2]
        reach = np.deg2rad(self.reach_deg)
        q, v = rng.uniform(-reach, reach, (EVERY, JOINTS)), rng.normal(size=(EVERY, 3))
        far = rng.uniform(SHORTEST, LONGEST, (EVERY, 1))
        v *= far / np.linalg.norm(v, axis=1, keepdims=True)
        return Touches.make(q, np.zeros((EVERY, 3)), v, truth.frames[0], last).imagined(truth, q)

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Angles to the true axes in the first run; samples until all stay close, in all runs."""
        apart = [angles(result) for result in results.values()]
        until = [_until(one) for one in apart]
        found = [samples for samples in until if samples is not None]
        return {
            "runs": self.runs,
            "not_converged": len(until) - len(found),
            "samples_median": float(np.median(found)) if found else None,
            "axes": [
                {"start_deg": round(float(axis[0]), 2), "end_deg": round(float(axis[-1]), 4)}
                for axis in apart[0].T
            ],
        }

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """One row an axis."""
        rows = [
            [f"axis {i + 1}", f"{axis['start_deg']:.0f} deg", f"{axis['end_deg']:.3f} deg"]
            for i, axis in enumerate(summary["axes"])
        ]
        late = summary["not_converged"]
        close = "-" if summary["samples_median"] is None else f"{summary['samples_median']:,.0f}"
        notes = [
            f"Angle to the true axis in the first run, {self.samples:,} samples.",
            f"All axes within {CLOSE:g} deg for good after {close} samples (median); "
            f"{late} of {self.runs} runs did not come so far.",
            "The end point in the last segment is known and another at each sample, as in figure3. "
            "The paper shows one run and gives no numbers.",
        ]
        return Rows(["", "at first", "at last"], rows, notes)

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """A sphere an axis: its path, where it began, and the true axis as a diamond."""
        from matplotlib.figure import Figure

        first = next(iter(results.values()))
        true, learned = np.array(first["true"]), np.array(first["learned"])
        figure = Figure(figsize=(10, 3.8), layout="constrained")
        for i in range(JOINTS):
            panel: Any = figure.add_subplot(1, JOINTS, i + 1, projection="3d")
            _paint(panel, true[i], learned[:, i])
            panel.set_title(f"axis {i + 1}")
        return figure


def angles(result: Result) -> Array:
    """deg between each estimated axis and the true one, (places, joints)."""
    true, learned = np.array(result["true"]), np.array(result["learned"])
    across = np.linalg.norm(np.cross(learned, true), axis=2)
    return np.asarray(np.rad2deg(np.arctan2(across, np.sum(learned * true, axis=2))))


def _until(apart: Array) -> int | None:
    """Samples after which all axes stay close; None if they do not at the end."""
    far = np.flatnonzero((apart > CLOSE).any(axis=1))
    if len(far) and far[-1] == len(apart) - 1:
        return None
    return EVERY * int(far[-1] + 1) if len(far) else 0


def _drawn(rng: np.random.Generator, draw: Any) -> Body:
    axes, links = np.empty((JOINTS + 2, 3)), np.empty((JOINTS + 2, 3))
    draw(rng, axes, links)
    return chain_body(axes, links)


def _paint(panel: Any, true: Array, path: Array) -> None:
    from bodyschema.report.figure import AFTER, BEFORE, GREY

    u, w = np.meshgrid(np.linspace(0, 2 * np.pi, 25), np.linspace(0, np.pi, 13))
    sphere = (np.cos(u) * np.sin(w), np.sin(u) * np.sin(w), np.cos(w))
    panel.plot_wireframe(*sphere, color=GREY, lw=0.3, alpha=0.5)
    panel.plot(*path.T, color=AFTER, lw=1.8)
    panel.scatter(*path[0], color=AFTER, s=30)
    panel.scatter(*true, color=BEFORE, marker="D", s=60)
    middle = true + path[0]
    panel.view_init(
        elev=np.rad2deg(np.arctan2(middle[2], np.hypot(middle[0], middle[1]))),
        azim=np.rad2deg(np.arctan2(middle[1], middle[0])),
    )
    panel.set_box_aspect((1, 1, 1), zoom=1.5)
    panel.set_axis_off()
