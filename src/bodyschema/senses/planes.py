"""Planes: a point or a ball that one limb carries lies on a flat thing that nobody measured.

    residual  r = h - e_z . p,        p = t_a_b(q, x) + R_a_b(q, x) v      a = plane, b = limb

The plane is z = 0 of frame a = `seen_from`, its normal points to the side of the limb; v is fixed
in b = `seen`; h is 0 for a tip and the radius for a ball. A plane can show no more of itself than
its height and its tilt: "link_z", "turn_x", "turn_y". `link_z` is along z of the frame that the
plane hangs on, so a wall hangs on a frame whose z points out of it (`Body.attach`), not on the
floor's.
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
from bodyschema.senses.ends import Ends, tilted
from bodyschema.senses.placing import by_heights
from bodyschema.senses.sense import Linearized, Sense, check_samples

Array = NDArray[np.float64]

DEFAULT_STD = 1e-3
"""m, where the user states no noise."""

PLANE = ("link_z", "turn_x", "turn_y")
"""What a plane shows of the placement of its frame."""

STEEPEST = 0.2
"""Cosine between the normal and z of the frame that a plane hangs on: below, `link_z` moves along
the plane rather than off it."""


@dataclass(frozen=True)
class Planes(Sense):
    """Heights (n, 1) m of a point of frame `seen` above the plane z = 0 of `seen_from`."""

    point: Array = field(default_factory=lambda: np.empty((0, 3)))
    """(n, 3) m, the point (the ball's centre) in frame `seen`."""

    measures = (("height", "m", 1),)

    def __post_init__(self) -> None:
        check_samples(self, self.observed, (1,))
        check_samples(self, self.point, (3,))

    @classmethod
    def make(  # type: ignore[override]
        cls,
        q: ArrayLike,
        seen_from: str,
        seen: str,
        height: ArrayLike = 0.0,
        point: ArrayLike | None = None,
        std: float | Sequence[float] = DEFAULT_STD,
        time: ArrayLike | None = None,
        rows: ArrayLike | None = None,
        **more: Any,
    ) -> Self:
        """Build from arrays.

        Args:
            q: (n, n_joints) encoder readings.
            seen_from: frame of the plane.
            seen: frame of the limb that touches it.
            height: (n,) m or one number: 0 for a tip, the radius for a ball.
            point: (3,) or (n, 3) m, the tip or the ball's centre in `seen`; its origin when None.
            std: noise of the height, m.
            time: (n,) s; 0, 1, 2, ... when None.
            rows: (n,) row numbers for messages; 0, 1, 2, ... when None.
            more: `stated`, `clock`, `rate`.
        """
        n = len(np.atleast_2d(np.asarray(q)))
        at = column(height, n)
        more = {**more, "point": each(point, n)}
        return super().make(q, at, seen_from, seen, std, time, rows, **more)

    @property
    def shows(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Height and tilt of the plane; no orientation of a limb whose point is the origin."""
        return PLANE, shown(self.point)

    def predict(self, body: Body) -> Array:
        """Heights above the plane, (n, 1) m."""
        return carried_position(body, self, self.point)[:, 2:]

    def linearize(self, reference: Body, variables: Variables, x: Array) -> Linearized:
        """See `Sense.linearize`."""
        p = carried(reference, variables, x, self, self.point)
        residual = self.observed - p.position[:, 2:]
        return self.late(
            Linearized(residual, -p.by_parameter[:, 2:], -p.by_joint[:, 2:]), variables
        )

    def start(self, body: Body, unknown: Collection[str]) -> Body | None:
        """Height and tilt of the plane, position of the limb's frame; see `placing.by_heights`.

        The normal stays on the side to which the frame's z axis points as attached.

        Raises:
            InputError: the plane is a wall in the frame that it hangs on.
        """
        ends = Ends.of(body, self, unknown)
        if not ends.any:
            return None
        R, known = ends.K[:, :3, :3], ends.between(np.zeros_like(self.point), self.point)
        open_ends = (ends.find_x, ends.find_y)
        n, c, y = by_heights(R, known, self.observed[:, 0], open_ends, ends.X[:3, 2])
        if abs(n[2]) < STEEPEST:
            parent = body.frames[body.parent[body.frame_index(self.seen_from)]]
            raise InputError(
                f"{self.label}: the plane stands upright in frame '{parent}', so its height there "
                "means nothing; hang it on a frame whose z axis points out of it (Body.attach)."
            )
        X = tilted(ends.X, n)
        X[2, 3] = (c - n[:2] @ X[:2, 3]) / n[2]
        return ends.placed(X, ends.at(ends.Y, y))
