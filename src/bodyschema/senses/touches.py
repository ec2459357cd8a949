"""Touches: a point of one limb met by a point of another, or any known point of a frame seen.

    residual  r = p_a - T_a_b(q, x) v        a = seen_from, b = seen, v in b, another each sample

The skin of limb b feels the touch at v, that of limb a at p_a: the body learns itself in the dark
(Hersch et al. 2008, Fig. 7 right). A camera that sees known points of a limb, a new one at each
sample, gives the same equation (v_n and v'_n of their Eq. 14, 15); v = 0 is `Points`.

A change of x by a twist (d, w) of T_a_b, taken at the origin of b, moves the point by
d + w x (R_a_b v); so for a point off the origin the orientation of b matters.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.model.kinematics import relative_pose, relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.points import DEFAULT_STD
from bodyschema.senses.sense import Linearized, Sense, check_samples, counted

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Touches(Sense):
    """Positions of points that move with one frame, given in that frame at each sample."""

    position: Array = field(default_factory=lambda: np.empty((0, 3)))
    """(n, 3) m, in frame `seen_from`."""
    touching: Array = field(default_factory=lambda: np.empty((0, 3)))
    """(n, 3) m, the same points in frame `seen`."""

    def __post_init__(self) -> None:
        check_samples(self, self.position, (3,))
        check_samples(self, self.touching, (3,))

    @classmethod
    def make(
        cls,
        q: ArrayLike,
        position: ArrayLike,
        touching: ArrayLike,
        seen_from: str,
        seen: str,
        std: float = DEFAULT_STD,
        time: ArrayLike | None = None,
        rows: ArrayLike | None = None,
    ) -> Touches:
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
        """
        readings, times, numbers = counted(q, time, rows)
        v = np.asarray(touching, dtype=np.float64)
        return cls(
            time=times,
            q=readings,
            seen_from=seen_from,
            seen=seen,
            covariance=std**2 * np.eye(3),
            rows=numbers,
            position=np.atleast_2d(np.asarray(position, dtype=np.float64)),
            touching=np.tile(v, (len(readings), 1)) if v.ndim == 1 else v,
        )

    @property
    def components(self) -> tuple[tuple[str, str, slice], ...]:
        """One noise level for all three coordinates."""
        return (("position", "m", slice(0, 3)),)

    def residual(self, body: Body) -> Array:
        """Where it was felt minus where the body says that it is, (n, 3) m, in `seen_from`."""
        T_a_b = relative_pose(body, self.q, self.seen_from, self.seen)
        return np.asarray(self.position - T_a_b[..., :3, 3] - _turned(T_a_b, self.touching))

    def imagined(self, body: Body, q: ArrayLike) -> Self:
        """See `Sense.imagined`; the points that touch are taken in turn."""
        T_a_b = relative_pose(body, q, self.seen_from, self.seen)
        count = np.arange(len(T_a_b))
        v = self.touching[count % len(self)] if len(self) else np.zeros((len(count), 3))
        return replace(
            self,
            time=count.astype(np.float64),
            q=np.asarray(q),
            rows=count,
            position=T_a_b[..., :3, 3] + _turned(T_a_b, v),
            touching=v,
        )

    def linearize(self, reference: Body, variables: Variables, x: Array) -> Linearized:
        """See `Sense.linearize`."""
        D = relative_pose_derivatives(reference, variables, x, self.q, self.seen_from, self.seen)
        arm = _turned(D.pose, self.touching)
        residual = self.position - D.pose[:, :3, 3] - arm
        return Linearized(residual, -_moved(D.by_parameter, arm), -_moved(D.by_joint, arm))


def _turned(T_a_b: Array, v: Array) -> Array:
    """R_a_b v: (n, 4, 4), (n, 3) -> (n, 3)."""
    return np.asarray(np.einsum("nij,nj->ni", T_a_b[:, :3, :3], v))


def _moved(twist: Array, arm: Array) -> Array:
    """d + w x arm: twists (n, 6, m), arms (n, 3) -> (n, 3, m)."""
    d, w = twist[:, :3], twist[:, 3:]
    return np.asarray(d + np.cross(w, arm[:, :, None], axis=1))
