"""A stick in the hand of a humanoid, watched by its head camera: the scene of the tool experiment.

The arm has the four joints and the dimensions of HOAP-3; head and waist stand still, so the camera
is a fixed frame. The robot knows its arm to 0.01 rad an axis and 3 mm a link and does not know that
it holds anything: its tip is the hand. The eyes see the tip of the stick with normal noise, and now
and then something else (Hersch, Sauser and Billard 2008, section 5.3).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.watched_smoother import Block
from bodyschema.model.kinematics import relative_pose, relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, join
from bodyschema.senses.points import Points
from bodyschema.simulation.humanoid import EYE, humanoid, reduced

Array = NDArray[np.float64]
Motion = Literal["smooth", "independent"]

JOINTS = ("r_shoulder_pitch", "r_shoulder_roll", "r_arm_yaw", "r_elbow")
HAND, ELBOW, TIP = "r_hand", "r_elbow", "tip"

STICK = 0.34
"""m"""
AXIS_STD, LINK_STD, TIP_STD = 0.01, 0.003, 0.3
"""rad, m and m: how well the robot knows its axes, its links and what it holds."""

MEAN_LENGTH = np.sqrt(8 / np.pi)
"""Of a standard normal vector in space."""
OUTLIER_REACH = 0.5
"""m: outliers lie uniformly within this of the tip, along each axis."""

RATE = 10.0
"""Hz, of the paper's robot."""
SLOWEST, FASTEST = 0.05, 0.35
"""Hz: three sines a joint make the smooth motion."""

FRESH = 50
"""Postures at which errors are measured."""


def _members(carrier: str) -> tuple[str, ...]:
    return tuple(f"{carrier}.link_{c}" for c in "xyz")


BLOCKS = (
    Block("tool", _members(TIP), 0.3, odds=20.0),
    Block("upper arm", _members("r_arm_yaw"), 0.3),
    Block("camera", _members(EYE), 0.3),
)
"""What may change: the tool most often."""


@cache
def arm() -> Body:
    """The arm as the robot knows it, its tip in the hand."""
    known = reduced(humanoid(), JOINTS, {EYE: EYE, HAND: HAND})
    return known.attach(TIP, HAND)


@cache
def freed(whole: bool) -> Variables:
    """The tip, and the whole arm with it or not, under the robot's prior."""
    tip = free_frame(arm(), TIP, TIP_STD, None)
    if not whole:
        return tip
    # The first link and the camera's place are one direction while the head stands still.
    links = free_joints(arm(), ["links"], JOINTS[1:])
    rest = join(free_frame(arm(), EYE, 1.0, None), free_joints(arm(), ["axes"], JOINTS), links)
    std = np.where(np.array(rest.groups) == "axes", AXIS_STD, LINK_STD)
    return join(rest.with_prior(std), tip)


@dataclass(frozen=True)
class Scene:
    """What one robot did and saw."""

    before: Array
    """(n_parameters,) true deviation from what the robot knows, of `freed(True)`."""
    after: Array
    """The same after the change."""
    change_at: int
    """Sample from which `after` holds."""
    seen: Points
    fresh: Array
    """(FRESH, n_joints) other postures."""

    def body(self, t: int) -> Body:
        """The true body at sample t."""
        return arm().with_variables(freed(True), self.before if t < self.change_at else self.after)

    def places(self, t: int, frame: str) -> Array:
        """Where a frame truly is at the fresh postures, (FRESH, 3) m in the camera."""
        return relative_pose(self.body(t), self.fresh, EYE, frame)[:, :3, 3]

    def miss(self, body: Body, places: Array, frame: str) -> float:
        """Root mean square error (m) of a frame as a body predicts it."""
        gap = relative_pose(body, self.fresh, EYE, frame)[:, :3, 3] - places
        return float(np.sqrt(np.mean(np.sum(gap**2, axis=1))))

    def bound(self, whole: bool, n: int) -> float:
        """Least rms error (m) of the tip that n samples allow: Cramer-Rao with the prior.

        Outliers are counted as good samples, and the arm as known when it is not free.
        """
        variables = freed(whole)
        x = self.before[-len(variables) :]
        J = self._jacobian(variables, x, self.seen.q[:n]).reshape(-1, len(x))
        H = J.T @ J / self.seen.covariance[0, 0] + np.diag(variables.prior_std**-2.0)
        there = self._jacobian(variables, x, self.fresh)
        variance = np.einsum("nip,pq,niq->n", there, np.linalg.inv(H), there)
        return float(np.sqrt(np.mean(variance)))

    def _jacobian(self, variables: Variables, x: Array, q: Array) -> Array:
        return relative_pose_derivatives(arm(), variables, x, q, EYE, TIP).by_parameter[:, :3]


