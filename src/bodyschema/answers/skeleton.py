"""A robot that nobody has measured: the skeleton is learned from an arrangement and a recording.

1. `pool` finds axes and links that explain the samples, from nothing, in one pass over them.
2. `batch` refines them on all samples, robustly, with noise levels and covariance.

Priors are wide: 1 rad for an axis, the reach of what was seen for a link. What no motion can tell,
such as where on its axis a joint lies, is chosen so that links are short, and is named, not counted
as an error: it changes nothing of what is seen. What the learned body predicts is compared with
markers that stand still, each at the place that suits its samples best; a skeleton whose held-out
error is not far below theirs is not known.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.answers.answer import Answer
from bodyschema.errors import InputError
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.problem import Problem, Senses, check_problem, moved_joints
from bodyschema.judging.calibration import Calibration, Verdict
from bodyschema.judging.judgement import judged
from bodyschema.judging.one_pass import GRADIENT_STEP, Fitting, LearnerName, fit_at, pooled
from bodyschema.learners.learner import run
from bodyschema.learners.published.online_gradient import OnlineGradient, from_nothing
from bodyschema.learners.skeletons.shortest_links import with_shortest_links
from bodyschema.model.kernels import AXIS, FIXED
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, join
from bodyschema.senses.points import Points
from bodyschema.senses.sense import Sense
from bodyschema.threads import one_thread

Array = NDArray[np.float64]
SKELETON = ("axes", "links")

AXIS_STD = 1.0
"""rad, of each tangent component."""

KNOWN = 0.1
"""Share of the standing markers' held-out error below which a skeleton counts as learned."""


@dataclass(frozen=True)
class SkeletonProblem(Problem):
    """`body` is an arrangement: its links and axes mean nothing yet."""

    seed: int = 0
    """Of the search."""

    @property
    def reach(self) -> float:
        """m: how far the farthest marker goes from its middle place, outliers apart."""
        spread = [
            np.quantile(np.linalg.norm(s.position - np.median(s.position, axis=0), axis=1), 0.95)
            for s in self.senses
            if isinstance(s, Points)
        ]
        return float(max(spread))

    def variables(self, groups: Sequence[str], roughly: bool = True) -> Variables:
        """Joint groups and places of the markers; without groups, of markers that stand still."""
        reach = self.reach
        markers = [free_frame(self.body, f, reach, None) for f in self._fixed(bool(groups))]
        joints = free_joints(self.body, groups, self.joints)
        std = np.where(joints.code == AXIS, AXIS_STD, reach)
        return join(joints.with_prior(std), *markers)

    def fit(self, variables: Variables, senses: Senses) -> Estimate:
        """Search, then refine; markers that stand still need no search."""
        if not (variables.code == AXIS).any():
            still = replace(self.body, kind=np.full_like(self.body.kind, FIXED))
            markers = {sense.seen for sense in senses}
            return Problem(still, self.senses, dict.fromkeys(markers, "no"), ()).fit(
                variables, senses
            )
        return self.learner.fit(self.found(variables, senses), variables, senses)

    def found(self, variables: Variables, senses: Senses) -> Body:
        """What the pool believes after one pass; of all that predict the same, the plainest."""
        body = pooled(self.body, variables, senses, self.seed)
        return with_shortest_links(body, variables, senses)

    def descended(self, variables: Variables, senses: Senses) -> Body:
        """Where the gradient comes to from nothing in one pass."""
        length = self.reach / len(self.joints)
        rng = np.random.default_rng(self.seed)
        begun = from_nothing(self.body, variables, length, rng)
        learner = OnlineGradient(GRADIENT_STEP, "normalised", length=length)
        [(state, _)] = deque(run(learner, learner.start(begun, variables), senses), maxlen=1)
        return state.body

    def _fixed(self, moving: bool) -> list[str]:
        """Markers, and the camera where a joint carries it: on the root it may stay at its zero."""
        body, looks = self.body, {sense.seen_from for sense in self.senses}
        frames = sorted({sense.seen for sense in self.senses})
        carried = [f for f in looks if moving and body.parent[body.frame_index(f)] > 0]
        return [f for f in [*frames, *carried] if body.kind[body.frame_index(f)] == FIXED]


@one_thread
def learn_skeleton(
    body: Body,
    senses: Sequence[Sense],
    folds: int = 5,
    seed: int = 0,
    progress: Callable[[str], None] = lambda text: None,
    learner: LearnerName = "batch",
    run: Mapping[str, Any] | None = None,
) -> Answer:
    """Learn where the joints of a robot are and how they turn, from what was seen of it alone.

    Args:
        body: the arrangement, see `Body.from_arrangement`; its links and axes play no part.
        senses: Points of its markers, all seen from one frame.
        folds: of the held-out test.
        seed: of folds and search.
        progress: told what is being done.
        learner: "batch" refines what the pool found; "pool" and "online-gradient" see each sample
            once.
        run: what was asked, to be kept with the answer.

    Returns:
        verdict "learned", or "refused" when held-out samples do not bear the skeleton out.

    Raises:
        InputError: another sense than Points, several frames that look, too few samples, or a
            learner that needs a body to begin with.
    """
    _check_senses(body, senses)
    problem = SkeletonProblem(body, tuple(senses), {}, moved_joints(body, senses), seed=seed)
    check_problem(problem, SKELETON, folds)
    fit = _fitting(problem, learner)
    found = judged(problem, fit, (SKELETON,), False, folds, seed, progress)
    verdict, explanation = _verdict(found)
    answer = Answer.of(
        found,
        senses,
        body,
        run,
        verdict=verdict,
        explanation=explanation,
        from_nothing=True,
        learner=learner,
    )
    return answer.believed(found.trust)


def _fitting(problem: SkeletonProblem, learner: LearnerName) -> Fitting:
    finders = {"pool": problem.found, "online-gradient": problem.descended}
    if learner == "batch":
        return problem.fit
    if learner not in finders:
        raise InputError(
            f"the learner '{learner}' needs a body to begin with; for a skeleton take batch, "
            f"{' or '.join(finders)}."
        )

    def fit(variables: Variables, senses: Senses) -> Estimate:
        body = finders[learner](variables, senses)
        return fit_at(problem, body, body, variables, senses)

    return fit


def _check_senses(body: Body, senses: Sequence[Sense]) -> None:
    for sense in senses:
        if not isinstance(sense, Points):
            raise InputError(
                f"{sense.label}: a skeleton is learned from points, not from "
                f"{type(sense).__name__.lower()}; give the positions alone."
            )
        if body.kind[body.frame_index(sense.seen)] != FIXED:
            raise InputError(
                f"'{sense.seen}' is no marker; name one under [markers] of the arrangement."
            )
    looks = sorted({sense.seen_from for sense in senses})
    if len(looks) > 1:
        raise InputError(
            f"markers are seen from {' and '.join(looks)}; how these are turned to each other is "
            "not in a skeleton, so give what one of them saw."
        )


def _verdict(found: Calibration) -> tuple[Verdict, str]:
    before, after = (1e3 * a.main[2].rms for a in (found.nominal, found.held_out))
    errors = f"{after:.2f} mm rms, against {before:.2f} for markers that stand still"
    if after > KNOWN * before:
        return "refused", (
            f"The skeleton is not known: the held-out error is {errors}. Record more postures, "
            "and wider ones; check the arrangement and the units of the joints."
        )
    return "learned", f"The skeleton is learned: the held-out error is {errors}."
