"""Wrenches: what a force/torque sensor at the wrist feels of what hangs on it.

Inside, a wrench is what the SENSOR EXERTS ON THE OBJECT, at the sensor's origin and along its axes,
force before torque: an object at rest is held up against gravity. With the motion of that frame,

    a_g = a - g      acceleration of the origin less gravity, (3,) m/s^2
    w, dw            angular velocity and acceleration, rad/s and rad/s^2

Newton's and Euler's laws are linear in the ten inertial parameters phi (`model.inertia`):

    f   = m a_g + ([dw]x + [w]x [w]x) h
    tau = h x a_g + (L(dw) + [w]x L(w)) I,      L(v) I = I v,      together  y = Y(a_g, w, dw) phi

(Atkeson, An and Hollerbach 1986, "Estimation of inertial parameters of manipulator loads and
links"). A recording that states what the load does to the sensor has both signs turned; one whose
wrench is written along the axes of another frame is turned sample by sample (`Wrenches.make`).
Gravity is measured with the acceleration where an accelerometer rides on the sensor: give minus its
reading as `gravity` and no acceleration; then the base may move as it likes.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.model.inertia import Inertia
from bodyschema.model.kernels import kernel

Array = NDArray[np.float64]

Sign = Literal["on_object", "on_sensor"]

FORCE_STD = 0.05
"""N, believed noise of a force that nobody described."""

TORQUE_STD = 0.002
"""Nm."""


@dataclass(frozen=True)
class Wrenches:
    """Samples of a wrist sensor and of its motion, in the sensor's frame."""

    time: Array
    """(n,) s."""
    force: Array
    """(n, 3) N, by the sensor on the object."""
    torque: Array
    """(n, 3) Nm, about the sensor's origin."""
    gravity: Array
    """(n, 3) m/s^2, points down; less the acceleration if an accelerometer measured both."""
    acceleration: Array
    """(n, 3) m/s^2 of the sensor's origin, gravity not counted."""
    angular_velocity: Array
    """(n, 3) rad/s."""
    angular_acceleration: Array
    """(n, 3) rad/s^2."""
    std: Array
    """(6,) believed noise of force, N, and torque, Nm."""

    def __post_init__(self) -> None:
        """Refuse what does not belong together or is not finite."""
        n = len(self.time)
        for field in fields(self):
            array = getattr(self, field.name)
            shape = {"time": (n,), "std": (6,)}.get(field.name, (n, 3))
            if array.shape != shape:
                raise InputError(
                    f"wrenches: {field.name} should have shape {shape}, it has {array.shape}."
                )
            bad = np.flatnonzero(~np.isfinite(array).reshape(len(array), -1).all(axis=1))
            if len(bad):
                raise InputError(
                    f"wrenches: {field.name} is not a finite number in sample {bad[0]}; "
                    f"drop the {len(bad)} such samples or repair them."
                )
        if not (self.std > 0).all():
            raise InputError(f"wrenches: noise must be above zero, got {self.std.tolist()}.")

    @classmethod
    def make(
        cls,
        time: ArrayLike,
        force: ArrayLike,
        torque: ArrayLike,
        gravity: ArrayLike,
        sign: Sign,
        *,
        acceleration: ArrayLike | None = None,
        angular_velocity: ArrayLike | None = None,
        angular_acceleration: ArrayLike | None = None,
        R_sensor_frame: ArrayLike | None = None,
        std: ArrayLike = (FORCE_STD,) * 3 + (TORQUE_STD,) * 3,
    ) -> Self:
        """Build from arrays.

        Args:
            time: (n,) s.
            force: (n, 3) N.
            torque: (n, 3) Nm about the sensor's origin.
            gravity: (n, 3) m/s^2 along the sensor's axes, downward.
            sign: "on_object" if the sensor's push on the object was recorded (up, at rest),
                "on_sensor" if the load's pull on the sensor was (down, at rest).
            acceleration: (n, 3) m/s^2 of the sensor's origin, its axes; zero when None.
            angular_velocity: (n, 3) rad/s along the sensor's axes; zero when None.
            angular_acceleration: (n, 3) rad/s^2 along the sensor's axes; zero when None.
            R_sensor_frame: (3, 3) or (n, 3, 3), from the axes along which force and torque are
                written to the sensor's; None if they are the sensor's.
            std: (6,) noise of force, N, and torque, Nm.

        Raises:
            InputError: an unknown sign, arrays that do not fit, or numbers that are not finite.
        """
        if sign not in ("on_object", "on_sensor"):
            raise InputError(f"sign is 'on_object' or 'on_sensor', got '{sign}'.")
        times = np.asarray(time, dtype=np.float64)
        still = np.zeros((len(times), 3))
        turn = np.eye(3) if R_sensor_frame is None else np.asarray(R_sensor_frame)
        factor = 1.0 if sign == "on_object" else -1.0

        def given(values: ArrayLike | None) -> Array:
            return still if values is None else np.asarray(values, dtype=np.float64)

        def turned(values: ArrayLike) -> Array:
            return np.asarray(factor * (turn @ np.asarray(values, dtype=float)[..., None])[..., 0])

        return cls(
            time=times,
            force=turned(force),
            torque=turned(torque),
            gravity=given(gravity),
            acceleration=given(acceleration),
            angular_velocity=given(angular_velocity),
            angular_acceleration=given(angular_acceleration),
            std=np.asarray(std, dtype=np.float64),
        )

    def __len__(self) -> int:
        return len(self.time)

    @property
    def y(self) -> Array:
        """(n, 6) force and torque."""
        return np.hstack([self.force, self.torque])

    @property
    def a_g(self) -> Array:
        """(n, 3) m/s^2, acceleration less gravity."""
        return self.acceleration - self.gravity

    def regressor(self) -> Array:
        """Y of the module's text, (n, 6, 10)."""
        return load_regressor(self.a_g, self.angular_velocity, self.angular_acceleration)

    def residual(self, load: Inertia, bias: ArrayLike = (0.0,) * 6) -> Array:
        """What load and bias do not explain, (n, 6): the wrench of anything else on the object.

        Args:
            load: in the sensor's frame.
            bias: (6,) what the sensor reads without a load, in the inside sign.
        """
        return np.asarray(self.y - np.asarray(bias) - self.regressor() @ load.phi)

    def take(self, rows: Any) -> Self:
        """Some of the samples, by slice, index or mask."""
        columns = {f.name: getattr(self, f.name)[rows] for f in fields(self) if f.name != "std"}
        return type(self)(**columns, std=self.std)


