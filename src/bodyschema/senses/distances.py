"""Distances: how far a point of one frame is from a point of another.

    residual  r = d - (1 + g) |p| - o,       p = t_a_b(q, x) + R_a_b(q, x) v - w

with w fixed in a = `seen_from` and v in b = `seen`. A wire from a drum on the floor to the hand, a
ranging tag, two balls in contact (the sum of their radii, whatever the touching point). The gain g
and the offset o, a drum's zero or radii that are not quite known, belong to a sensor part of one
channel. A twist that moves p by dp changes |p| by n . dp, n = p / |p|.

A distance of nearly nothing tells nothing to first order (its derivative has no direction at zero)
and cannot be negative, so samples below SHORTEST of their noise are refused. A tip that is put into
the same dimple from many postures is three numbers, not one: `Points` at (0, 0, 0) of the dimple's
frame, which may be unknown, or `Touches`.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.carried import carried, carried_position, column, each, shown
from bodyschema.senses.ends import Ends
from bodyschema.senses.placing import by_distances
from bodyschema.senses.sense import Linearized, Sense, check_samples

Array = NDArray[np.float64]

DEFAULT_STD = 1e-3
"""m, where the user states no noise."""

SHORTEST = 5.0
"""Standard deviations of the noise: below, the mean length of p is off by a fifth of one."""

FLOOR = 1e-6
"""m: direction of a shorter p is taken as p / FLOOR, so that no derivative is infinite."""


@dataclass(frozen=True)
class Distances(Sense):
    """Distances (n, 1) m between a point of `seen_from` and a point of `seen`."""

    anchor: Array = field(default_factory=lambda: np.empty((0, 3)))
    """(n, 3) m, the point w in frame `seen_from`."""
    end: Array = field(default_factory=lambda: np.empty((0, 3)))
    """(n, 3) m, the point v in frame `seen`."""
    sensor: str = field(default="", kw_only=True)
    """The body's sensor part of one channel that reads the distance; "" where it reads true."""

    measures = (("distance", "m", 1),)

    def __post_init__(self) -> None:
        check_samples(self, self.observed, (1,))
        check_samples(self, self.anchor, (3,))
        check_samples(self, self.end, (3,))

    @classmethod
    def make(  # type: ignore[override]
        cls,
        q: ArrayLike,
        distance: ArrayLike,
        seen_from: str,
        seen: str,
        anchor: ArrayLike | None = None,
        end: ArrayLike | None = None,
        sensor: str = "",
        std: float | Sequence[float] = DEFAULT_STD,
        time: ArrayLike | None = None,
        rows: ArrayLike | None = None,
        **more: Any,
    ) -> Self:
        """Build from arrays.

        Args:
            q: (n, n_joints) encoder readings.
            distance: (n,) m, or one number for all, such as the sum of two radii.
            seen_from: frame of the one point.
            seen: frame of the other.
            anchor: (3,) or (n, 3) m, the point in `seen_from`; its origin when None.
            end: (3,) or (n, 3) m, the point in `seen`; its origin when None.
            sensor: name of the body's sensor part that reads it; "" for none.
            std: noise, m.
            time: (n,) s; 0, 1, 2, ... when None.
            rows: (n,) row numbers for messages; 0, 1, 2, ... when None.
            more: `stated`, `clock`, `rate`.

        Raises:
            InputError: a distance too short to have a direction, see the module.
        """
        n = len(np.atleast_2d(np.asarray(q)))
        read = column(distance, n)
        more = {**more, "anchor": each(anchor, n), "end": each(end, n), "sensor": sensor}
        made = super().make(q, read, seen_from, seen, std, time, rows, **more)
        short = made.observed[:, 0] < SHORTEST * np.sqrt(made.covariance[0, 0])
        if short.any() and not sensor:
            raise InputError(
                f"{made.label}: {made.observed[short][0, 0]:g} m in row {made.rows[short][0]} is "
                f"within {SHORTEST:g} standard deviations of zero, where a distance has no "
                "direction; for a tip at a fixed place use points, which are three coordinates."
            )
        return made

    @property
    def shows(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The orientation of a frame plays no part where its point is the origin."""
        return shown(self.anchor), shown(self.end)

    def predict(self, body: Body) -> Array:
        """What would be read, (n, 1) m."""
        p = carried_position(body, self, self.end) - self.anchor
        offset, gain = self._reading(body)
        return np.asarray((1 + gain) * np.linalg.norm(p, axis=1, keepdims=True) + offset)

    def linearize(self, reference: Body, variables: Variables, x: Array) -> Linearized:
        """See `Sense.linearize`."""
        offset, gain = self._reading(reference.with_variables(variables, x))
        place = carried(reference, variables, x, self, self.end)
        p = place.position - self.anchor
        length = np.linalg.norm(p, axis=1, keepdims=True)
        along = -(1 + gain) * (p / np.maximum(length, FLOOR))[:, None, :]
        by_parameter = along @ place.by_parameter
        columns, numbers = variables.of_part(self.sensor)
        by_sensor = np.stack([np.ones_like(length), length], axis=2)
        by_parameter[:, :, columns] -= by_sensor[:, :, numbers]
        residual = self.observed - (1 + gain) * length - offset
        return self.late(Linearized(residual, by_parameter, along @ place.by_joint), variables)

    def start(self, body: Body, unknown: Collection[str]) -> Body | None:
        """Positions of the open ends, see `placing.by_distances`; orientations stay as attached."""
        ends = Ends.of(body, self, unknown)
        if not ends.any:
            return None
        offset, gain = self._reading(body)
        d = (self.observed[:, 0] - offset) / (1 + gain)
        open_ends = (ends.find_x, ends.find_y)
        R, known = ends.K[:, :3, :3], ends.between(self.anchor, self.end)
        x, y = by_distances(R, known, d, open_ends, uncertain_zero=bool(self.sensor))
        return ends.placed(ends.at(ends.X, x), ends.at(ends.Y, y))

    def _reading(self, body: Body) -> tuple[float, float]:
        """Offset (m) and gain of the sensor. Raises InputError for one of more channels."""
        if not self.sensor:
            return 0.0, 0.0
        part = body.part(self.sensor)
        if part.kind != "sensor" or len(part.values) != 2:
            raise InputError(f"{self.label}: '{self.sensor}' is no sensor of one channel.")
        return float(part.values[0]), float(part.values[1])
