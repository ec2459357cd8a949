"""Hersch et al. 2008, Fig. 11 (and 8): the real skeleton beside those that a robot has learned."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.determinable import determinable
from bodyschema.learners.skeletons.shortest_links import with_shortest_links
from bodyschema.model.skeleton import Skeleton
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_skeleton
from bodyschema.report.skeleton_picture import draw_skeleton, frame_view, places
from bodyschema.simulation.humanoid import BETWEEN, ENDS, EYE, humanoid, icub_humanoid
from bodyschema.studies.gradient_trees import gradient_tree_run
from bodyschema.studies.schema_comparison import compare
from bodyschema.studies.self_watching import CASES, FRESH, SelfWatching
from bodyschema.studies.study import Result, Rows, Task

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

EXACT = 1e-3
"""Share of a path's length to which the pool learns it; the gradient stops at ten times that."""

STICK = 0.05
"""m, of the drawn axes."""

KNEELING = {
    "humanoid": {
        "knee": 90, "elbow": -50, "shoulder_pitch": 60, "shoulder_roll": 20, "ankle_pitch": 30,
    },
    "icub": {"knee": -90, "elbow": 60, "shoulder_pitch": -20, "shoulder_roll": 25},
}  # fmt: skip
"""deg, of both sides; the humanoid's right shoulder rolls the other way."""

VIEW = {"humanoid": -38.0, "icub": 142.0}
"""deg: azimuth from which each robot shows its face; iCub's root looks backwards."""

TITLES = {"ends": "saw its hands and feet", "alternating": "saw joints between, too"}