def load_regressor(a_g: ArrayLike, w: ArrayLike, dw: ArrayLike) -> Array:
    """Y for many moments: each (n, 3) -> (n, 6, 10)."""
    a, spin, change = (
        np.ascontiguousarray(np.atleast_2d(part), dtype=np.float64) for part in (a_g, w, dw)
    )
    Y = np.zeros((len(a), 6, 10))
    fill_regressor(a, spin, change, Y)
    return Y


@kernel
def fill_regressor(a_g: Array, w: Array, dw: Array, Y: Array) -> None:
    """Write Y (n, 6, 10); its fixed zeros are left as they are."""
    for n in range(a_g.shape[0]):
        ax, ay, az = a_g[n]
        x, y, z = w[n]
        u, v, s = dw[n]
        Y[n, 0, 0], Y[n, 1, 0], Y[n, 2, 0] = ax, ay, az
        Y[n, 0, 1], Y[n, 0, 2], Y[n, 0, 3] = -y * y - z * z, x * y - s, x * z + v
        Y[n, 1, 1], Y[n, 1, 2], Y[n, 1, 3] = x * y + s, -x * x - z * z, y * z - u
        Y[n, 2, 1], Y[n, 2, 2], Y[n, 2, 3] = x * z - v, y * z + u, -x * x - y * y
        # h x a_g = -[a_g]x h
        Y[n, 3, 2], Y[n, 3, 3] = az, -ay
        Y[n, 4, 1], Y[n, 4, 3] = -az, ax
        Y[n, 5, 1], Y[n, 5, 2] = ay, -ax
        # Columns xx, xy, yy, xz, yz, zz of I dw + w x (I w).
        Y[n, 3, 4], Y[n, 3, 5], Y[n, 3, 6] = u, v - x * z, -y * z
        Y[n, 3, 7], Y[n, 3, 8], Y[n, 3, 9] = s + x * y, y * y - z * z, y * z
        Y[n, 4, 4], Y[n, 4, 5], Y[n, 4, 6] = x * z, u + y * z, v
        Y[n, 4, 7], Y[n, 4, 8], Y[n, 4, 9] = z * z - x * x, s - x * y, -x * z
        Y[n, 5, 4], Y[n, 5, 5], Y[n, 5, 6] = -x * y, x * x - y * y, x * y
        Y[n, 5, 7], Y[n, 5, 8], Y[n, 5, 9] = u - y * z, v + x * z, s
