"""Recordings of an arm that is not what the model says, with the fit that believes the model."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.problem import Problem
from bodyschema.model.kinematics import frame_jacobian, relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_joints
from bodyschema.senses.points import Points
from bodyschema.trust.target import Target, targets
from simulated import drawn, seen_arm

Array = NDArray[np.float64]
Readings = Callable[[Array], Array]

PAIR = ("tracker", "tool")
STEP = 0.1
"""s between samples of a smooth path."""


@dataclass(frozen=True)
class Recorded:
    """A recording, what it was fitted with, and the truth."""

    problem: Problem
    fit: Estimate
    truth: Body

    @property
    def targets(self) -> list[Target]:
        """The tool seen from the tracker, over the box of readings."""
        return targets(self.problem.senses, 0, [PAIR])

    @property
    def error(self) -> float:
        """95 % of the true error of the fitted tool, m."""
        q = self.targets[0].q
        a, b = (relative_pose(body, q, *PAIR)[:, :3, 3] for body in (self.truth, self.fit.body))
        return float(np.quantile(np.linalg.norm(a - b, axis=1), 0.95))


def path(n: int, n_joints: int, rng: np.random.Generator) -> Callable[[Array], Array]:
    """Smooth movements of all joints, (n,) s -> (n, n_joints) rad."""
    phase, pace = rng.uniform(0, 6, n_joints), rng.uniform(0.3, 1.2, n_joints)
    return lambda t: 1.3 * np.sin(np.outer(t, pace) + phase)


def recorded(
    seed: int = 0,
    n: int = 60,
    smooth: bool = False,
    late: float = 0.0,
    turned: Readings | None = None,
    moved: Callable[[Array], Array] | None = None,
    noise: Array | float = 5e-4,
    repeats: int = 1,
    groups: tuple[str, ...] = ("offsets", "axes", "links"),
) -> Recorded:
    """Points of the tool of a five-joint arm whose offsets, axes and links are all a little off.

    Args:
        seed: of everything.
        n: postures.
        smooth: one movement, STEP apart; else postures at random.
        late: s by which the joints were read before the eye saw (smooth paths).
        turned: what the joints truly do when they read (n, n_joints).
        moved: what is done to the points seen, (n, 3) -> (n, 3).
        noise: m, or the noise itself (n, 3).
        repeats: times that each posture is seen.
        groups: that the fit frees.
    """
    rng = np.random.default_rng(seed)
    nominal = seen_arm(5, rng)
    joints = free_joints(nominal, ("offsets", "axes", "links"))
    truth = nominal.with_variables(joints, drawn(joints, rng, 0.2))
    time = np.arange(n) * (STEP if smooth else 1.0)
    if smooth:
        movement = path(n, 5, rng)
        q, true_q = movement(time), movement(time - late)
    else:
        q = rng.uniform(-1.5, 1.5, (n, 5))
        true_q = q
    q, true_q, time = (np.repeat(a, repeats, axis=0) for a in (q, true_q, time))
    true_q = true_q if turned is None else turned(true_q)
    seen = relative_pose(truth, true_q, *PAIR)[:, :3, 3]
    seen = seen if moved is None else moved(seen)
    seen = seen + (noise * rng.normal(size=seen.shape) if np.isscalar(noise) else noise)
    sense = Points.make(q, seen, *PAIR, 1e-3, time=time)
    problem = Problem(nominal, (sense,), {"tracker": "no", "tool": "no"}, nominal.joints)
    return Recorded(problem, problem.fit(problem.variables(groups), problem.senses), truth)


def sagging(body: Body, joint: int, give: float) -> Readings:
    """A joint that gives way by so many rad under a weight of 1 m lever on the tool."""

    def turned(q: Array) -> Array:
        bent = q.copy()
        lever = frame_jacobian(body, q, "base", "tool")[:, 2, joint]
        bent[:, joint] += give * lever
        return bent

    return turned


def slipped(joint: int, size: float, share: float = 0.5) -> Readings:
    """An encoder that slips by so many rad after a share of the recording."""

    def turned(q: Array) -> Array:
        after = q.copy()
        after[round(share * len(q)) :, joint] += size
        return after

    return turned


def bumped(shift: Array, share: float = 0.5) -> Callable[[Array], Array]:
    """A tracker that is moved by so much (m) after a share of the recording."""

    def moved(p: Array) -> Array:
        after = p.copy()
        after[round(share * len(p)) :] += shift
        return after

    return moved


def autoregressive(n: int, memory: float, std: float, rng: np.random.Generator) -> Array:
    """(n, 3) noise that remembers a share of its last value."""
    e = rng.normal(size=(n, 3))
    for i in range(1, n):
        e[i] = memory * e[i - 1] + np.sqrt(1 - memory**2) * e[i]
    return std * e
