"""Wrist wrenches: what a force and torque sensor feels of the loads that hang on it.

`seen_from` is the sensor's frame (free it where its mounting is not known), `seen` a frame of the
robot's foot whose z axis points up (free its turns where the foot stands askew). With u that axis
as the sensor sees it, G gravity, and the sensor's motion (a, w, dw) by `model.motion`,

    f = m (a + G u) + dw x h + w x (w x h)
    t = h x (a + G u) + I dw + w x I w            phi = [m, h, I] of the loads together (`inertia`)
    y = (1 + gain) [f, t] + offset                along the sensor's axes, sensor on object

(`wrench_parts`); loads are parts "load" in the sensor's frame, gain and offset a part "sensor". At
rest joints and mountings enter through u alone: what a force says of the joints is how they turn
the sensor against gravity.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.inertia import symmetric
from bodyschema.model.kinematics import relative_pose, relative_pose_derivatives
from bodyschema.model.motion import Motion, frame_motion, motion_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.gravity import G
from bodyschema.senses.sense import PLACEMENT, Linearized, Sense, check_samples
from bodyschema.senses.wrench_parts import WrenchParts
from bodyschema.senses.wrenches import FORCE_STD, TORQUE_STD, load_regressor

Array = NDArray[np.float64]


@dataclass(frozen=True)
class WristWrenches(Sense):
    """Forces and torques (n, 6), N and Nm, by the sensor on its load, along its own axes."""

    dq: Array | None = field(default=None, kw_only=True)
    """(n, n_joints) speed of the readings; None at rest."""
    ddq: Array | None = field(default=None, kw_only=True)
    """(n, n_joints) their acceleration; None at rest."""
    loads: tuple[str, ...] = field(default=("load",), kw_only=True)
    """Parts "load" that hang on the sensor together, in the sensor's frame."""
    sensor: str = field(default="", kw_only=True)
    """Part "sensor" with its offsets and gains; "" for a sensor without."""
    gravity: float = field(default=G, kw_only=True)
    """m/s^2"""

    measures = (("force", "N", 3), ("torque", "Nm", 3))

    def __post_init__(self) -> None:
        check_samples(self, self.observed, (6,))
        for part in (self.dq, self.ddq):
            if part is not None:
                check_samples(self, part, (self.q.shape[1],))
        if (self.dq is None) != (self.ddq is None):
            raise InputError(f"{self.label}: give both dq and ddq, or neither at rest.")

    @classmethod
    def make(  # type: ignore[override]
        cls,
        q: ArrayLike,
        wrench: ArrayLike,
        seen_from: str,
        seen: str,
        std: float | Sequence[float] = (FORCE_STD, TORQUE_STD),
        time: ArrayLike | None = None,
        rows: ArrayLike | None = None,
        **more: Any,
    ) -> Self:
        """Build from arrays.

        Args:
            q: (n, n_joints) encoder readings.
            wrench: (n, 6) N and Nm about the sensor's origin, by the sensor on the load: up at
                rest. Turn both signs where the load's pull on the sensor was recorded.
            seen_from: the sensor's frame.
            seen: a frame of the foot whose z axis points up.
            std: noise of each force (N) and of each torque (Nm).
            time: (n,) s; 0, 1, 2, ... when None.
            rows: (n,) row numbers for messages; 0, 1, 2, ... when None.
            more: `dq`, `ddq`, `loads`, `sensor`, `gravity`, `stated`, `clock`, `rate`.
        """
        felt = np.atleast_2d(np.asarray(wrench, dtype=np.float64))
        return super().make(q, felt, seen_from, seen, std, time, rows, **more)

    @property
    def label(self) -> str:
        """Name for messages and reports."""
        return f"wrench of {' and '.join(self.loads)} on {self.seen_from}"

    @property
    def shows(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Gravity has a direction and no place, and about it nothing turns; motion has both."""
        return PLACEMENT[3:] if self.dq is None else PLACEMENT, PLACEMENT[3:5]

    def predict(self, body: Body) -> Array:
        """What the sensor would read, (n, 6) N and Nm."""
        return self._parts.read(body, self.regressor(body) @ self._parts.phi(body))

    def regressor(self, body: Body) -> Array:
        """Y of `wrenches`: the wrench over the ten inertial parameters, (n, 6, 10)."""
        a_g, w, dw = self._felt(body)
        return load_regressor(a_g, w, dw)

    def linearize(self, reference: Body, variables: Variables, x: Array) -> Linearized:
        """See `Sense.linearize`."""
        body = reference.with_variables(variables, x)
        felt, parts = self._felt(body), self._parts
        Y, phi = load_regressor(*felt), parts.phi(body)
        wrench, by_motion = Y @ phi, wrench_slope(phi, *felt)
        by_joint, by_parameter = self._motion_slopes(reference, variables, x, body)
        by_parameter = parts.slopes(body, variables, Y, wrench, by_motion @ by_parameter)
        by_joint = (1 + parts.reading(body)[0])[:, None] * (by_motion @ by_joint)
        residual = self.observed - parts.read(body, wrench)
        return self.late(Linearized(residual, -by_parameter, -by_joint), variables)

    def start(self, body: Body, unknown: Collection[str]) -> Body | None:
        """The body with its load, the sensor's offset and mounting as the samples say, roughly.

        All but the mounting is linear. The mounting is the turn that best takes gravity as the
        sensor's parent sees it to the recorded forces, means taken off both (`lie`, Umeyama 1991).

        Args:
            body: with the load and the sensor as parts.
            unknown: of the sensor's frame, a single load and the sensor part, those to be found.
        """
        names = {self.seen_from, *self.loads, self.sensor} & {*unknown}
        if not names:
            return None
        body = self._turned(body) if self.seen_from in names else body
        std = np.sqrt(np.diag(self.covariance))
        return self._parts.start(body, names, self.regressor(body), self.observed, std)

    def _turned(self, body: Body) -> Body:
        """The body whose sensor sits as the forces say; its place stays."""
        parent = body.frames[body.parent[body.frame_index(self.seen_from)]]
        up = relative_pose(body, self.readings(body), parent, self.seen)[:, :3, 2]
        force = self.observed[:, :3]
        U, _, Vt = np.linalg.svd((up - up.mean(axis=0)).T @ (force - force.mean(axis=0)))
        T = body.placement[body.frame_index(self.seen_from)].copy()
        T[:3, :3] = U @ np.diag([1.0, 1.0, np.linalg.det(U @ Vt)]) @ Vt
        return body.with_placement(self.seen_from, T)

    def _felt(self, body: Body) -> tuple[Array, Array, Array]:
        """a + G u, w and dw of the sensor, (n, 3) each."""
        q = self.readings(body)
        up = self.gravity * relative_pose(body, q, self.seen_from, self.seen)[:, :3, 2]
        if self.dq is None or self.ddq is None:
            return up, np.zeros_like(up), np.zeros_like(up)
        moved = frame_motion(body, Motion(q, self.dq, self.ddq), self.seen_from)
        return up + moved.a, moved.w, moved.dw

    def _motion_slopes(
        self, reference: Body, variables: Variables, x: Array, body: Body
    ) -> tuple[Array, Array]:
        """Derivatives of what is felt, (n, 9, n_joints) and (n, 9, n_parameters)."""
        q = self.readings(body)
        D = relative_pose_derivatives(reference, variables, x, q, self.seen_from, self.seen)
        up = self.gravity * D.pose[:, :3, 2, None]
        still = [np.zeros((len(self), 9, count)) for count in (q.shape[1], len(x))]
        if self.dq is not None and self.ddq is not None:
            motion = Motion(q, self.dq, self.ddq)
            moved = motion_derivatives(reference, variables, x, motion, self.seen_from)
            still = [moved.by_joint, moved.by_parameter]
        by_joint, by_parameter = still
        by_joint[:, :3] += np.cross(D.by_joint[:, 3:], up, axis=1)
        by_parameter[:, :3] += np.cross(D.by_parameter[:, 3:], up, axis=1)
        return by_joint, by_parameter

    @property
    def _parts(self) -> WrenchParts:
        return WrenchParts(self.loads, self.sensor)


def wrench_slope(phi: Array, a_g: Array, w: Array, dw: Array) -> Array:
    """Derivatives of force and torque by (a, w, dw), (n, 6, 9).

    Args:
        phi: (10,) of the load.
        a_g: (n, 3) acceleration less gravity.
        w: (n, 3) angular velocity.
        dw: (n, 3) angular acceleration.
    """
    h, inertia = lie.skew(phi[1:4]), symmetric(phi[4:])
    W, spin = lie.skew(w), w @ inertia
    out = np.zeros((len(a_g), 6, 9))
    out[:, :3, :3] = phi[0] * np.eye(3)
    # w x (w x h) moves by v x (w x h) + w x (v x h).
    out[:, :3, 3:6] = -lie.skew(np.cross(w, phi[1:4])) - W @ h
    out[:, :3, 6:] = -h
    out[:, 3:, :3] = h
    out[:, 3:, 3:6] = W @ inertia - lie.skew(spin)
    out[:, 3:, 6:] = inertia
    return out