@dataclass(frozen=True)
class Setting:
    """How the robot moves and sees."""

    noise: float
    """m: mean length of the error of the eyes."""
    outliers: float
    """Share."""
    motion: Motion
    arm_error: float
    """Of the true arm, in units of what the robot believes of it."""

    def scene(self, rng: np.random.Generator, n: int, change: Change | None = None) -> Scene:
        """One robot with a stick, n samples long."""
        prior = freed(True).prior_std
        before = self.arm_error * prior * rng.normal(size=len(prior))
        before[-3:] = STICK * _direction(rng)
        after = before if change is None else change.made(before, rng)
        q = smooth(n, rng) if self.motion == "smooth" else _uniform(n, rng)
        at = n if change is None else change.at
        return Scene(before, after, at, self._seen(before, after, at, q, rng), _uniform(FRESH, rng))

    def _seen(
        self, before: Array, after: Array, at: int, q: Array, rng: np.random.Generator
    ) -> Points:
        std = self.noise / MEAN_LENGTH
        bodies = [arm().with_variables(freed(True), x) for x in (before, after)]
        p = np.concatenate(
            [
                relative_pose(body, part, EYE, TIP)[:, :3, 3]
                for body, part in zip(bodies, (q[:at], q[at:]), strict=True)
            ]
        )
        bad = rng.random(len(p)) < self.outliers
        wild = rng.uniform(-OUTLIER_REACH, OUTLIER_REACH, p.shape)
        noisy = p + std * rng.normal(size=p.shape) + wild * bad[:, None]
        return Points.make(q, noisy, EYE, TIP, std, time=np.arange(len(q)) / RATE)


@dataclass(frozen=True)
class Change:
    """A change of one part in mid-run."""

    part: str
    """Name of a block."""
    size: float
    """m; a tool that moves by the stick's length is dropped: the tip is in the hand again."""
    at: int
    """Sample."""

    def made(self, before: Array, rng: np.random.Generator) -> Array:
        """The true deviation after it."""
        after = before.copy()
        rows = next(block for block in BLOCKS if block.name == self.part).rows(freed(True))
        if self.part == "tool" and self.size == STICK:
            after[rows] = 0.0
        else:
            after[rows] += self.size * _direction(rng)
        return after


def smooth(n: int, rng: np.random.Generator) -> Array:
    """Postures of an arm that is moved about at 10 Hz, (n, n_joints) rad within the limits."""
    t = np.arange(n)[:, None, None] / RATE
    turns = rng.uniform(SLOWEST, FASTEST, (len(JOINTS), 3)) * t + rng.random((len(JOINTS), 3))
    share = np.clip(0.4 * np.sin(2 * np.pi * turns).sum(axis=2), -1, 1)
    low, high = arm().lower, arm().upper
    return np.asarray((low + high) / 2 + (high - low) / 2 * share)


def _uniform(n: int, rng: np.random.Generator) -> Array:
    return rng.uniform(arm().lower, arm().upper, (n, len(JOINTS)))


def _direction(rng: np.random.Generator) -> Array:
    d = rng.normal(size=3)
    return np.asarray(d / np.linalg.norm(d))
