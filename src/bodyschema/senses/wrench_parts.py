"""What stands between a motion and a force sensor's reading: the loads, and the sensor itself.

    y = (1 + gain) Y phi + offset           phi = the sum of the loads that hang on the sensor

Y (n, 6, 10) is the regressor of the motion (`wrenches`), whatever told it. Linear in everything but
the gains, and the roots of a load (`inertia`) are one function away: so loads and offset have a
closed-form start.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.inertia import log_cholesky, nearest_physical
from bodyschema.model.parts import load_phi
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables

Array = NDArray[np.float64]

LOAD_SPREAD = np.array([10.0, *[1.0] * 3, *[0.1] * 6])
"""kg, kg m and kg m^2: how far a load may be from none in a linear start."""

OFFSET_SPREAD = np.array([50.0] * 3 + [5.0] * 3)
"""N and Nm, the same of the offsets."""

LIGHTEST = 1e-3
"""kg of a load at the start."""


@dataclass(frozen=True)
class WrenchParts:
    """Names of the parts that a wrench passes through."""

    loads: tuple[str, ...]
    """Of kind "load", in one frame."""
    sensor: str
    """Of kind "sensor" with six channels; "" for one that reads true."""

    def phi(self, body: Body) -> Array:
        """(10,) of all loads together."""
        return np.asarray(np.sum([load_phi(body.part(name))[0] for name in self.loads], axis=0))

    def reading(self, body: Body) -> tuple[Array, Array]:
        """Gains and offsets of the sensor, (6,) each."""
        if not self.sensor:
            return np.zeros(6), np.zeros(6)
        values = body.part(self.sensor).values
        return values[6:], values[:6]

    def read(self, body: Body, wrench: Array) -> Array:
        """What the sensor makes of wrenches (n, 6)."""
        gain, offset = self.reading(body)
        return np.asarray((1 + gain) * wrench + offset)

    def slopes(
        self, body: Body, variables: Variables, Y: Array, wrench: Array, by_motion: Array
    ) -> Array:
        """Derivatives of the reading, (n, 6, n_parameters).

        Args:
            body: at which they are taken.
            variables: what may be wrong with it.
            Y: (n, 6, 10) the regressor.
            wrench: (n, 6) Y phi.
            by_motion: (n, 6, n_parameters) derivative of the wrench at fixed phi.
        """
        out = by_motion.copy()
        for name in self.loads:
            columns, roots = variables.of_part(name)
            out[:, :, columns] += Y @ load_phi(body.part(name))[1][:, roots]
        out *= (1 + self.reading(body)[0])[:, None]
        for column, number in zip(*variables.of_part(self.sensor), strict=True):
            i = number % 6
            out[:, i, column] += 1.0 if number < 6 else wrench[:, i]
        return out

    def start(
        self, body: Body, unknown: Collection[str], Y: Array, observed: Array, std: Array
    ) -> Body:
        """The body with those parts that are unknown by least squares, loads made physical.

        Args:
            body: has the parts.
            unknown: names of parts, others left aside.
            Y: (n, 6, 10) the regressor.
            observed: (n, 6) readings.
            std: (6,) their noise.
        """
        gain, offset = self.reading(body)
        wanted = [name for name in self.loads if name in unknown]
        held = replace(self, loads=tuple(name for name in self.loads if name not in unknown))
        biased = bool(self.sensor) and self.sensor in unknown
        free = np.array([bool(wanted)] * 10 + [biased] * 6)
        known = held.phi(body) if held.loads else np.zeros(10)
        Y = (1 + gain)[:, None] * Y
        b = (observed - Y @ known - (0.0 if biased else offset)) / std
        A = np.concatenate([Y, np.tile(np.eye(6), (len(Y), 1, 1))], axis=2)[:, :, free]
        A = A / std[:, None]
        H = np.einsum("nij,nik->jk", A, A)
        H += np.diag(np.concatenate([LOAD_SPREAD, OFFSET_SPREAD])[free] ** -2.0)
        x = np.zeros(16)
        x[free] = np.linalg.solve(H, np.einsum("nij,ni->j", A, b))
        for name in wanted:
            body = with_load(body, name, x[:10] / len(wanted))
        if biased:
            part = body.part(self.sensor)
            values = np.concatenate([x[10:], part.values[6:]])
            body = body.with_part(self.sensor, replace(part, values=values))
        return body


def with_load(body: Body, name: str, phi: Array) -> Body:
    """The body with a load that comes near phi (10,) and can exist."""
    heavy = phi if phi[0] > LIGHTEST else np.array([LIGHTEST, *[0.0] * 9])
    eta = log_cholesky(nearest_physical(heavy))
    return body.with_part(name, replace(body.part(name), values=eta))
