"""The pose of the hand in every picture, how sure it is, and whether that is the hand.

With x the offsets and the turns of the cameras and P their covariance from all key postures (see
`markerless`), at reading q

    T_cam_hand = K(q; x),      cov = J_x P J_x^T,      J_x of the twist of the hand in the camera

The picture itself is asked whether the outline is where K says: the share of the imagined contour
that is found, of all that shows and of the hand's own link, tells a hand that is hidden, out of
view, or another thing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.estimate import Estimate
from bodyschema.learners.images.markerless import COARSE_REACH, FINE_REACH, learn_colours
from bodyschema.learners.images.markerless_fit import MarkerlessFit, is_lost
from bodyschema.learners.images.rim_fit import RimModel, RimRows
from bodyschema.learners.images.sight import Sight
from bodyschema.model.kinematics import relative_pose_derivatives
from bodyschema.senses.images import Images
from bodyschema.vision.colours import ColourModel
from bodyschema.vision.surface import carrier

Array = NDArray[np.float64]


@dataclass(frozen=True)
class HandPose:
    """Where the hand is at one moment."""

    time: float
    """s"""
    pose: Array
    """(4, 4) T_cam_hand, in the first camera."""
    covariance: Array
    """(6, 6) of the twist (m, rad) in that camera, at the hand."""
    matched: float
    """Share of the imagined contour that was found within 2 pixels."""
    residual: float
    """Median distance of the found contour, pixels; inf if nothing was found."""
    lost: bool
    """Whether the pictures do not show the hand there."""


@dataclass(frozen=True)
class HandTracker:
    """A fitted body, asked picture by picture."""

    fit: MarkerlessFit
    hand: str
    """Frame whose pose is told."""
    colours: Sequence[ColourModel]
    """Of each camera; empty with masks."""

    @classmethod
    def of(cls, fit: MarkerlessFit, frames: Sequence[Images], hand: str) -> HandTracker:
        """From the fit and the pictures that it was made of.

        Raises:
            InputError: no such frame.
        """
        fit.model.body.frame_index(hand)
        masked = frames[0].masked
        return cls(fit, hand, () if masked else learn_colours(fit.model, fit.z, frames))

    def look(self, seen: Images) -> HandPose:
        """The hand at one moment."""
        fit = self.fit
        rows = fit.model.rows(Sight.of(seen, self.colours), fit.z, FINE_REACH[-1])
        return HandPose(
            seen.time,
            *hand_pose(fit.whole, seen.q, seen.cameras[0].frame, self.hand),
            rows.matched,
            float(np.median(np.abs(rows.left))) if len(rows.left) else np.inf,
            is_lost(min(rows.matched, self._of_hand(rows)), seen.masked),
        )

    def distance(self, seen: Images, z: Array) -> float:
        """Pixels that half of the outline lies within of the body by z (size,).

        What is farther away is looked for as far as a first guess may be off.
        """
        return outline_distance(self.fit.model, Sight.of(seen, self.colours), z)

    def _of_hand(self, rows: RimRows) -> float:
        """Share of the contour of the hand's own link that is found; 1 where it has no shape."""
        surface = self.fit.model.surface
        link = carrier(self.fit.model.body, self.hand)
        if link not in surface.frames:
            return 1.0
        piece = surface.frames.index(link)
        return float(rows.matches[:, piece].sum() / max(rows.lengths[:, piece].sum(), 1.0))


def outline_distance(model: RimModel, sight: Sight, z: Array) -> float:
    """Pixels that half of the outline by z (size,) lies within of what was seen.

    What is farther away is looked for as far as a first guess may be off.
    """
    near = model.rows(sight, z, FINE_REACH[-1]).distance(np.inf)
    if np.isfinite(near):
        return near
    return model.rows(sight, z, COARSE_REACH[0]).distance(COARSE_REACH[0])


def hand_pose(estimate: Estimate, q: Array, eye: str, hand: str) -> tuple[Array, Array]:
    """T_eye_hand (4, 4), and the covariance (6, 6) of its twist (m, rad) in the eye, at the hand.

    Args:
        estimate: of offsets and of the turns of cameras.
        q: (n_joints,) encoder readings.
        eye: frame of a camera.
        hand: frame.
    """
    D = relative_pose_derivatives(estimate.reference, estimate.variables, estimate.x, q, eye, hand)
    return D.pose, D.by_parameter @ estimate.covariance @ D.by_parameter.T
