"""Mean wrenches: a force sensor's load where the motion of the wrist is recorded beside it.

Poses or an accelerometer at the wrist spare the kinematics, and means over short windows
(`wrench_means`) spare the accelerations. `seen_from` is the sensor, `seen` its mount, along whose
axes the motion is known. With Y the averaged regressor at the sensor's origin along these axes, R
the turn from the mount's axes to the sensor's, and phi of loads along the mount's axes,

    wrench = R Y phi        y = (1 + gain) wrench + offset       force and torque turned alike

(`wrench_parts`). A twist that turns the mount by v, along the sensor's axes, moves them by v x.
Windows overlap, and neighbours err together: `of` takes as many as are measurements of their own.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kinematics import relative_pose, relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import PLACEMENT, Linearized, Sense, check_samples
from bodyschema.senses.wrench_means import WrenchMeans
from bodyschema.senses.wrench_parts import WrenchParts

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MeanWrenches(Sense):
    """Means (n, 6) of force and torque, N and Nm, by the sensor on the load, along its axes."""

    regressor: Array = field(default_factory=lambda: np.empty((0, 6, 10)), kw_only=True)
    """(n, 6, 10) Y."""
    loads: tuple[str, ...] = field(default=("load",), kw_only=True)
    """Parts "load" that hang on the sensor together, along the mount's axes."""
    sensor: str = field(default="", kw_only=True)
    """Part "sensor" with its offsets and gains; "" for a sensor without."""

    measures = (("force", "N", 3), ("torque", "Nm", 3))

    def __post_init__(self) -> None:
        check_samples(self, self.observed, (6,))
        check_samples(self, self.regressor, (6, 10))

    @classmethod
    def of(cls, means: WrenchMeans, seen_from: str, seen: str, n_joints: int, **more: Any) -> Self:
        """From averaged samples.

        Args:
            means: of a recording.
            seen_from: frame of the sensor.
            seen: frame of its mount.
            n_joints: of the body; their readings play no part.
            more: `loads`, `sensor`, `stated`.
        """
        some = means.take(slice(None, None, max(1, round(means.memory))))
        q = np.zeros((len(some), n_joints))
        more |= {"regressor": some.Y, "time": some.time}
        made = cls.make(q, some.y, seen_from, seen, 1.0, **more)
        return replace(made, covariance=np.diag(means.std**2))

    @property
    def label(self) -> str:
        """Name for messages and reports."""
        return f"mean wrench of {' and '.join(self.loads)} on {self.seen_from}"

    @property
    def shows(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """How the sensor is turned against its mount."""
        return PLACEMENT[3:], PLACEMENT[3:]

    def predict(self, body: Body) -> Array:
        """What the sensor would read, (n, 6) N and Nm."""
        R = relative_pose(body, self.q, self.seen_from, self.seen)[:, :3, :3]
        wrench = _turned(R, self.regressor) @ self._parts.phi(body)
        return self._parts.read(body, wrench)

    def linearize(self, reference: Body, variables: Variables, x: Array) -> Linearized:
        """See `Sense.linearize`."""
        body, parts = reference.with_variables(variables, x), self._parts
        D = relative_pose_derivatives(reference, variables, x, self.q, self.seen_from, self.seen)
        Y = _turned(D.pose[:, :3, :3], self.regressor)
        wrench = Y @ parts.phi(body)
        by_parameter = parts.slopes(body, variables, Y, wrench, _swung(D.by_parameter, wrench))
        by_joint = (1 + parts.reading(body)[0])[:, None] * _swung(D.by_joint, wrench)
        residual = self.observed - parts.read(body, wrench)
        return Linearized(residual, -by_parameter, -by_joint)

    def start(self, body: Body, unknown: Collection[str]) -> Body | None:
        """The body with loads and offset by least squares; the mounting as it is."""
        if not {*self.loads, self.sensor} & {*unknown}:
            return None
        R = relative_pose(body, self.q, self.seen_from, self.seen)[:, :3, :3]
        std = np.sqrt(np.diag(self.covariance))
        Y = _turned(R, self.regressor)
        return self._parts.start(body, unknown, Y, self.observed, std)

    @property
    def _parts(self) -> WrenchParts:
        return WrenchParts(self.loads, self.sensor)


def _turned(R: Array, Y: Array) -> Array:
    """Forces and torques along other axes: (n, 3, 3), (n, 6, k) -> (n, 6, k)."""
    return np.concatenate([R @ Y[:, :3], R @ Y[:, 3:]], axis=1)


def _swung(twist: Array, wrench: Array) -> Array:
    """v x force and v x torque: twists (n, 6, m), wrenches (n, 6) -> (n, 6, m)."""
    turn = twist[:, 3:]
    pair = [np.cross(turn, part[:, :, None], axis=1) for part in (wrench[:, :3], wrench[:, 3:])]
    return np.concatenate(pair, axis=1)
