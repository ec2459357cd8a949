"""Inverse kinematics: joint positions that bring one frame to a place seen from another.

With T_a_b(q) = (R, p) the pose of frame b in frame a, and the aim (R*, p*),

    minimise    C(q) = 1/2 |e|^2     over  lower <= q <= upper
    position    e_p = p* - p                                  m
    rotation    e_R = L log(R* R^T), where it is asked for    m;  L weighs radians

by steps of damped least squares (Wampler 1986; Nakamura and Hanafusa 1986). J is the Jacobian of
T_a_b that the body's geometry gives; Hersch et al. 2008, section 6, name it as their next step.

    (A^T A + lambda s 1) d = A^T e,     A = [J_v; L J_r^-1(log R* R^T) J_w],   s = tr A^T A / n

A step is clipped to the limits and taken if C falls; lambda falls then, and grows otherwise. Joints
that stand at a limit and would leave it are held. Where the aim is not reached from the posture at
hand, random postures are tried; the best one found comes back, with what is missing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.estimation.identifiability import random_postures
from bodyschema.model.kinematics import relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_joints

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

MOST_DAMPING = 1e8
"""Damping at which no step helps: a minimum has been reached."""


@dataclass(frozen=True)
class Aim:
    """Where a frame should be."""

    seen_from: str
    """Frame a, that the coordinates belong to."""
    seen: str
    """Frame b, whose origin is to be there."""
    position: ArrayLike
    """(3,) p*, m, in frame a."""
    rotation: ArrayLike | None = None
    """(3, 3) R*, frame b's axes in frame a; None where any will do."""


@dataclass(frozen=True)
class Reached:
    """The posture that was found, and how near it comes, as far as the body knows."""

    q: Array
    """(n_joints,) within the limits."""
    converged: bool
    """The aim is reached within the tolerance."""
    position_error: float
    """m, from the aim."""
    rotation_error: float
    """rad; 0 where no rotation was asked for."""
    at_limits: tuple[str, ...]
    """Joints of the path that stand at an end of their range."""
    iterations: int
    """Steps tried, over all starts."""


@dataclass(frozen=True)
class InverseKinematics:
    """Damped least squares within joint limits."""

    tolerance: float = 1e-6
    """m, and rad: how near counts as there."""
    arm: float = 0.3
    """L, m a rad: an error of one radian weighs as much as this length."""
    starts: int = 10
    """Random postures tried when the first does not lead there."""
    iterations: int = 100
    """Steps from one start."""

    def solve(
        self,
        body: Body,
        aim: Aim,
        q: ArrayLike,
        joints: Sequence[str] | None = None,
        seed: int = 0,
    ) -> Reached:
        """Find a posture.

        Args:
            body: what is believed.
            aim: where which frame should be, seen from where.
            q: (n_joints,) posture to start from.
            joints: those that may move; all when None.
            seed: of the random starts.

        Raises:
            InputError: no such frame or joint, a posture beyond the limits, an aim that is no
                place.
        """
        problem = _Problem.of(body, aim, joints, self.arm)
        start = _checked(body, q)
        best, steps = _descend(problem, start, self)
        rng = np.random.default_rng(seed)
        for _ in range(self.starts):
            if problem.reached(best, self.tolerance):
                break
            fresh = np.where(problem.moves, random_postures(body, 1, rng)[0], start)
            found, more = _descend(problem, fresh, self)
            steps += more
            if np.sum(problem.error(found)[0] ** 2) < np.sum(problem.error(best)[0] ** 2):
                best = found
        return problem.answer(best, self.tolerance, steps)


