"""Touches: a point of one limb met by a point of another, or any known point of a frame seen.

    residual  r = p_a - T_a_b(q, x) v        a = seen_from, b = seen, v in b, another each sample

The skin of limb b feels the touch at v, that of limb a at p_a: the body learns itself in the dark
(Hersch et al. 2008, Fig. 7 right). A camera that sees known points of a limb, a new one at each
sample, gives the same equation (v_n and v'_n of their Eq. 14, 15); v = 0 is `Points`.

A change of x by a twist (d, w) of T_a_b, taken at the origin of b, moves the point by
d + w x (R_a_b v); so for a point off the origin the orientation of b matters.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.carried import carried, carried_position
from bodyschema.senses.ends import Ends
from bodyschema.senses.points import DEFAULT_STD
from bodyschema.senses.sense import Linearized, Sense, check_samples
from bodyschema.senses.turning import by_points

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Touches(Sense):
    """Positions (n, 3) m, in `seen_from`, of points of frame `seen` that are known there."""

    touching: Array = field(default_factory=lambda: np.empty((0, 3)))
    """(n, 3) m, the same points in frame `seen`."""

    measures = (("position", "m", 3),)

    def __post_init__(self) -> None:
        check_samples(self, self.observed, (3,))
        check_samples(self, self.touching, (3,))

    @classmethod
    def make(  # type: ignore[override]
        cls,
        q: ArrayLike,
        position: ArrayLike,
        touching: ArrayLike,
        seen_from: str,
        seen: str,
        std: float | Sequence[float] = DEFAULT_STD,
        time: ArrayLike | None = None,
        rows: ArrayLike | None = None,
        **more: Any,
    ) -> Self:
        """Build from arrays.

        Args:
            q: (n, n_joints) encoder readings.
            position: (n, 3) m, where limb `seen_from` is touched, in its frame.
            touching: (n, 3) m, the point of limb `seen` that touches it, in its own frame; or (3,)
                for one point that touches each time.
            seen_from: frame that `position` belongs to.
            seen: frame that `touching` belongs to.
            std: noise of each coordinate of the two points' distance, m.
            time: (n,) s; 0, 1, 2, ... when None.
            rows: (n,) row numbers for messages; 0, 1, 2, ... when None.
            more: `stated`, `clock`, `rate`.
        """
        felt_at = np.atleast_2d(np.asarray(position, dtype=np.float64))
        v = np.asarray(touching, dtype=np.float64)
        points = np.tile(v, (len(felt_at), 1)) if v.ndim == 1 else v
        return super().make(q, felt_at, seen_from, seen, std, time, rows, touching=points, **more)

    @property
    def position(self) -> Array:
        """(n, 3) m, where it was felt, in `seen_from`."""
        return self.observed

    @property
    def label(self) -> str:
        """Name for messages and reports, other than that of points of the same frame."""
        return f"touch of {self.seen} on {self.seen_from}"

    def predict(self, body: Body) -> Array:
        """Where the body says that the touch is, (n, 3) m, in `seen_from`."""
        return carried_position(body, self, self.touching)

    def linearize(self, reference: Body, variables: Variables, x: Array) -> Linearized:
        """See `Sense.linearize`."""
        p = carried(reference, variables, x, self, self.touching)
        linear = Linearized(self.observed - p.position, -p.by_parameter, -p.by_joint)
        return self.late(linear, variables)

    def start(self, body: Body, unknown: Collection[str]) -> Body | None:
        """Both ends from matching points; see `turning.by_points`."""
        ends = Ends.of(body, self, unknown)
        if not ends.any:
            return None
        open_ends = (ends.find_x, ends.find_y)
        return ends.placed(*by_points(ends.K, self.observed, self.touching, open_ends))
