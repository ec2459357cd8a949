"""Calibrate: from a nominal body and what was seen of it to a corrected body and a verdict.

The models that a recording can afford are judged by held-out samples, see `judgement`: those of the
joint parameters that a user names, or from "only the frames" up to "offsets, axes and links". An
online learner, if one is asked for, fits in one pass, and so in every fold.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from bodyschema.answers.calibration import Calibration
from bodyschema.answers.judgement import judged
from bodyschema.answers.one_pass import LearnerName, fitting
from bodyschema.estimation.problem import Knowledge, Problem, check_problem, moved_joints
from bodyschema.model.tree import Body
from bodyschema.senses.sense import Sense

MODELS: tuple[tuple[str, ...], ...] = (
    (),
    ("offsets",),
    ("offsets", "axes"),
    ("offsets", "axes", "links"),
)
"""Parameter groups tried when the user names none, simple ones first."""

VECTORS: tuple[tuple[str, ...], ...] = ((), ("links",), ("axes", "links"))
"""The same for learners of a skeleton, which has axes and links and nothing else."""


def calibrate(
    body: Body,
    senses: Sequence[Sense],
    frames: Mapping[str, Knowledge],
    groups: Sequence[str] | None = None,
    joints: Sequence[str] | None = None,
    folds: int = 5,
    seed: int = 0,
    progress: Callable[[str], None] = lambda text: None,
    learner: LearnerName = "batch",
) -> Calibration:
    """Calibrate a body from what was seen of it.

    Args:
        body: nominal body with every camera, tracker and marker frame attached.
        senses: what was seen.
        frames: the fixed frames that are not known exactly, "roughly" or "no".
        groups: joint parameter groups to free ("offsets", "gears", "axes", "links"); chosen by
            held-out accuracy when None.
        joints: joints that may be wrong; those between the frames of the senses when None.
        folds: of the held-out test.
        seed: of the folds.
        progress: told what is being done.
        learner: "batch", all samples at once; or an online learner, in one pass.

    Raises:
        InputError: the recording cannot answer the question; see `problem.check_problem`. Or the
            learner cannot learn what is to be freed.
    """
    problem = Problem(body, tuple(senses), frames, tuple(joints or moved_joints(body, senses)))
    check_problem(problem, groups if groups is not None else (), folds)
    affordable = _affordable(problem, models_of(learner), folds)
    models = affordable if groups is None else ((), tuple(groups))
    fit = fitting(problem, learner)
    found = judged(problem, fit, models, groups is None, folds, seed, progress)
    return replace(found, learner=learner)


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