@dataclass(frozen=True)
class _Problem:
    """What is to be minimised."""

    body: Body
    aim: Aim
    position: Array
    rotation: Array | None
    moves: Flags
    arm: float
    nothing: Variables
    """No free parameter: derivatives by the joints alone."""

    @classmethod
    def of(cls, body: Body, aim: Aim, joints: Sequence[str] | None, arm: float) -> _Problem:
        """Check the aim and the names."""
        position = np.asarray(aim.position, dtype=np.float64)
        rotation = None if aim.rotation is None else np.asarray(aim.rotation, dtype=np.float64)
        if position.shape != (3,) or not np.isfinite(position).all():
            raise InputError(f"expected a position of three numbers in m, got {aim.position!r}.")
        if rotation is not None and (
            rotation.shape != (3, 3) or not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6)
        ):
            raise InputError(f"expected a 3x3 rotation, got:\n{rotation}")
        names = body.joints if joints is None else joints
        moves = np.zeros(len(body.joints), dtype=bool)
        moves[[body.joint_index(name) for name in names]] = True
        return cls(body, aim, position, rotation, moves, arm, free_joints(body, ()))

    def error(self, q: Array) -> tuple[Array, Array]:
        """e (3,) or (6,), and A with the columns of joints that do not move at zero."""
        D = relative_pose_derivatives(
            self.body, self.nothing, np.empty(0), q, self.aim.seen_from, self.aim.seen
        )
        e, A = self.position - D.pose[:3, 3], D.by_joint[:3]
        if self.rotation is not None:
            w = lie.log_so3(self.rotation @ D.pose[:3, :3].T)
            e = np.concatenate([e, self.arm * w])
            A = np.vstack([A, self.arm * lie.inverse_left_jacobian(-w) @ D.by_joint[3:]])
        return e, A * self.moves

    def reached(self, q: Array, tolerance: float) -> bool:
        """Whether the aim is reached."""
        e, _ = self.error(q)
        return bool(max(np.linalg.norm(e[:3]), np.linalg.norm(e[3:]) / self.arm) <= tolerance)

    def answer(self, q: Array, tolerance: float, steps: int) -> Reached:
        """What is told of a posture."""
        e, A = self.error(q)
        body = self.body
        ends = (q <= body.lower) | (q >= body.upper)
        at = tuple(body.joints[j] for j in np.flatnonzero(ends & A.any(axis=0)))
        missing = float(np.linalg.norm(e[:3])), float(np.linalg.norm(e[3:]) / self.arm)
        return Reached(q, max(missing) <= tolerance, *missing, at, steps)


def _descend(problem: _Problem, q: Array, settings: InverseKinematics) -> tuple[Array, int]:
    """Follow the damped steps from one start to a minimum; and the number of steps tried."""
    low, high = problem.body.lower, problem.body.upper
    e, A = problem.error(q)
    damping, steps = 1e-3, 0
    # Well below the tolerance: a last quadratic step costs nothing.
    while steps < settings.iterations and np.linalg.norm(e) > 1e-3 * settings.tolerance:
        steps += 1
        pull = A.T @ e
        held = ((q <= low) & (pull < 0)) | ((q >= high) & (pull > 0))
        free = A * ~held
        scale = float(np.sum(free**2)) / max(int(np.count_nonzero(free.any(axis=0))), 1)
        if scale == 0:
            break
        H = free.T @ free + damping * scale * np.eye(len(q))
        there = np.clip(q + np.linalg.solve(H, free.T @ e), low, high)
        e_there, A_there = problem.error(there)
        if np.sum(e_there**2) < np.sum(e**2):
            q, e, A, damping = there, e_there, A_there, max(damping / 5, 1e-12)
        else:
            damping *= 4
            if damping > MOST_DAMPING:
                break
    return q, steps


def _checked(body: Body, q: ArrayLike) -> Array:
    """A posture within the limits, or an InputError."""
    posture = np.array(q, dtype=np.float64)
    if posture.shape != (len(body.joints),):
        raise InputError(
            f"expected one position for each of {len(body.joints)} joints "
            f"({', '.join(body.joints)}), got an array of shape {posture.shape}."
        )
    beyond = np.flatnonzero((posture < body.lower - 1e-6) | (posture > body.upper + 1e-6))
    if len(beyond):
        j = int(beyond[0])
        raise InputError(
            f"joint '{body.joints[j]}' starts at {posture[j]:.3f}, beyond its range of "
            f"{body.lower[j]:.3f} to {body.upper[j]:.3f}; start within it."
        )
    return np.asarray(np.clip(posture, body.lower, body.upper))
