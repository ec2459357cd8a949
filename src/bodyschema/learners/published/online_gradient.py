"""Online gradient descent on joint axes and link vectors, from seen points alone.

    M. Hersch, E. Sauser, A. Billard (2008): Online learning of the body schema.
    International Journal of Humanoid Robotics 5(2), Eq. 5, 9, 14, 15.

Each sample is a posture and a point of one frame seen from another. With x' seen, x predicted and
e = x' - x, all free axes a and links l on the path between the two frames take one step down
E = 1/2 |e|^2, and axes are made unit vectors again: `gradient_step`. Time is linear in the length
of the path and memory is the body itself. Three rules for the size of the step, t samples seen:

    constant    eps
    decaying    eps / (1 + t / half_after)
    normalised  eps |e|^2 / |grad E|^2

Lengths count in units of L, a typical link, so eps has no unit; 0.03 is a good constant one.

The learner ends in a false minimum now and then (see `studies`), gives no covariance, and cannot
tell what it cannot know: for those questions take the pool, or `Filter` from a good body.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError, did_you_mean
from bodyschema.learners.learner import Moment, in_turn
from bodyschema.learners.published.gradient_step import descend_through
from bodyschema.learners.skeletons.samples import SkeletonSamples
from bodyschema.model.kernels import AXIS, LINK
from bodyschema.model.skeleton import Skeleton, zero_rotations
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Rule = Literal["constant", "decaying", "normalised"]

SMALL_LINK = 0.05
"""In L: standard deviation of each coordinate of a link that is begun from nothing."""


@dataclass(frozen=True)
class Guess:
    """State of the learner: a skeleton, and how to read samples with it. No covariance."""

    reference: Body
    """The body at the start; its frames keep their rotations, its encoders their corrections."""
    skeleton: Skeleton
    R0: Array
    """(n_frames, 3, 3) rotations of the frames at zero posture."""
    turns: Flags
    """(n_frames,) axes that are learned."""
    moves: Flags
    """(n_frames,) links that are learned."""
    length: float
    """L, m."""
    steps: int = 0
    """t, samples learned from."""

    @property
    def body(self) -> Body:
        """The body as believed now."""
        return self.skeleton.into(self.reference)


@dataclass(frozen=True)
class Miss:
    """What one sample said about the body before it was learned from."""

    residual: Array
    """(3,) seen minus predicted, m, in frame `seen_from`."""
    distance: float
    """Its length, m."""


@dataclass(frozen=True)
class OnlineGradient:
    """The paper's learner. Learns from `Points` and `Touches`; senses may alternate.

    Which axes and links adapt is what `variables` frees: `free_joints(body, ("axes", "links"))`
    for the whole arm, `free_frame(body, "tool", turn_std=None)` for the last segment alone. Priors
    and bounds play no part.
    """

    epsilon: float = 0.03
    """Step size; mu (0 to 2) of the normalised rule."""
    rule: Rule = "constant"
    half_after: float = 10_000.0
    """Samples after which the step of the decaying rule is half the first."""
    length: float | None = None
    """L, m, a typical link; the median link of the starting body when None."""

    def __post_init__(self) -> None:
        if self.rule not in get_args(Rule):
            raise InputError(f"no step rule '{self.rule}'{did_you_mean(self.rule, get_args(Rule))}")
        for name in ("epsilon", "half_after", "length"):
            value = getattr(self, name)
            if value is not None and not value > 0:
                raise InputError(f"{name} must be above zero, got {value}.")

    def start(self, body: Body, variables: Variables) -> Guess:
        """The guess before the first sample is the body itself; see `from_nothing`.

        Raises:
            InputError: a parameter is no axis and no link, a vector is free in part, or all links
                are zero and L is not given.
        """
        turns, moves = learnable(body, variables)
        skeleton = Skeleton.of(body)
        length = typical_link(skeleton) if self.length is None else self.length
        return Guess(body, skeleton, zero_rotations(body), turns, moves, length)

    def step(self, state: Guess, moment: Moment) -> tuple[Guess, tuple[Miss, ...]]:
        """Learn from one moment."""
        return in_turn(self._learn, state, moment)

    def _learn(self, state: Guess, sample: Sense) -> tuple[Guess, Miss]:
        """Learn from one sample (a batch of one)."""
        after, residual = self.descend(state, SkeletonSamples.of(sample, state.reference, state.R0))
        a = state.reference.frame_index(sample.seen_from)
        seen = residual[-1] @ state.R0[a]
        return after, Miss(seen, float(np.linalg.norm(seen)))

    def descend(self, state: Guess, seen: SkeletonSamples) -> tuple[Guess, Array]:
        """One step a sample; the residuals (n, 3) as they were, in the skeleton's coordinates."""
        old = state.skeleton
        axes, links = old.axes.copy(), old.links.copy()
        residual = np.empty_like(seen.x)
        descend_through(
            seen.path, seen.climbed, old.kind, axes, links, seen.theta, seen.v, seen.x,
            state.turns, state.moves, state.length, self._size(state.steps),
            self.rule == "normalised", residual,
        )  # fmt: skip
        skeleton = replace(old, axes=axes, links=links)
        return replace(state, skeleton=skeleton, steps=state.steps + len(residual)), residual

    def _size(self, t: int) -> float:
        return self.epsilon / (1 + t / self.half_after) if self.rule == "decaying" else self.epsilon


def learnable(body: Body, variables: Variables) -> tuple[Flags, Flags]:
    """Which axes and which links are free, (n_frames,) each.

    Raises:
        InputError: something else is free, or a part of an axis or of a link.
    """
    for name, code in zip(variables.names, variables.code, strict=True):
        if code not in (AXIS, LINK):
            raise InputError(
                f"parameter '{name}' is no joint axis and no link vector, and these are all that "
                'the gradient can learn; free the groups "axes" and "links" of joints and the '
                "position of frames (turn_std=None), or take another learner."
            )
    count = Counter(zip(variables.code.tolist(), variables.index.tolist(), strict=True))
    for (code, k), n in count.items():
        if n != (2 if code == AXIS else 3):
            what = "axis" if code == AXIS else "link"
            raise InputError(
                f"only {n} parameters of the {what} at '{body.frames[k]}' are free; "
                "the gradient learns whole vectors: free all of it or nothing."
            )
    frames = range(len(body.frames))
    turns = np.array([(AXIS, k) in count for k in frames])
    return turns, np.array([(LINK, k) in count for k in frames])


def typical_link(skeleton: Skeleton) -> float:
    """Median length of the links that are not zero, m. Raises InputError when all are."""
    lengths = np.linalg.norm(skeleton.links, axis=1)
    if not (lengths > 0).any():
        raise InputError(
            "all links of the body are zero, so nothing says how long a link is; "
            "give the learner a typical `length` in m."
        )
    return float(np.median(lengths[lengths > 0]))


def from_nothing(body: Body, variables: Variables, length: float, rng: np.random.Generator) -> Body:
    """The body with its free axes drawn at random and its free links small, as the paper begins.

    Args:
        body: the arrangement; what is not free stays as it is.
        variables: free axes and links.
        length: L, m; links are drawn from a normal distribution of 0.05 L a coordinate.
        rng: randomness.
    """
    turns, moves = learnable(body, variables)
    old = Skeleton.of(body)
    axes, links = old.axes.copy(), old.links.copy()
    drawn = rng.normal(size=axes.shape)
    axes[turns] = (drawn / np.linalg.norm(drawn, axis=1, keepdims=True))[turns]
    links[moves] = (SMALL_LINK * length * rng.normal(size=links.shape))[moves]
    return replace(old, axes=axes, links=links).into(body)
