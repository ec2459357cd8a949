"""Carried points: where a point that one frame carries lies in another, and how it moves.

    p = t_a_b(q, x) + R_a_b(q, x) v          a = seen_from, b = seen, v fixed in b

A change by a twist (d, w) of T_a_b, taken at the origin of b, moves it by d + w x (R_a_b v). Points
touched, points in pictures, the ends of a wire and the tip on a table are all of this kind.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.model.kinematics import relative_pose, relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import PLACEMENT, Sense

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Carried:
    """A point in frame a, with its derivatives."""

    position: Array
    """(n, 3) m."""
    arm: Array
    """(n, 3) R_a_b v, m."""
    by_parameter: Array
    """(n, 3, n_parameters)."""
    by_joint: Array
    """(n, 3, n_joints)."""


def carried_position(body: Body, sense: Sense, v: Array) -> Array:
    """Points v (n, 3) of the frame that a sense sees, in the frame that it looks from, (n, 3) m."""
    T = relative_pose(body, sense.readings(body), sense.seen_from, sense.seen)
    return np.asarray(T[:, :3, 3] + _turned(T, v))


def carried(reference: Body, variables: Variables, x: Array, sense: Sense, v: Array) -> Carried:
    """The same of the body that deviates from the reference by x, with derivatives."""
    q = sense.readings(reference.with_variables(variables, x)) if sense.clock else sense.q
    D = relative_pose_derivatives(reference, variables, x, q, sense.seen_from, sense.seen)
    arm = _turned(D.pose, v)
    return Carried(
        D.pose[:, :3, 3] + arm, arm, _moved(D.by_parameter, arm), _moved(D.by_joint, arm)
    )


def each(point: ArrayLike | None, n: int) -> Array:
    """A point for each of n samples, (n, 3): the origin for None, one for all when it is (3,)."""
    if point is None:
        return np.zeros((n, 3))
    v = np.asarray(point, dtype=np.float64)
    return np.tile(v, (n, 1)) if v.ndim == 1 else v


def column(numbers: ArrayLike, n: int) -> Array:
    """A number for each of n samples, (n, 1), from as many or from one for all."""
    given = np.asarray(numbers, dtype=np.float64)
    return np.tile(given.reshape(-1, 1), (n, 1)) if given.size == 1 else given.reshape(-1, 1)


def shown(points: Array, but: Collection[str] = ()) -> tuple[str, ...]:
    """Components of a frame's placement that its points can show: no turn about the origin."""
    components = PLACEMENT if points.any() else PLACEMENT[:3]
    return tuple(name for name in components if name not in but)


def _turned(T_a_b: Array, v: Array) -> Array:
    """R_a_b v: (n, 4, 4), (n, 3) -> (n, 3)."""
    return np.asarray(np.einsum("nij,nj->ni", T_a_b[:, :3, :3], v))


def _moved(twist: Array, arm: Array) -> Array:
    """d + w x arm: twists (n, 6, m), arms (n, 3) -> (n, 3, m)."""
    d, w = twist[:, :3], twist[:, 3:]
    return np.asarray(d + np.cross(w, arm[:, :, None], axis=1))
