"""A calibration problem: which frames are unknown, which joints may be wrong, what was seen.

It refuses what cannot be calibrated before any time is spent, and makes a fit of any model.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.solver import Solver
from bodyschema.model.kernels import PRISMATIC
from bodyschema.model.kinematics import path_between
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, free_part, join
from bodyschema.seeds.starts import start_frames
from bodyschema.senses.sense import PLACEMENT, Sense
from bodyschema.threads import one_thread

Array = NDArray[np.float64]
Senses = Sequence[Sense]
Knowledge = Literal["roughly", "no"]

ROUGHLY = (0.03, 0.2)
"""m and rad: prior of a frame that is known roughly."""

LEAST_MOTION = 1e-3
"""rad or m: a recording in which no joint spreads more than this shows one posture."""

TURNS_PLAUSIBLE = 3.0
"""A revolute reading beyond this many turns, or this far beyond its limits in rad, is no radian."""


@dataclass(frozen=True)
class Problem:
    """What is to be calibrated, and with what."""

    body: Body
    """Nominal body with every frame attached."""
    senses: tuple[Sense, ...]
    frames: Mapping[str, Knowledge]
    """Fixed frames that are free: known "roughly" (their placement is a start) or not at all."""
    joints: tuple[str, ...]
    """Joints that may be wrong."""
    learner: Solver = Solver()  # noqa: RUF009  (frozen settings)

    parts: Mapping[str, tuple[str, ...] | None] = field(default_factory=dict)
    """Parts of the body that are free in every model, and which of their numbers; None for all."""
    wanted: tuple[tuple[str, str], ...] = ()
    """Frames (seen from, seen) in which the robot is to be right; what was seen when empty."""
    zeros: Mapping[str, float] = field(default_factory=dict)
    """rad, where the offsets of these joints begin, found by a search. Their prior is that wide."""

    @property
    def unknown(self) -> tuple[str, ...]:
        """Frames without a first value."""
        return tuple(frame for frame, known in self.frames.items() if known == "no")

    def variables(self, groups: Sequence[str], roughly: bool = True) -> Variables:
        """The variables of a model: joint groups, unknown frames and parts, and what is known
        roughly."""
        free = [free_joints(self.body, groups, self.joints)]
        for frame, known in self.frames.items():
            seen = self._shown(frame)
            if known == "no":
                free.append(free_frame(self.body, frame, only=seen))
            elif roughly:
                free.append(free_frame(self.body, frame, *ROUGHLY, only=seen))
        free += [free_part(self.body, part, some) for part, some in self.parts.items()]
        variables = join(*free)
        begin = np.abs(self._first(variables))
        prior, bound = np.maximum(variables.prior_std, begin), variables.bound
        # A zero of nearly half a turn may be one of a little more.
        bound = np.where(begin > 0, np.maximum(bound, begin + np.pi / 2), bound)
        return replace(variables, prior_std=prior, bound=bound)

    @cached_property
    def begun(self) -> Body:
        """The body with the unknown frames and the free parts where all samples say, roughly."""
        return start_frames(self.body, (*self.unknown, *self.parts), self.senses)

    @one_thread
    def fit(self, variables: Variables, senses: Senses) -> Estimate:
        """Place the unknown frames and begin the free parts by closed form, then fit.

        Joints begin at the zeros that a search has found, where their offsets are free.
        """
        x = self._first(variables)
        if x.any():
            return self._from_zeros(variables, senses, x)
        if senses is self.senses:
            return self.learner.fit(self.begun, variables, senses)
        body = start_frames(self.body, (*self.unknown, *self.parts), senses)
        return self.learner.fit(body, variables, senses)

    def _first(self, variables: Variables) -> Array:
        """Where the variables begin, (n_parameters,): the zeros found, else as modelled."""
        known = {f"{joint}.offset": zero for joint, zero in self.zeros.items()}
        return np.array([known.get(name, 0.0) for name in variables.names])

    def _from_zeros(self, variables: Variables, senses: Senses, x: Array) -> Estimate:
        """A fit that begins at other zeros, frames placed for them; its reference has none."""
        turned = self.body.with_variables(variables, x)
        placed = start_frames(turned, (*self.unknown, *self.parts), senses)
        return self.learner.fit(replace(placed, offset=self.body.offset), variables, senses, x)

    def again(self, whole: Estimate, senses: Senses) -> Estimate:
        """Fit a part of the samples, beginning where all of them have led."""
        start, levels = whole.x, whole.levels
        return self.learner.fit(whole.reference, whole.variables, senses, start, levels)

    def _shown(self, frame: str) -> frozenset[str]:
        """The components of a frame's placement on which anything seen depends."""
        node = self.body.frame_index(frame)
        if (self.body.parent == node).any():
            return frozenset(PLACEMENT)
        ends = [
            shown
            for sense in self.senses
            for pair in sense.pairs
            for end, shown in zip(pair, sense.shows, strict=True)
            if end == frame
        ]
        return frozenset(name for shown in ends for name in shown)


