"""Bodies of three axes: where a frame may be, where a load's mass is, where something touches.

A place of covariance C lies with 95 % inside the ellipsoid of half axes r sqrt(lambda_i) v_i, with
lambda_i and v_i of C and r^2 the 95 % quantile of chi-square with three degrees of freedom. A load
of mass m and principal moments I_i about its centre moves as a solid ellipsoid of even density with
half axes

    a_i^2 = 5 (I_j + I_k - I_i) / (2 m).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.estimation.estimate import Estimate
from bodyschema.model.kinematics import relative_pose, relative_pose_derivatives
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]

REACH95 = 2.7955
"""Three-dimensional normal: the radius that holds 95 %."""
MOST_SEEN = 8
"""Frames that are looked at whose ellipsoids are drawn."""


@dataclass(frozen=True)
class Ellipsoid:
    """One, in every posture."""

    name: str
    kind: str
    """"uncertainty", which is drawn larger than it is, or "load", drawn true to scale."""
    centre: Array
    """(n, 3) m, in the root frame."""
    axes: Array
    """(n, 3, 3) m: half axes as columns, in the root frame."""

    @property
    def widest(self) -> float:
        """m: the longest half axis in any posture."""
        return float(np.linalg.norm(self.axes, axis=1).max())


def uncertain_frames(
    estimate: Estimate, q: Array, pairs: Sequence[tuple[str, str]]
) -> tuple[Ellipsoid, ...]:
    """Where each frame may be, as seen from another, drawn at the frame.

    Args:
        estimate: the belief, as wide as it is believed.
        q: (n, n_joints) postures.
        pairs: (frame that looks, frame).
    """
    body, found = estimate.body, []
    for a, b in pairs:
        J = relative_pose_derivatives(
            estimate.reference, estimate.variables, estimate.x, q, a, b
        ).by_parameter[:, :3]
        R = relative_pose(body, q, body.frames[0], a)[:, :3, :3]
        C = R @ J @ estimate.covariance @ np.swapaxes(R @ J, 1, 2)
        centre = relative_pose(body, q, body.frames[0], b)[:, :3, 3]
        found.append(Ellipsoid(f"{b} from {a}", "uncertainty", centre, half_axes(C)))
    return tuple(found)


def looked_at(senses: Sequence[Sense], frames: Sequence[str]) -> list[tuple[str, str]]:
    """The pairs of frames that senses speak of, each once."""
    pairs = dict.fromkeys((s.seen_from, s.seen) for s in senses)
    return [pair for pair in pairs if set(pair) <= set(frames)][:MOST_SEEN]


def half_axes(covariance: ArrayLike) -> Array:
    """(*batch, 3, 3) m^2 -> half axes of the 95 % ellipsoid as columns, m."""
    values, vectors = np.linalg.eigh(np.asarray(covariance, dtype=np.float64))
    return np.asarray(vectors * (REACH95 * np.sqrt(np.maximum(values, 0.0)))[..., None, :])


def carried(load: Mapping[str, Any], T_root_link: Array) -> tuple[Ellipsoid, ...]:
    """A load as the even ellipsoid that moves like it; nothing where its mass is not told.

    Args:
        load: entry of the details of `payload`, with the load in the link's frame.
        T_root_link: (n, 4, 4) of the link that carries it.
    """
    mass, com = load["flange"]["mass"], np.array(load["flange"]["com"])
    if mass <= 0 or {one["what"] for one in load["not_told"]} & {"mass", "com"}:
        return ()
    values, vectors = np.linalg.eigh(np.array(load["flange"]["inertia"]))
    squares = 5 * (values.sum() - 2 * values) / (2 * mass)
    axes = vectors * np.sqrt(np.maximum(squares, 0.0))
    return (Ellipsoid(f"{load['name']} {mass:.3g} kg", "load", *_carried(com, axes, T_root_link)),)


def touched(touch: Mapping[str, Any], T_root_sensor: Array) -> tuple[Ellipsoid, ...]:
    """The places where one touch may be.

    Args:
        touch: entry of the details of `touch`.
        T_root_sensor: (n, 4, 4).
    """
    return tuple(
        Ellipsoid(
            f"touch at {touch['begins']:.2f} s, {100 * place['chance']:.0f} %",
            "uncertainty",
            *_carried(np.array(place["point"]), half_axes(place["covariance"]), T_root_sensor),
        )
        for place in touch["places"]
    )


def _carried(point: Array, axes: Array, T: Array) -> tuple[Array, Array]:
    return T[:, :3, :3] @ point + T[:, :3, 3], T[:, :3, :3] @ axes
