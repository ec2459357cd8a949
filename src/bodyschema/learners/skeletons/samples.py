"""Samples of a seen point, in the form in which a skeleton takes them.

A skeleton has all frames parallel to the root at zero posture, so a point x of frame a that is
turned by R0_a there becomes R0_a x; see `model.skeleton`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.model import kernels
from bodyschema.model.kinematics import path_between
from bodyschema.model.tree import Body
from bodyschema.senses.points import Points
from bodyschema.senses.sense import Sense
from bodyschema.senses.touches import Touches

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class SkeletonSamples:
    """Points of the last node of one path, seen from its first."""

    path: Ints
    """Nodes from the frame that looks to the one that carries the point."""
    climbed: int
    """How many of them go up."""
    theta: Array
    """(n, n_frames) joint values at the nodes."""
    v: Array
    """(n, 3) m, the points in their own node."""
    x: Array
    """(n, 3) m, where they were seen."""

    @classmethod
    def of(cls, sample: Sense, body: Body, R0: Array) -> SkeletonSamples:
        """Samples of Points or Touches.

        Args:
            sample: what was seen.
            body: gives the tree, gears and offsets.
            R0: (n_frames, 3, 3) its `zero_rotations`.

        Raises:
            InputError: another sense, or joint positions that do not fit the body.
        """
        if not isinstance(sample, Points | Touches):
            raise InputError(
                f"{sample.label}: a skeleton is learned from Points and Touches, "
                f"got {type(sample).__name__}; give their positions as Points."
            )
        n, joints = sample.q.shape
        if joints != len(body.joints):
            raise InputError(
                f"{sample.label}: expected q with {len(body.joints)} columns "
                f"({', '.join(body.joints)}), got {joints}."
            )
        path, climbed = path_between(body, sample.seen_from, sample.seen)
        theta = np.zeros((n, len(body.frames)))
        q = np.ascontiguousarray(sample.q)
        kernels.joint_values(q, body.gear, body.offset, body.driver, body.rate, body.shift, theta)
        a, b = body.frame_index(sample.seen_from), body.frame_index(sample.seen)
        v = sample.touching @ R0[b].T if isinstance(sample, Touches) else np.zeros((n, 3))
        return cls(path, climbed, theta, v, sample.position @ R0[a].T)
