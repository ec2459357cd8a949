"""Joint zeros from images, ready for a monitor: particles find the arm, its outline follows it.

A particle filter looks at the first images: its cloud says where to begin, not how sure that is
(it settles where masks overlap well, which is degrees from the best). From then on x, the offsets
of the joints, and their information L follow the outline. For point i of the outline as imagined at
x, d_i is how far outward the seen one lies, J_i its slope, l_i the contour that it stands for, and

    w_i = l_i min(1, k / |d_i|) / v,   H = sum w_i J_i^T J_i,   g = sum w_i J_i^T d_i
    x <- argmin |x - x_0|^2_L + sum w_i (d_i - J_i (x - x_0))^2,    L <- L + H

(Huber's weights, a few Gauss-Newton steps an image). In as many rows as there are offsets this is
the innovation e = H^-1/2 g with slope H^1/2, of unit variance while x is right and v = `SPREAD` is;
what its variance and memory really are gets measured (`stream_noise`).

After a joint was forgotten, images count 1 / (tau a), with a the level and tau the memory of the
noise. What a trial costs is the sum of e^T (1 + H^1/2 L^-1 H^1/2)^-1 e, each image at most as much
as the rarest good one.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.estimation.belief import GaussianBelief, Slopes, WhiteInnovation, forget, inverse
from bodyschema.estimation.certificate import Certificate, Tolerance
from bodyschema.estimation.stream_noise import StreamNoise, outlier_limit
from bodyschema.learners.learner import MonitoredLearner, Pace, in_turn
from bodyschema.learners.published.particle_filter import ParticleFilter, ParticleState
from bodyschema.model.kinematics import relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_joints
from bodyschema.senses.images import Images
from bodyschema.vision.correspondences import find_rim, rim_slopes
from bodyschema.vision.normal_search import search_masks
from bodyschema.vision.poses import piece_poses

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SEARCH, APPROACH, SETTLED = 30, 10, 20
"""Images for the particles; then for the way to the outline, whose slopes are forgotten again; and
those that are learned before a certificate is looked at."""

SPREAD = 0.27
"""v, pixels^2: 0.3 pixels of noise that err together over 3 pixels of contour."""

REACH, LINEAR = 30.0, 1.5
"""pixels: how far the outline is looked for, and k."""

STEPS = 3
"""Gauss-Newton steps an image."""

STRIDE = 2
"""Every how many rows and columns the outline is looked at."""


@dataclass(frozen=True)
class WatchedOutline:
    """State: what is believed, and what innovations look like."""

    cloud: ParticleState | None
    """While particles search."""
    x: Array
    """(n,) rad."""
    information: Array
    """(n, n) L."""
    images: int = 0
    noise: StreamNoise = StreamNoise()  # noqa: RUF009  (frozen)
    before: Array | None = None
    """(n,) innovation of the image before, if that was good."""
    last: Images | None = None
    """The newest image."""
    tempered: float = 1.0
    """tau a by which images count less, for good; 1 before the first change."""
    relearning: bool = False
    """Whether this belief began from a prior, with a joint forgotten."""
    cost: float = 0.0
    rows: float = 0.0
    """Sum of squared innovations, and their number of rows."""


@dataclass(frozen=True)
class WatchedImages(MonitoredLearner[WatchedOutline, Images, tuple[float, ...]]):
    """Settings of a learner of masks; watch it with a `Monitor`."""

    body: Body
    """What is believed without the offsets."""
    joints: tuple[str, ...]
    """Whose zeros are unknown, and may jump."""
    tip: str
    """Frame whose place must be known."""
    finder: ParticleFilter
    """Of the first images; its surface is what shows, its prior that of the offsets."""
    tolerance: Tolerance = field(default_factory=lambda: Tolerance({"position": 0.002}))
    """m: 99 % bound of the tip's place in the first camera."""

    @cached_property
    def blocks(self) -> Mapping[str, Ints]:
        """Joint -> place of its offset."""
        return {name: np.array([i]) for i, name in enumerate(self.joints)}

    @cached_property
    def _variables(self) -> Variables:
        return free_joints(self.body, ("offsets",), self.joints)

    @property
    def pace(self) -> Pace:
        """Of ten pairs of masks a second."""
        return Pace(rate=10.0)

    def start(self) -> WatchedOutline:
        """Nothing known but the prior."""
        cloud = self.finder.start(self.body, self.joints)
        return WatchedOutline(cloud, np.zeros(len(self.joints)), self._prior())

    def step(
        self, state: WatchedOutline, moment: tuple[Images, ...]
    ) -> tuple[WatchedOutline, tuple[float, ...]]:
        """Learn from the images of one moment; squared innovations, nan while particles search."""
        return in_turn(self._learn, state, moment)

    def innovation(self, state: WatchedOutline, moment: tuple[Images, ...]) -> WhiteInnovation:
        """The images of a moment against what is believed."""
        found = [_condensed(*self._normal(state.x, seen)) for seen in moment]
        n = len(self.joints)
        return WhiteInnovation(
            np.concatenate([white.e for white in found]),
            np.concatenate([white.J for white in found]),
            np.repeat(np.arange(len(found)), n),
        )

    def belief(self, state: WatchedOutline) -> GaussianBelief:
        """Of the offsets."""
        level = max(state.noise.level, 1.0)
        cost, rows = state.cost, state.rows * level / state.tempered
        relearned = state.relearning and rows > 0
        return GaussianBelief(
            inverse(state.information),
            self.tolerance,
            state.noise,
            state.tempered,
            cost,
            rows,
            fit=cost / rows if relearned else 1.0,
            freedom=rows,
            begun=state.last is not None and state.rows >= SETTLED * len(self.joints),
        )

    def difference(self, state: WatchedOutline, earlier: WatchedOutline) -> Array:
        """(n,) the step of x."""
        return state.x - earlier.x

    def certificate(self, state: WatchedOutline) -> Certificate:
        """Whether the tip's place is known well enough, in the posture that was seen last."""
        belief = self.belief(state)
        if state.last is None or not belief.begun:
            return belief.certificate({})
        eye, q = state.last.cameras[0].frame, state.last.q
        D = relative_pose_derivatives(self.body, self._variables, state.x, q, eye, self.tip)
        return belief.certificate({"position": Slopes(D.by_parameter[None, :3], "m")})

    def forget(self, state: WatchedOutline, block: str) -> WatchedOutline:
        """Go on with one joint as unknown as at first; "" keeps everything."""
        tempered = max(_weight(state.noise), state.tempered)
        information = state.information * (state.tempered / tempered)
        if block:
            information = forget(information, self.blocks[block], self.finder.prior**-2.0)
        return WatchedOutline(
            None, state.x, information, state.images, state.noise, last=state.last,
            tempered=tempered, relearning=True,
        )  # fmt: skip

    def _learn(self, state: WatchedOutline, seen: Images) -> tuple[WatchedOutline, float]:
        state = replace(state, images=state.images + 1, last=seen)
        if state.cloud is not None:
            cloud = self.finder.step(state.cloud, (seen,))[0]
            done = state.images == SEARCH
            x = cloud.beta.mean(axis=0)
            return replace(state, cloud=None if done else cloud, x=x), float("nan")
        if state.images == SEARCH + APPROACH:
            state = replace(state, information=self._prior())
        x, H, surprise = state.x, np.zeros_like(state.information), float("nan")
        for step in range(STEPS):
            H, g = (part / state.tempered for part in self._normal(x, seen))
            if not step and (state.relearning or state.images > SEARCH + APPROACH):
                white = _condensed(H * state.tempered, g * state.tempered)
                state, surprise = self._weigh(state, white)
            pull = state.information @ (state.x - x)
            x = x + np.linalg.solve(state.information + H, g + pull)
        return replace(state, x=x, information=state.information + H), surprise

    def _prior(self) -> Array:
        return np.asarray(np.eye(len(self.joints)) / self.finder.prior**2)

    def _normal(self, x: Array, seen: Images) -> tuple[Array, Array]:
        """H (n, n) and g (n,) of one image at x."""
        if not seen.masked:
            raise InputError("a watched outline is looked for in masks (bool); got images.")
        surface, free = self.finder.surface, self._variables
        posed = self.body.with_variables(free, x)
        T = piece_poses(posed, seen.q, seen.cameras, surface.frames)[0]
        rim = find_rim(surface, T, seen.cameras, STRIDE)
        outline = search_masks(rim, seen.pictures, REACH)
        slopes = rim_slopes(rim, surface, seen.cameras, self.body, free, x, seen.q)
        J, d = slopes.by_parameter[outline.found], outline.distance[outline.found]
        w = rim.length[outline.found] / SPREAD * np.minimum(1, LINEAR / np.maximum(abs(d), LINEAR))
        return J.T @ (w[:, None] * J), J.T @ (w * d)

    def _weigh(self, state: WatchedOutline, white: WhiteInnovation) -> tuple[WatchedOutline, float]:
        """Count an image's innovation before it is learned; the squared innovation."""
        T, limit = state.tempered, outlier_limit(len(white.e))
        S = T * np.eye(len(white.e)) + white.J @ np.linalg.solve(state.information, white.J.T)
        q = float(white.e @ np.linalg.solve(S, white.e))
        cost = state.cost + min(q, limit * max(state.noise.level / T, 1.0))
        state = replace(state, cost=cost, rows=state.rows + len(white.e))
        if state.relearning:
            return state, q
        noise = state.noise.learn(white.e, state.before, q)
        good = q <= limit * noise.level
        return replace(state, noise=noise, before=white.e if good else None), q


def _weight(noise: StreamNoise) -> float:
    """tau a, 1 or more."""
    return max(noise.long_run, 1.0) * max(noise.level, 1.0)


def _condensed(H: Array, g: Array) -> WhiteInnovation:
    """As many rows as there are offsets: e = H^-1/2 g with slope H^1/2."""
    values, vectors = np.linalg.eigh((H + H.T) / 2)
    root = np.sqrt(np.maximum(values, 0.0))
    # What the image says nothing about is no surprise.
    told = root > 1e-6 * max(float(root[-1]), 1e-300)
    along = np.where(told, vectors.T @ g / np.where(told, root, 1.0), 0.0)
    return WhiteInnovation(
        vectors @ along, (vectors * root) @ vectors.T, np.zeros(len(g), dtype=np.int64)
    )
