"""Calibrate: from a nominal body and what was seen of it to a corrected body and a verdict.

The models that a recording can afford are judged by held-out samples, see `judgement`: those of the
joint parameters that a user names, or from "only the frames" up to "offsets, axes and links". An
online learner, if one is asked for, fits in one pass, and so in every fold. Before and after, the
recording itself is looked at, see `lookout`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bodyschema.answers.answer import Answer
from bodyschema.answers.board_size import wrong_sizes
from bodyschema.answers.lookout import Lookout, far_zeros, with_zeros
from bodyschema.answers.rolling_shutter import rolling_shutters
from bodyschema.errors import InputError, did_you_mean
from bodyschema.estimation.problem import Knowledge, Problem, check_problem, moved_joints
from bodyschema.judging.calibration import Calibration
from bodyschema.judging.judgement import judged
from bodyschema.judging.one_pass import LearnerName, fitting
from bodyschema.model.limits import with_recorded_limits
from bodyschema.model.tree import Body
from bodyschema.senses.sense import Sense
from bodyschema.threads import one_thread
from bodyschema.units import listed

KNOWN = ("roughly", "no")
"""What may be known of a frame that is to be found."""

MODELS: tuple[tuple[str, ...], ...] = (
    (),
    ("offsets",),
    ("offsets", "axes"),
    ("offsets", "axes", "links"),
)
"""Parameter groups tried when the user names none, simple ones first."""

VECTORS: tuple[tuple[str, ...], ...] = ((), ("links",), ("axes", "links"))
"""The same for learners of a skeleton, which has axes and links and nothing else."""


@one_thread
def calibrate(
    body: Body,
    senses: Sequence[Sense],
    frames: Mapping[str, Knowledge] | None = None,
    groups: Sequence[str] | None = None,
    joints: Sequence[str] | None = None,
    folds: int = 5,
    seed: int = 0,
    progress: Callable[[str], None] = lambda text: None,
    learner: LearnerName = "batch",
    parts: Mapping[str, Sequence[str] | None] | None = None,
    described: Body | None = None,
    run: Mapping[str, Any] | None = None,
    wanted: Sequence[tuple[str, str]] = (),
) -> Answer:
    """Calibrate a body from what was seen, touched and felt of it.

    Args:
        body: nominal body with every frame that the senses name, and every part.
        senses: what was observed, of any kinds in one list.
        frames: the fixed frames that are not known exactly, "roughly" or "no".
        groups: joint parameter groups to free ("offsets", "gears", "axes", "links"); chosen by
            held-out accuracy when None.
        joints: joints that may be wrong; those between the frames of the senses when None.
        folds: of the held-out test.
        seed: of the folds.
        progress: told what is being done.
        learner: "batch", all samples at once; or an online learner, in one pass.
        parts: parts of the body that are not known, and which of their numbers; None for all.
        described: the robot without the frames that were attached to it; the body when None.
        run: what was asked, to be kept with the answer.
        wanted: frames (seen from, seen) in which the robot is to be right; a correction that suits
            what was seen but does not tell these is refused. What was seen when empty.

    Raises:
        InputError: the recording cannot answer the question; see `problem.check_problem`. Or the
            learner cannot learn what is to be freed.
    """
    _check_asked(body, senses, frames or {})
    if senses:
        body = with_recorded_limits(body, np.concatenate([sense.q for sense in senses]))
    free = {name: None if some is None else tuple(some) for name, some in (parts or {}).items()}
    wrong = tuple(joints or moved_joints(body, senses, wanted))
    problem = Problem(body, tuple(senses), frames or {}, wrong, parts=free, wanted=tuple(wanted))
    check_problem(problem, groups if groups is not None else (), folds)
    affordable = _affordable(problem, models_of(learner), folds)
    models = affordable if groups is None else ((), tuple(groups))
    problem = _with_kept(problem, models[-1])
    progress("other declarations")
    look = Lookout.at(problem, run or {}, learner == "batch")
    if learner == "batch" and look.far_off:
        problem = with_zeros(problem, models, seed)

    def judge(problem: Problem) -> Calibration:
        fit = fitting(problem, learner)
        again = problem.again if learner == "batch" else None
        return judged(problem, fit, models, groups is None, folds, seed, progress, again)

    found = judge(problem)
    if learner == "batch" and not (found.fit.converged or look.far_off or look.named):
        searched = with_zeros(problem, models, seed)
        found = judge(searched) if searched.zeros else found
    nominal = replace(described or body, remarks=body.remarks)
    told = (*found.findings, *far_zeros(found), *wrong_sizes(found))
    told += rolling_shutters(found.fit, problem.senses)
    answer = Answer.of(found, problem.senses, nominal, run, learner=learner, findings=told)
    return answer.believed(look.trust(found, problem.senses))


def _check_asked(body: Body, senses: Sequence[Sense], frames: Mapping[str, str]) -> None:
    """Refuse knowledge that is none, and readings of another number of joints.

    Raises:
        InputError: in one sentence.
    """
    for frame, known in frames.items():
        if known not in KNOWN:
            hint = did_you_mean(str(known).lower(), KNOWN)
            raise InputError(f"frame '{frame}' cannot be known {known!r}{hint}")
    for sense in senses:
        if sense.q.ndim != 2 or sense.q.shape[1] != len(body.joints):
            raise InputError(
                f"{sense.label}: joint readings have the shape {sense.q.shape}, and "
                f"{body.name} has {len(body.joints)} joints ({listed(body.joints, 8)}); give a "
                "column for each, in that order."
            )


def _with_kept(problem: Problem, model: tuple[str, ...]) -> Problem:
    """The problem with correspondences that stay, as the largest model shows them.

    Models are compared on the same samples; outlines that each fit chose for itself are not.
    """
    if all(type(sense).kept is Sense.kept for sense in problem.senses):
        return problem
    body = problem.fit(problem.variables(model), problem.senses).body
    return replace(problem, senses=tuple(sense.kept(body) for sense in problem.senses))


def models_of(learner: LearnerName) -> tuple[tuple[str, ...], ...]:
    """The models that a learner can learn, simple ones first."""
    return VECTORS if learner in ("online-gradient", "pool") else MODELS


def _affordable(
    problem: Problem, models: Sequence[tuple[str, ...]], folds: int
) -> tuple[tuple[str, ...], ...]:
    """The models that have at least two numbers of training data for every parameter."""
    numbers = sum(len(s) * len(s.covariance) for s in problem.senses) * (folds - 1) / folds
    return tuple(
        model for model in models if not model or 2 * len(problem.variables(model)) <= numbers
    )