@dataclass(frozen=True)
class Figure11:
    """Real and learned skeletons side by side: which parts of a body its own eyes can determine.

    Cases as in figure10. What the robot expects to see is right in both; where on its axis a joint
    lies is open for all joints in the first case and for most in the second.
    """

    paper: ClassVar[str] = "hersch2008"
    figure: ClassVar[str] = "figure11"

    learner: Literal["online-gradient", "pool"] = "pool"
    """Gradient descent as published, or a pool of hypotheses."""
    robot: Literal["humanoid", "icub"] = "humanoid"
    """24 joints with the dimensions of HOAP-3, or the 32 joints of iCub (needs icub-models)."""
    runs: int = 4
    """Repetitions of each case; the first is drawn."""
    seed: int = 0
    """The same seed gives the same results."""

    def tasks(self) -> Sequence[Task]:
        """One run of one case each."""
        return [
            Task(f"{case}_{run}", {"case": case, "run": run})
            for case in CASES
            for run in range(self.runs)
        ]

    def watching(self, case: str) -> SelfWatching:
        """The robot and what it sees."""
        body = humanoid() if self.robot == "humanoid" else icub_humanoid()
        return SelfWatching(body, CASES[case])

    def work(self, task: Task) -> Result:
        """Learn, take the plainest of the bodies that cannot be told apart, compare both."""
        case = task.settings["case"]
        watching = self.watching(case)
        rng = np.random.default_rng([self.seed, list(CASES).index(case), task.settings["run"]])
        if self.learner == "pool":
            from bodyschema.studies.pool_trees import pool_tree_run

            pooled = pool_tree_run(watching, EXACT, 60, rng)
            learned, failed = pooled.body, pooled.samples is None
        else:
            descended = gradient_tree_run(watching, 0.05, 10 * EXACT, 1_000_000, rng)
            learned, failed = descended.body, descended.iterations is None
        plain = with_shortest_links(learned, free_skeleton(learned), watching.looks())
        q = watching.postures(FRESH, rng)
        return {"failed": failed} | {
            name: {"skeleton": _stored(body), **asdict(compare(watching, body, q))}
            for name, body in (("learned", learned), ("shortest", plain))
        }

    def summary(self, results: Mapping[str, Result]) -> Result:
        """For each case, medians over the runs and what could be determined at all."""
        return {"robot": self.robot, "learner": self.learner, "runs": self.runs} | {
            case: self._case(case, results) for case in CASES
        }

    def _case(self, case: str, results: Mapping[str, Result]) -> Result:
        watching = self.watching(case)
        told = determinable(watching.body, free_skeleton(watching.body), watching.looks())
        runs = [result for key, result in results.items() if key.startswith(case)]
        found: Result = {
            "identifiable": told.rank,
            "parameters": told.variables,
            "open": [d.sentence.partition(":")[0] for d in told.directions],
            "failed": sum(run["failed"] for run in runs),
        }
        for name in ("learned", "shortest"):
            keys = [key for key in runs[0][name] if key != "skeleton"]
            found[name] = {key: float(np.median([run[name][key] for run in runs])) for key in keys}
        return found

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """Two rows a case: as learned, and with the shortest links."""
        rows = []
        for case, saw in (("ends", "hands, feet"), ("alternating", "joints too")):
            of = summary[case]
            for name, links in (("learned", "as learned"), ("shortest", "shortest")):
                off = [_mm(of[name][key]) for key in ("prediction", "lines", "centres_mean")]
                told = f"{of['identifiable']} of {of['parameters']}"
                rows.append([saw, links, told, str(of["failed"]), *off])
        head = ["saw", "links", "identifiable", "failed", "expects", "axes", "centres"]
        return Rows(head, rows, [
            "Errors, median over the runs. Expects: the largest of where markers are expected. "
            "Axes: the largest distance of a joint's real centre from its learned axis. Centres: "
            "the mean distance of a joint's centre from the real one.",
            "Failed: runs that still expected wrongly when they were stopped. In all others what "
            "is expected to be seen is right, though the inner geometry is not: centres slide "
            "along their axes, and the pelvis may lie anywhere.",
            "The paper says that the second case leaves no ambiguity. That holds for the joints "
            "whose own centre is seen; the others slide still, and short links bring most back.",
        ])  # fmt: skip

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Real and learned skeletons in one posture, joint axes as dark sticks."""
        from matplotlib.figure import Figure

        from bodyschema.report.figure import AFTER, BEFORE, GREY, INK

        real = self.watching("ends").body
        q = self._kneeling(real)
        everything: tuple[str, ...] = (*ENDS, *BETWEEN)
        panels = [("real", "", real, GREY, everything)]
        for case, colour, markers in zip(CASES, (AFTER, BEFORE), (ENDS, everything), strict=True):
            result = results[f"{case}_0"]
            for name, words in (("learned", "as learned"), ("shortest", "with shortest links")):
                body = _restored(result[name]["skeleton"], real)
                says = f"{words};\nerror of what it expects: {_mm(result[name]['prediction'])}"
                panels.append((TITLES[case], says, body, colour, markers))
        figure = Figure(figsize=(15, 4.2))
        corners = places(real, q, EYE)[0]
        for place, (title, says, body, colour, markers) in enumerate(panels):
            axes = figure.add_axes((place / 5 - 0.012, -0.04, 0.2, 0.88), projection="3d")
            draw_skeleton(axes, body, q, EYE, markers, colour, STICK)
            frame_view(axes, corners, 10.0, VIEW[self.robot])
            figure.text((place + 0.06) / 5, 0.93, title, weight="bold", color=colour)
            figure.text((place + 0.06) / 5, 0.9, says, color=INK, size=10, va="top")
        return figure

    def _kneeling(self, body: Body) -> Array:
        """(n_joints,) the posture that is drawn, rad."""
        bent = KNEELING[self.robot]
        angles = np.array([bent.get(joint[2:], 0.0) for joint in body.joints])
        if self.robot == "humanoid":
            angles[body.joint_index("r_shoulder_roll")] *= -1
        return np.asarray(np.deg2rad(angles))


def _mm(metres: float) -> str:
    """Two digits, or whole millimetres."""
    if metres < 1e-6:
        return "< 0.001 mm"
    return f"{1e3 * metres:.2g} mm" if metres < 0.01 else f"{1e3 * metres:.0f} mm"


def _stored(body: Body) -> Result:
    """A skeleton as JSON."""
    skeleton = Skeleton.of(body)
    return {"axes": skeleton.axes.tolist(), "links": skeleton.links.tolist()}


def _restored(stored: Mapping[str, Any], like: Body) -> Body:
    """The body of a stored skeleton."""
    axes, links = (np.array(stored[name]) for name in ("axes", "links"))
    return Skeleton(like.parent, like.kind, axes, links).into(like)
