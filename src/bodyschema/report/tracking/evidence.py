"""Evidence: what all sections on tracking are drawn from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.learners.images.hand_track import HandPose
from bodyschema.learners.images.markerless_fit import MarkerlessFit
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]


@dataclass(frozen=True)
class OverlayPicture:
    """A picture with the outline before and after."""

    says: str
    """What it is, for the caption."""
    jpeg: bytes


@dataclass(frozen=True)
class TrackEvidence:
    """A fit with what it was made from and what it says of every moment."""

    fit: MarkerlessFit
    kept: tuple[str, ...]
    """Variables that stay as modelled."""
    body: Body
    """As described, with the cameras where they were believed."""
    cameras: tuple[str, ...]
    """Their names; poses of the hand are in the first."""
    hand: str
    q: Array
    """(n_moments, n_joints)"""
    numbers: Sequence[int]
    """Of the first camera's pictures."""
    learned_from: Sequence[int]
    """Moments that the offsets were learned from."""
    poses: Sequence[HandPose]
    """Of the hand at every moment."""

    @cached_property
    def lost(self) -> Bools:
        """(n_moments,)"""
        return np.array([pose.lost for pose in self.poses], dtype=bool)

    @cached_property
    def matched(self) -> Array:
        """(n_moments,) share of the imagined contour that was found."""
        return np.array([pose.matched for pose in self.poses])

    @cached_property
    def residual(self) -> Array:
        """(n_moments,) pixels; nan where nothing was found."""
        found = np.array([pose.residual for pose in self.poses])
        return np.where(np.isfinite(found), found, np.nan)

    @cached_property
    def std(self) -> Array:
        """(n_moments, 2) of the hand in the first camera, worst direction: m and rad."""
        C = np.array([pose.covariance for pose in self.poses])
        blocks = np.stack([C[:, :3, :3], C[:, 3:, 3:]], axis=1)
        return np.sqrt(np.maximum(np.linalg.eigvalsh(blocks)[..., -1], 0.0))

    @cached_property
    def shift(self) -> Array:
        """(n_moments, 2) from the hand as it was believed in the first camera, m and rad."""
        before = relative_pose(self.body, self.q, self.cameras[0], self.hand)
        after = np.array([pose.pose for pose in self.poses])
        metres = np.linalg.norm(after[:, :3, 3] - before[:, :3, 3], axis=1)
        turn = lie.log_so3(after[:, :3, :3] @ np.swapaxes(before[:, :3, :3], 1, 2))
        return np.stack([metres, np.linalg.norm(turn, axis=1)], axis=1)

    @cached_property
    def learned(self) -> Bools:
        """(n_moments,) whether it was learned from."""
        return np.isin(np.arange(len(self.poses)), list(self.learned_from))
