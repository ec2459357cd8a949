"""Vicente et al. 2016, section 3.1: what is learned here, how right is it there?

The arm is wrong in its joints. Said as joint offsets (Eq. 3) the error is one vector wherever the
hand is; said as a transform at the hand (Eq. 4) it is another one in every posture. The filter
learns both from the same images of the hand in one half of the room, left or right of the middle;
then the estimate stands still and the pose of the hand is predicted in both halves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.published.body_errors import BodyError, CartesianError, JointOffsets
from bodyschema.learners.published.particle_filter import ParticleFilter
from bodyschema.model.kinematics import relative_pose
from bodyschema.report.figure import AFTER, BEFORE
from bodyschema.simulation import icub
from bodyschema.simulation.seeing_icub import SeeingIcub
from bodyschema.studies.hand_methods import check_particles
from bodyschema.studies.hand_movements import true_offsets, visible_postures
from bodyschema.studies.hand_summary import mean_and_sd, text
from bodyschema.studies.study import Result, Rows, Task
from bodyschema.studies.watched_hand import believed, distance

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

ERRORS: dict[str, BodyError] = {
    "joint offsets": JointOffsets(icub.RIGHT_ARM),
    "Cartesian error": CartesianError(icub.HAND),
}
PLACES = ("same half", "other half")
DRAWS = 8000
"""Random arms of which the postures are taken; about 200 show the hand."""
TESTED = 50
"""Postures of each half in which predictions are tested; none of them is learned from."""


@dataclass(frozen=True)
class Generalisation:
    """Joint offsets against a Cartesian error, learned in one half of the room, tested in both."""

    paper: ClassVar[str] = "vicente2016"
    figure: ClassVar[str] = "generalisation"

    runs: int = 10
    """Times that it is learned, in the left half and in the right by turns."""
    seed: int = 0
    """The same seed gives the same results."""
    particles: int = 200
    """Hypotheses."""
    frames: int = 120
    """Images that are learned from."""

    def __post_init__(self) -> None:
        check_particles(self.particles)

    def tasks(self) -> Sequence[Task]:
        """One time, both ways of saying it."""
        return [Task(f"run {i}", {"run": i}) for i in range(self.runs)]

    def work(self, task: Task) -> Result:
        """Mean errors in mm and degrees by what was learned and where it is tested."""
        run = task.settings["run"]
        rng = np.random.default_rng([self.seed, run])
        halves = _halves()
        here, there = halves[run % 2], halves[1 - run % 2]
        learned = here[rng.integers(TESTED, len(here), size=self.frames)]
        estimates = self._learn(learned, int(rng.integers(2**31)))
        nothing = {"no adaptation": (ERRORS["joint offsets"], np.zeros(7))}
        return {
            name: {
                place: _errors(error, beta, q[:TESTED]).mean(axis=0).tolist()
                for place, q in zip(PLACES, (here, there), strict=True)
            }
            for name, (error, beta) in (nothing | estimates).items()
        }

    def _learn(self, postures: Array, seed: int) -> dict[str, tuple[BodyError, Array]]:
        """The last estimates, from the same images."""
        robot, mine = SeeingIcub(true_offsets()), believed("identical")
        learner = ParticleFilter(mine.surface, particles=self.particles, seed=seed)
        states = {name: learner.start_from(mine.body, error) for name, error in ERRORS.items()}
        found = {}
        for q in postures:
            robot.command(q)
            seen = robot.look()
            for name, state in states.items():
                states[name], (info,) = learner.step(state, (seen,))
                found[name] = (ERRORS[name], info.offsets)
        return found

    def summary(self, results: Mapping[str, Result]) -> Result:
        """Mean and standard deviation over runs."""
        return {
            "runs": self.runs,
            "particles": self.particles,
            "errors": {
                name: {
                    place: mean_and_sd([result[name][place] for result in results.values()])
                    for place in PLACES
                }
                for name in ("no adaptation", *ERRORS)
            },
        }

    def rows(self, summary: Mapping[str, Any]) -> Rows:
        """One row a way of saying it."""
        rows = [
            [name, *(text(found[place], unit) for unit in ("mm", "deg") for place in PLACES)]
            for name, found in summary["errors"].items()
        ]
        head = ["learned", *(f"{unit}, {place}" for unit in ("mm", "deg") for place in PLACES)]
        notes = [
            f"{self.runs} runs of {self.frames} images and {self.particles} particles; mean ± SD "
            f"over runs of the mean error in {TESTED} postures that were not learned from.",
            "The paper says that joint offsets generalise better and gives no figure.",
        ]
        return Rows(head, rows, notes)

    def draw(self, summary: Mapping[str, Any], results: Mapping[str, Result]) -> Figure:
        """Bars, position and orientation."""
        from matplotlib.figure import Figure

        figure = Figure(figsize=(10, 4), layout="constrained")
        names = list(summary["errors"])
        for axes, value in zip(
            figure.subplots(1, 2), ("position_mm", "orientation_deg"), strict=True
        ):
            for i, (place, colour) in enumerate(zip(PLACES, (AFTER, BEFORE), strict=True)):
                bars = [summary["errors"][name][place][value] for name in names]
                at = np.arange(len(names)) + 0.4 * i - 0.2
                axes.bar(
                    at, [b["mean"] for b in bars], 0.4, yerr=[b["sd"] for b in bars],
                    color=colour, label=place,
                )  # fmt: skip
            axes.set_xticks(range(len(names)), names)
            axes.set_ylabel(value.replace("_", ", "))
            axes.legend(frameon=False)
        return figure


def _halves() -> tuple[Array, Array]:
    """Postures with the hand left and right of the middle of those that show it."""
    q = visible_postures(DRAWS, 0)
    across = relative_pose(icub.nominal_icub(), q, icub.LEFT_EYE, icub.HAND)[:, 0, 3]
    left = across < np.median(across)
    return q[left], q[~left]


def _errors(error: BodyError, beta: Array, q: Array) -> Array:
    """Errors of the predicted hand in every posture, (n, 2) mm and degrees."""
    body, truth = icub.nominal_icub(), JointOffsets(icub.RIGHT_ARM)
    offsets = np.array([list(true_offsets().values())])
    eye, hand = icub.LEFT_EYE, icub.HAND
    real = [truth.hand_poses(body, posture, offsets, eye, hand)[0] for posture in q]
    said = [error.hand_poses(body, posture, beta[None], eye, hand)[0] for posture in q]
    return distance(np.array(real), np.array(said))
