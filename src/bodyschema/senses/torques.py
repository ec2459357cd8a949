"""Torques: what the motors of an arm exert, measured or told by their currents.

`seen_from` is the root, `seen` a frame of the foot whose z axis points up. With the regressors of
`joint_torques`, W_k of the load phi_k that each link is and V of the motors,

    y = (1 + gain) (sum_k W_k phi_k + V (inertia, viscous, coulomb, offset))

linear in everything but the geometry: links are parts "load" in their own frames, motors a part
"drive". Derivatives by parts are exact; those by joints and frames are central differences of the
exact prediction, since torques tell little of them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.model.kernels import PART
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.motion import Motion
from bodyschema.model.parts import DRIVE, load_phi
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.gravity import G
from bodyschema.senses.joint_torques import link_wrenches, motor_regressor
from bodyschema.senses.sense import Linearized, Sense, check_samples
from bodyschema.senses.wrench_parts import LOAD_SPREAD, with_load

Array = NDArray[np.float64]

DEFAULT_STD = 0.1
"""Nm of each joint, where the user states no noise."""

MOTOR_SPREAD = np.array([std for _, _, std in DRIVE[:-1]])
"""How far the numbers of a motor may be from none in a linear start."""

REVERSED, PLAIN = 0.3, 5.0
"""Share of the torques left over (rms) at which another sign is the right one, and how many times
the stated noise must be left over before anybody asks."""

SIZE = len(DRIVE)
"""Numbers of a motor; the last is its gain."""


@dataclass(frozen=True)
class Torques(Sense):
    """Torques (n, n_joints), Nm, by the motors on the joints."""

    dq: Array = field(default_factory=lambda: np.empty((0, 0)), kw_only=True)
    """(n, n_joints) speed of the readings."""
    ddq: Array = field(default_factory=lambda: np.empty((0, 0)), kw_only=True)
    """(n, n_joints) their acceleration."""
    loads: tuple[tuple[str, str], ...] = field(default=(), kw_only=True)
    """(link, part "load" in its frame) of everything that is carried."""
    drive: str = field(default="", kw_only=True)
    """Part "drive"; "" for motors without friction."""
    motors: Array = field(default_factory=lambda: np.empty((0, 0)), kw_only=True)
    """(n_joints, n_joints) the joints that each motor turns; the identity if not coupled."""
    gravity: float = field(default=G, kw_only=True)
    """m/s^2"""

    shared = ("motors",)

    def __post_init__(self) -> None:
        for part in (self.observed, self.dq, self.ddq):
            check_samples(self, part, (self.q.shape[1],))
        if not self.loads:
            raise InputError(f"{self.label}: name at least one link and the load that it is.")

    @classmethod
    def make(  # type: ignore[override]
        cls,
        q: ArrayLike,
        torque: ArrayLike,
        loads: Mapping[str, str],
        seen_from: str,
        seen: str,
        std: float | Sequence[float] = DEFAULT_STD,
        time: ArrayLike | None = None,
        rows: ArrayLike | None = None,
        dq: ArrayLike | None = None,
        ddq: ArrayLike | None = None,
        motors: ArrayLike | None = None,
        **more: Any,
    ) -> Self:
        """Build from arrays.

        Args:
            q: (n, n_joints) encoder readings.
            torque: (n, n_joints) Nm; a current times what its motor is said to exert per ampere.
            loads: part of kind "load" for each link that carries or weighs anything.
            seen_from: the root.
            seen: a frame of the foot whose z axis points up.
            std: noise of each torque, Nm; one number for all or (n_joints,).
            time: (n,) s; 0, 1, 2, ... when None.
            rows: (n,) row numbers for messages; 0, 1, 2, ... when None.
            dq: (n, n_joints) speed of the readings; at rest when None.
            ddq: (n, n_joints) their acceleration; at rest when None.
            motors: (n_joints, n_joints) joints that each motor turns; its own when None.
            more: `drive`, `gravity`, `stated`, `clock`, `rate`.
        """
        readings = np.atleast_2d(np.asarray(q, dtype=np.float64))
        count, still = readings.shape[1], np.zeros_like(readings)
        sizes = np.broadcast_to(np.asarray(std, dtype=np.float64), count)
        numbers = np.arange(len(readings))
        return cls(
            time=np.asarray(numbers if time is None else time, dtype=np.float64),
            q=readings,
            seen_from=seen_from,
            seen=seen,
            covariance=np.diag(sizes**2),
            rows=np.asarray(numbers if rows is None else rows, dtype=np.int64),
            observed=np.atleast_2d(np.asarray(torque, dtype=np.float64)),
            dq=still if dq is None else np.asarray(dq, dtype=np.float64),
            ddq=still if ddq is None else np.asarray(ddq, dtype=np.float64),
            loads=tuple(loads.items()),
            motors=np.eye(count) if motors is None else np.asarray(motors, dtype=np.float64),
            **more,
        )

    @property
    def label(self) -> str:
        """Name for messages and reports."""
        return f"torques that carry {' and '.join(name for _, name in self.loads)}"

    @property
    def components(self) -> tuple[tuple[str, str, slice], ...]:
        """Each joint has a noise level of its own."""
        joints = range(self.q.shape[1])
        return tuple((f"torque {j + 1}", "Nm", slice(j, j + 1)) for j in joints)

    @property
    def pairs(self) -> tuple[tuple[str, str], ...]:
        """Every link that weighs anything, seen from the root."""
        links = tuple((self.seen_from, link) for link, _ in self.loads)
        return ((self.seen_from, self.seen), *links)

    def predict(self, body: Body) -> Array:
        """What the motors would exert, (n, n_joints) Nm."""
        motion, links = self._links(body)
        phi = [load_phi(body.part(name))[0] for _, name in self.loads]
        torque = sum(
            np.einsum("nij,ni->nj", J, Y @ p) for (J, Y), p in zip(links, phi, strict=True)
        )
        if self.drive:
            numbers = self._numbers(body)[:, :-1].ravel()
            torque = torque + motor_regressor(motion, self.motors) @ numbers
        return np.asarray((1 + self._gain(body)) * torque)

    def regressor(self, body: Body) -> Array:
        """(n, n_joints, 10 n_loads + 4 n_motors): over the loads' phi and the drive's numbers."""
        motion, links = self._links(body)
        W = [np.swapaxes(J, 1, 2) @ Y for J, Y in links]
        if self.drive:
            W.append(motor_regressor(motion, self.motors))
        return np.concatenate(W, axis=2)

    def _links(self, body: Body) -> tuple[Motion, Iterator[tuple[Array, Array]]]:
        """The motion, and what each link that weighs anything feels of it."""
        motion = Motion(self.readings(body), self.dq, self.ddq)
        up = relative_pose(body, motion.q, body.frames[0], self.seen)[:, :3, 2]
        links = [link for link, _ in self.loads]
        return motion, link_wrenches(body, motion, links, -self.gravity * up)

    def carried(self, body: Body) -> Array:
        """What the regressor multiplies, (10 n_loads + 4 n_motors,)."""
        x = [load_phi(body.part(name))[0] for _, name in self.loads]
        return np.concatenate([*x, self._numbers(body)[:, :-1].ravel()])

    def linearize(self, reference: Body, variables: Variables, x: Array) -> Linearized:
        """See `Sense.linearize`."""
        moves, weighs = np.flatnonzero(variables.code != PART), variables.code == PART
        numbers = variables.take(np.flatnonzero(weighs).tolist())
        there = reference.with_variables(numbers, x[weighs])
        linear = super().linearize(there, variables.take(moves.tolist()), x[moves])
        by_parameter = np.zeros((*linear.residual.shape, len(variables)))
        by_parameter[:, :, moves] = linear.by_parameter
        body = reference.with_variables(variables, x)
        W, gain = self.regressor(body), self._gain(body)[:, None]
        for k, (_, name) in enumerate(self.loads):
            columns, roots = variables.of_part(name)
            slope = load_phi(body.part(name))[1][:, roots]
            by_parameter[:, :, columns] -= (1 + gain) * (W[:, :, 10 * k : 10 * k + 10] @ slope)
        torque, motor = W @ self.carried(body), W[:, :, 10 * len(self.loads) :]
        for column, number in zip(*variables.of_part(self.drive), strict=True):
            m, what = divmod(number, SIZE)
            if what == SIZE - 1:
                by_parameter[:, m, column] -= torque[:, m]
            else:
                by_parameter[:, :, column] -= (1 + gain[:, 0]) * motor[:, :, (SIZE - 1) * m + what]
        return self.late(replace(linear, by_parameter=by_parameter), variables)

    def start(self, body: Body, unknown: Collection[str]) -> Body | None:
        """The body with loads and friction by least squares, made physical afterwards.

        Args:
            body: with the loads and the drive as parts.
            unknown: of these parts, those to be found.

        Raises:
            InputError: with one torque, or all, of the other sign the loads would explain the
                samples, and as they are they do not.
        """
        names = [name for _, name in self.loads]
        if not {*names, self.drive} & {*unknown}:
            return None
        W, found = self.regressor(body), list[tuple[float, Body, str]]()
        for sign, words in self._signs(body):
            tried = self._started(body, unknown, W, sign * self.observed)
            e = sign * self.observed - (1 + self._gain(tried)) * (W @ self.carried(tried))
            found.append((float(np.sum(e**2 / np.diag(self.covariance))), tried, words))
        left, started, _ = found[0]
        best, _, words = min(found, key=lambda one: one[0])
        if best < REVERSED**2 * left and left > self.observed.size * PLAIN**2:
            raise InputError(
                f"{self.label}: with the torque of {words} turned round only "
                f"{np.sqrt(best / left):.0%} of what is left over would be; it is recorded with "
                "the other sign, so turn its column round."
            )
        return started

    def _signs(self, body: Body) -> Iterator[tuple[Array, str]]:
        """As recorded; all the other way; each joint alone: (n_joints,) and whose in words."""
        n = self.q.shape[1]
        yield np.ones(n), ""
        yield -np.ones(n), "all joints"
        if n > 1:
            yield from ((1.0 - 2.0 * one, body.joints[j]) for j, one in enumerate(np.eye(n)))

    def _started(self, body: Body, unknown: Collection[str], W: Array, observed: Array) -> Body:
        """The body with unknown loads and friction by least squares, made physical.

        Args:
            body: as in `start`.
            unknown: likewise.
            W: (n, n_joints, k) the regressor.
            observed: (n, n_joints) Nm.
        """
        names = [name for _, name in self.loads]
        x, gain = self.carried(body), self._gain(body)[:, None]
        wanted = np.repeat([name in unknown for name in names], 10)
        motors = np.full(len(x) - len(wanted), self.drive in unknown)
        free = np.concatenate([wanted, motors])
        std = np.sqrt(np.diag(self.covariance))[:, None]
        W = (1 + gain) * W / std
        rest = observed / std[:, 0] - W[:, :, ~free] @ x[~free]
        A = W[:, :, free].reshape(-1, int(free.sum()))
        spread = [np.tile(LOAD_SPREAD, len(names)), np.tile(MOTOR_SPREAD, len(motors) // 4)]
        H = A.T @ A + np.diag(np.concatenate(spread)[free] ** -2.0)
        x[free] = np.linalg.solve(H, A.T @ rest.ravel())
        return self._with(body, x, unknown)

    def _with(self, body: Body, x: Array, unknown: Collection[str]) -> Body:
        """The body with the unknown parts as the regressor's multipliers x say."""
        for k, (_, name) in enumerate(self.loads):
            if name in unknown:
                body = with_load(body, name, x[10 * k : 10 * k + 10])
        if self.drive in unknown:
            numbers = self._numbers(body).copy()
            numbers[:, :-1] = x[10 * len(self.loads) :].reshape(len(numbers), -1)
            part = replace(body.part(self.drive), values=numbers.ravel())
            body = body.with_part(self.drive, part)
        return body

    def _numbers(self, body: Body) -> Array:
        """(n_motors, SIZE) of the drive; none without one."""
        return body.part(self.drive).values.reshape(-1, SIZE) if self.drive else np.zeros((0, SIZE))

    def _gain(self, body: Body) -> Array:
        """(n_joints,)"""
        return self._numbers(body)[:, -1] if self.drive else np.zeros(self.q.shape[1])
