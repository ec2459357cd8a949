"""Points: a body-fixed point seen in the frame of a tracker, a camera or another limb.

    residual  r = p_a - t_a_b(q, x)          a = seen_from, b = seen, whose origin is the point

The orientation of b plays no part: free its position alone (`free_frame(..., turn_std=None)`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.model.kinematics import relative_pose, relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import PLACEMENT, Linearized, Sense, check_samples

Array = NDArray[np.float64]

DEFAULT_STD = 1e-3
"""m per axis, where the user states no noise."""


@dataclass(frozen=True)
class Points(Sense):
    """Positions of one body-fixed point, (n, 3) m, in frame `seen_from`."""

    measures = (("position", "m", 3),)

    def __post_init__(self) -> None:
        check_samples(self, self.observed, (3,))

    @classmethod
    def make(  # type: ignore[override]
        cls,
        q: ArrayLike,
        position: ArrayLike,
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
            position: (n, 3) m, in `seen_from`.
            seen_from: frame that the coordinates belong to.
            seen: frame whose origin is the point.
            std: noise of each coordinate, m.
            time: (n,) s; 0, 1, 2, ... when None.
            rows: (n,) row numbers for messages; 0, 1, 2, ... when None.
            more: `stated`, `clock`, `rate`.
        """
        seen_at = np.atleast_2d(np.asarray(position, dtype=np.float64))
        return super().make(q, seen_at, seen_from, seen, std, time, rows, **more)

    @property
    def position(self) -> Array:
        """(n, 3) m, as seen, in `seen_from`."""
        return self.observed

    @property
    def label(self) -> str:
        """Name for messages and reports."""
        return f"{self.seen} seen from {self.seen_from}"

    @property
    def shows(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The orientation of the point's frame plays no part."""
        return PLACEMENT, PLACEMENT[:3]

    def predict(self, body: Body) -> Array:
        """Where the point would be seen, (n, 3) m."""
        q = self.readings(body)
        return np.asarray(relative_pose(body, q, self.seen_from, self.seen)[..., :3, 3])

    def linearize(self, reference: Body, variables: Variables, x: Array) -> Linearized:
        """See `Sense.linearize`."""
        q = self.readings(reference.with_variables(variables, x)) if self.clock else self.q
        D = relative_pose_derivatives(reference, variables, x, q, self.seen_from, self.seen)
        residual = self.observed - D.pose[:, :3, 3]
        linear = Linearized(residual, -D.by_parameter[:, :3], -D.by_joint[:, :3])
        return self.late(linear, variables)