def moved_joints(
    body: Body, senses: Senses, wanted: Sequence[tuple[str, str]] = ()
) -> tuple[str, ...]:
    """Joints that lie between the ends of some sense, or between frames that are wanted right.

    Raises:
        InputError: the body has no such frame.
    """
    between = set()
    for a, b in (*(pair for sense in senses for pair in sense.pairs), *wanted):
        path, _ = path_between(body, a, b)
        between |= {int(body.driver[k]) for k in path if body.driver[k] >= 0}
    return tuple(body.joints[j] for j in sorted(between))


def check_problem(problem: Problem, groups: Sequence[str], folds: int) -> None:
    """Refuse a recording that cannot answer the question.

    Raises:
        InputError: no motion, readings in degrees, or fewer numbers than parameters.
    """
    if not problem.senses:
        raise InputError("nothing was seen: name at least one [[senses]] entry.")
    labels = [sense.label for sense in problem.senses]
    twice = sorted({label for label in labels if labels.count(label) > 1})
    if twice:
        raise InputError(f"two senses are '{twice[0]}'; join their rows, or attach another frame.")
    body = problem.body
    used = [body.joint_index(joint) for joint in moved_joints(body, problem.senses)]
    q = np.concatenate([sense.q for sense in problem.senses])[:, used]
    if not used or np.ptp(q, axis=0).max(initial=0.0) < LEAST_MOTION:
        raise InputError(
            "all samples show one posture: no joint between the frames moves by more than "
            f"{LEAST_MOTION:g} rad; record postures that spread over the workspace."
        )
    _check_radians(body, used, q)
    numbers = sum(len(sense) * len(sense.covariance) for sense in problem.senses)
    rows = len(np.unique(np.concatenate([sense.rows for sense in problem.senses])))
    needed = len(problem.variables(groups))
    if numbers * (folds - 1) / folds < needed or rows < folds:
        raise InputError(
            f"{rows} samples hold {numbers} numbers, too few for {needed} parameters in {folds} "
            f"folds; record at least {max(folds, 2 * needed * rows // max(numbers, 1))} postures, "
            "or free less."
        )


def _check_radians(body: Body, used: Sequence[int], q: Array) -> None:
    for column, joint in enumerate(used):
        nodes = np.flatnonzero(body.driver == joint)
        if (body.kind[nodes] == PRISMATIC).any():
            continue
        extreme = q[np.argmax(np.abs(q[:, column])), column]
        low, high = body.lower[joint], body.upper[joint]
        beyond = max(low - q[:, column].min(), q[:, column].max() - high)
        if abs(extreme) > TURNS_PLAUSIBLE * 2 * np.pi or beyond > TURNS_PLAUSIBLE:
            limits = f"its limits are {low:.2f} to {high:.2f} rad" if low > -np.inf else "no turn"
            share = low > -np.inf and np.abs(q).max() <= 100
            percent = ', or "percent" if its numbers are -100 to 100 of the limits' if share else ""
            raise InputError(
                f"joint '{body.joints[joint]}' reads {extreme:.1f} rad where {limits}; if the "
                'recording is in degrees, set [joints] unit = "deg" (or --joint-unit deg)'
                f"{percent}."
            )
