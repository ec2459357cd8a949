"""Gravity: an accelerometer at rest on any link feels which way is up.

    residual  r = f - (1 + g) * (R_a_b(q, x) e_z G) - o        a = sensor, b = a frame whose z is up

f is the specific force, which points up at rest and is G long; g and o are gain and offset of each
channel, from a sensor part (`parts.accelerometer`). Only orientations play a part: the sensor's
mounting by its three turns, the world by its tilt. A twist (d, w) of T_a_b changes R e_z by
w x (R e_z).
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.model.kinematics import relative_pose, relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.ends import Ends, tilted
from bodyschema.senses.sense import PLACEMENT, Linearized, Sense, check_samples
from bodyschema.senses.turning import by_directions

Array = NDArray[np.float64]

G = 9.81
"""m/s^2. It varies by 0.3 % over the Earth: free the sensor's gains where that matters."""

DEFAULT_STD = 0.03
"""m/s^2 a channel, where the user states no noise: a good sensor's mean over a second at rest."""

STILL = 0.2
"""Share of G by which the length of a reading at rest may be off: gains, offsets, mountings."""


@dataclass(frozen=True)
class Gravity(Sense):
    """Accelerometer readings (n, 3) m/s^2 at rest, in frame `seen_from`; up is z of `seen`."""

    sensor: str = field(default="", kw_only=True)
    """The body's sensor part of three channels; "" where it reads true."""

    measures = (("acceleration", "m/s^2", 3),)

    def __post_init__(self) -> None:
        check_samples(self, self.observed, (3,))

    @classmethod
    def make(  # type: ignore[override]
        cls,
        q: ArrayLike,
        acceleration: ArrayLike,
        seen_from: str,
        seen: str,
        sensor: str = "",
        std: float | Sequence[float] = DEFAULT_STD,
        time: ArrayLike | None = None,
        rows: ArrayLike | None = None,
        **more: Any,
    ) -> Self:
        """Build from arrays.

        Args:
            q: (n, n_joints) encoder readings of postures held still.
            acceleration: (n, 3) m/s^2 as an accelerometer reads it: up and G long, not down.
            seen_from: frame of the sensor.
            seen: frame whose z axis is up: the root of a robot that stands level, or a fixed frame
                on it whose "turn_x" and "turn_y" are free.
            sensor: name of the body's sensor part; "" for none.
            std: noise of each channel, m/s^2.
            time: (n,) s; 0, 1, 2, ... when None.
            rows: (n,) row numbers for messages; 0, 1, 2, ... when None.
            more: `stated`, `clock`, `rate`.

        Raises:
            InputError: readings in units of g, or of a sensor that moved.
        """
        felt = np.atleast_2d(np.asarray(acceleration, dtype=np.float64))
        made = super().make(q, felt, seen_from, seen, std, time, rows, sensor=sensor, **more)
        length = float(np.median(np.linalg.norm(felt, axis=1))) if len(felt) else G
        if abs(length - G) > STILL * G:
            raise InputError(
                f"{made.label}: the readings are {length:.3g} long in the middle, gravity is "
                f"{G:g} m/s^2; give m/s^2 (not g), of postures held still."
            )
        return made

    @property
    def shows(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The sensor's turns and the tilt of what is up; no position."""
        return PLACEMENT[3:], PLACEMENT[3:5]

    def predict(self, body: Body) -> Array:
        """What the sensor would read, (n, 3) m/s^2."""
        T = relative_pose(body, self.readings(body), self.seen_from, self.seen)
        offset, gain = self._reading(body)
        return np.asarray((1 + gain) * G * T[:, :3, 2] + offset)

    def linearize(self, reference: Body, variables: Variables, x: Array) -> Linearized:
        """See `Sense.linearize`."""
        body = reference.with_variables(variables, x)
        q = self.readings(body)
        D = relative_pose_derivatives(reference, variables, x, q, self.seen_from, self.seen)
        offset, gain = self._reading(body)
        up = G * D.pose[:, :3, 2]
        gained = -(1 + gain)[:, None]
        by_parameter = gained * np.cross(D.by_parameter[:, 3:], up[:, :, None], axis=1)
        by_joint = gained * np.cross(D.by_joint[:, 3:], up[:, :, None], axis=1)
        columns, numbers = variables.of_part(self.sensor)
        each_channel = np.tile(np.eye(3), (len(self), 1, 1))
        by_sensor = np.concatenate([each_channel, each_channel * up[:, :, None]], axis=2)
        by_parameter[:, :, columns] -= by_sensor[:, :, numbers]
        residual = self.observed - (1 + gain) * up - offset
        return self.late(Linearized(residual, by_parameter, by_joint), variables)

    def start(self, body: Body, unknown: Collection[str]) -> Body | None:
        """Turns of the sensor and tilt of what is up; see `turning.by_directions`."""
        ends = Ends.of(body, self, unknown)
        if not ends.any:
            return None
        offset, gain = self._reading(body)
        seen = (self.observed - offset) / (1 + gain) / G
        open_ends = (ends.find_x, ends.find_y)
        R, t = by_directions(ends.K[:, :3, :3], seen, open_ends, ends.X[:3, :3], ends.Y[:3, 2])
        X = ends.X.copy()
        X[:3, :3] = R
        return ends.placed(X, tilted(ends.Y, t))

    def _reading(self, body: Body) -> tuple[Array, Array]:
        """Offset (3,) m/s^2 and gain (3,). Raises InputError for a part that is no such sensor."""
        if not self.sensor:
            return np.zeros(3), np.zeros(3)
        part = body.part(self.sensor)
        if part.kind != "sensor" or len(part.values) != 6:
            raise InputError(f"{self.label}: '{self.sensor}' is no sensor of three channels.")
        return part.values[:3], part.values[3:]
