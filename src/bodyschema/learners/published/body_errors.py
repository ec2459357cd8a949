"""Two ways of saying what is wrong with an arm, as numbers that particles can hold.

    joint offsets     T_eye_piece = K_piece(theta + beta)                            Eq. 3
    Cartesian error   T_eye_piece = T_eye_hand T_err T_eye_hand^-1 K_piece(theta),
                      T_eye_hand = K(theta), so that the hand stands at K(theta) T_err   Eq. 4

of Vicente, Jamone, Bernardino 2016. beta are angles; T_err is a shift and a turn, in the hand's
frame, of all that is seen of the arm: right where it was learned and nowhere else. Both are kept in
rad: a shift is divided by ARM, so that one prior and one noise serve all six numbers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema import lie
from bodyschema.model.camera import Camera
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.vision.poses import piece_poses

Array = NDArray[np.float64]

ARM = 0.3
"""m to a rad: a hand turned at this distance by an angle moves as far as a shift of that size."""


class BodyError(Protocol):
    """What is wrong with the arm, charted by numbers beta in rad."""

    @property
    def size(self) -> int:
        """How many numbers."""
        ...

    def piece_poses(
        self, body: Body, q: Array, beta: Array, cameras: Sequence[Camera], frames: Sequence[str]
    ) -> Array:
        """T_cam_piece (n, n_cameras, n_pieces, 4, 4) of hypotheses beta (n, size) at q (n_joints,).

        See `vision.poses.piece_poses`.
        """

    def hand_poses(self, body: Body, q: ArrayLike, beta: Array, eye: str, hand: str) -> Array:
        """T_eye_hand (n, 4, 4) of hypotheses beta (n, size) at q (n_joints,)."""


@dataclass(frozen=True)
class JointOffsets:
    """Eq. 3: true joint angle minus encoder reading."""

    joints: tuple[str, ...]
    """In the order of beta."""

    @property
    def size(self) -> int:
        """One for each joint."""
        return len(self.joints)

    def corrected(self, body: Body, q: ArrayLike, beta: Array) -> Array:
        """q + beta at the joints that are off, (n, n_joints)."""
        shifted = np.repeat(np.asarray(q, dtype=np.float64)[None], len(beta), axis=0)
        shifted[:, [body.joint_index(name) for name in self.joints]] += beta
        return shifted

    def piece_poses(
        self, body: Body, q: Array, beta: Array, cameras: Sequence[Camera], frames: Sequence[str]
    ) -> Array:
        """See `BodyError.piece_poses`."""
        return piece_poses(body, self.corrected(body, q, beta), cameras, frames)

    def hand_poses(self, body: Body, q: ArrayLike, beta: Array, eye: str, hand: str) -> Array:
        """See `BodyError.hand_poses`."""
        return relative_pose(body, self.corrected(body, q, beta), eye, hand)


@dataclass(frozen=True)
class CartesianError:
    """Eq. 4: T_err = (exp(beta[3:]), ARM beta[:3]) in the frame of the hand."""

    hand: str

    @property
    def size(self) -> int:
        """Shift and turn."""
        return 6

    def transforms(self, beta: Array) -> Array:
        """T_err (n, 4, 4) of beta (n, 6)."""
        return lie.transform(lie.exp_so3(beta[:, 3:]), ARM * beta[:, :3])

    def piece_poses(
        self, body: Body, q: Array, beta: Array, cameras: Sequence[Camera], frames: Sequence[str]
    ) -> Array:
        """See `BodyError.piece_poses`."""
        T = piece_poses(body, q, cameras, [*frames, self.hand])[0]
        T_cam_hand = T[:, -1:]
        seen_by_hand = lie.inverse(T_cam_hand) @ T[:, :-1]
        return np.asarray(T_cam_hand @ self.transforms(beta)[:, None, None] @ seen_by_hand)

    def hand_poses(self, body: Body, q: ArrayLike, beta: Array, eye: str, hand: str) -> Array:
        """See `BodyError.hand_poses`."""
        T_eye_hand = relative_pose(body, q, eye, self.hand)
        T_hand_seen = relative_pose(body, q, self.hand, hand)
        return np.asarray(T_eye_hand @ self.transforms(beta) @ T_hand_seen)
