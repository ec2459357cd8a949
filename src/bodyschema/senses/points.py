"""Points: a body-fixed point seen in the frame of a tracker, a camera or another limb.

    residual  r = p_a - t_a_b(q, x)          a = seen_from, b = seen, whose origin is the point

The orientation of b plays no part: free its position alone (`free_frame(..., turn_std=None)`).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.model.kinematics import relative_pose, relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Linearized, Sense, check_samples, counted

Array = NDArray[np.float64]

DEFAULT_STD = 1e-3
"""m per axis, where the user states no noise."""


@dataclass(frozen=True)
class Points(Sense):
    """Positions of one body-fixed point."""

    position: Array = field(default_factory=lambda: np.empty((0, 3)))
    """(n, 3) m, in frame `seen_from`."""

    def __post_init__(self) -> None:
        check_samples(self, self.position, (3,))

    @classmethod
    def make(
        cls,
        q: ArrayLike,
        position: ArrayLike,
        seen_from: str,
        seen: str,
        std: float = DEFAULT_STD,
        time: ArrayLike | None = None,
        rows: ArrayLike | None = None,
    ) -> Points:
        """Build from arrays.

        Args:
            q: (n, n_joints) encoder readings.
            position: (n, 3) m, in `seen_from`.
            seen_from: frame that the coordinates belong to.
            seen: frame whose origin is the point.
            std: noise of each coordinate, m.
            time: (n,) s; 0, 1, 2, ... when None.
            rows: (n,) row numbers for messages; 0, 1, 2, ... when None.
        """
        readings, times, numbers = counted(q, time, rows)
        return cls(
            time=times,
            q=readings,
            seen_from=seen_from,
            seen=seen,
            covariance=std**2 * np.eye(3),
            rows=numbers,
            position=np.atleast_2d(np.asarray(position, dtype=np.float64)),
        )

    @property
    def components(self) -> tuple[tuple[str, str, slice], ...]:
        """One noise level for all three coordinates."""
        return (("position", "m", slice(0, 3)),)

    def residual(self, body: Body) -> Array:
        """Seen minus predicted position, (n, 3) m, in `seen_from`."""
        T_a_b = relative_pose(body, self.q, self.seen_from, self.seen)
        return np.asarray(self.position - T_a_b[..., :3, 3])

    def imagined(self, body: Body, q: ArrayLike) -> Self:
        """See `Sense.imagined`."""
        T_a_b = relative_pose(body, q, self.seen_from, self.seen)
        seen = T_a_b[..., :3, 3]
        count = np.arange(len(seen))
        return replace(
            self, time=count.astype(np.float64), q=np.asarray(q), rows=count, position=seen
        )

    def linearize(self, reference: Body, variables: Variables, x: Array) -> Linearized:
        """See `Sense.linearize`."""
        D = relative_pose_derivatives(reference, variables, x, self.q, self.seen_from, self.seen)
        residual = self.position - D.pose[:, :3, 3]
        return Linearized(residual, -D.by_parameter[:, :3], -D.by_joint[:, :3])
