"""Poses: a frame seen as a full pose, such as a marker, or a board seen by a wrist camera.

    residual  r = (t - t_a_b, log(R R_a_b^T))      a = seen_from, b = seen, T = (R, t) as seen

both in frame a. A rotation error log(R R'^T) has the derivative -J_left(r)^-T w under a twist w
of the prediction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.kinematics import relative_pose, relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Linearized, Sense, check_samples

Array = NDArray[np.float64]

DEFAULT_STD = (1e-3, 5e-3)
"""m and rad per axis, where the user states no noise."""


@dataclass(frozen=True)
class Poses(Sense):
    """Poses of one frame: (n, 4, 4) T_seen_from_seen as seen."""

    measures = (("position", "m", 3), ("rotation", "rad", 3))

    def __post_init__(self) -> None:
        check_samples(self, self.observed, (4, 4))
        R = self.pose[:, :3, :3]
        skewed = (np.abs(R @ np.swapaxes(R, 1, 2) - np.eye(3)) > 1e-3).any(axis=(1, 2))
        skewed |= np.linalg.det(R) < 0
        if skewed.any():
            raise InputError(
                f"{self.label}: the rotation in row {self.rows[np.argmax(skewed)]} is no rotation "
                "matrix (columns must be orthonormal and right-handed); check the column order "
                "and the layout."
            )
        # A transposed pose has a rotation too; its translation lies in the last row.
        turned = (np.abs(self.pose[:, 3] - [0.0, 0.0, 0.0, 1.0]) > 1e-6).any(axis=1)
        if turned.any():
            raise InputError(
                f"{self.label}: the last row of the pose in row {self.rows[np.argmax(turned)]} is "
                "not 0 0 0 1; give T row by row, translation in the last column."
            )

    @classmethod
    def make(  # type: ignore[override]
        cls,
        q: ArrayLike,
        pose: ArrayLike,
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
            pose: (n, 4, 4) T_seen_from_seen, or scipy's RigidTransform.
            seen_from: frame that looks, or that the pose is given in.
            seen: frame whose pose it is.
            std: noise of each coordinate (m) and of each rotation component (rad).
            time: (n,) s; 0, 1, 2, ... when None.
            rows: (n,) row numbers for messages; 0, 1, 2, ... when None.
            more: `stated`, `clock`, `rate`.
        """
        seen_as = lie.matrices(pose).reshape(-1, 4, 4)
        return super().make(q, seen_as, seen_from, seen, std, time, rows, **more)

    @property
    def pose(self) -> Array:
        """(n, 4, 4) T_seen_from_seen as seen."""
        return self.observed

    @property
    def label(self) -> str:
        """Name for messages and reports, other than that of points of the same frame."""
        return f"pose of {self.seen} seen from {self.seen_from}"

    def predict(self, body: Body) -> Array:
        """Where the frame would be seen, (n, 4, 4)."""
        return relative_pose(body, self.readings(body), self.seen_from, self.seen)

    def residual(self, body: Body) -> Array:
        """Seen minus predicted, (n, 6) m and rad, in `seen_from`."""
        return self._error(self.predict(body))

    def linearize(self, reference: Body, variables: Variables, x: Array) -> Linearized:
        """See `Sense.linearize`."""
        q = self.readings(reference.with_variables(variables, x)) if self.clock else self.q
        D = relative_pose_derivatives(reference, variables, x, q, self.seen_from, self.seen)
        residual = self._error(D.pose)
        back = -np.swapaxes(lie.inverse_left_jacobian(residual[:, 3:]), 1, 2)
        by_parameter, by_joint = -D.by_parameter, -D.by_joint
        by_parameter[:, 3:] = back @ D.by_parameter[:, 3:]
        by_joint[:, 3:] = back @ D.by_joint[:, 3:]
        return self.late(Linearized(residual, by_parameter, by_joint), variables)

    def _nothing(self, n: int) -> Self:
        fields = self._zeros(n)
        return replace(self, **{**fields, "observed": np.tile(np.eye(4), (n, 1, 1))})

    def _error(self, predicted: Array) -> Array:
        turned = self.pose[:, :3, :3] @ np.swapaxes(predicted[:, :3, :3], 1, 2)
        shifted = self.pose[:, :3, 3] - predicted[:, :3, 3]
        return np.concatenate([shifted, lie.log_so3(turned)], axis=1)
