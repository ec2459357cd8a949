"""The pose of the hand in every picture, how sure it is, and whether that is the hand.

With x the offsets and P their covariance from all key postures (see `markerless`), at reading q

    T_cam_hand = K(q; x),      cov = J_x P J_x^T,      J_x of the twist of the hand in the camera

The picture itself is asked whether the outline is where K says: the share of the imagined contour
that is found tells a hand that is hidden, out of view, or another thing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.body.kinematics import relative_pose_derivatives
from bodyschema.imagination.colours import ColourModel
from bodyschema.learning.images.markerless import FINE_REACH, MarkerlessFit, is_lost, learn_colours
from bodyschema.learning.images.rim_fit import RimModel, Sight
from bodyschema.senses.images import Images

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

    model: RimModel
    fit: MarkerlessFit
    hand: str
    """Frame whose pose is told."""
    colours: Sequence[ColourModel]
    """Of each camera; empty with masks."""

    @classmethod
    def of(
        cls, model: RimModel, fit: MarkerlessFit, frames: Sequence[Images], hand: str
    ) -> HandTracker:
        """From the fit and the pictures that it was made of.

        Raises:
            InputError: no such frame.
        """
        model.body.frame_index(hand)
        z = np.concatenate([fit.estimate.x, fit.bias])
        return cls(model, fit, hand, () if frames[0].masked else learn_colours(model, z, frames))

    def look(self, seen: Images) -> HandPose:
        """The hand at one moment."""
        estimate = self.fit.estimate
        D = relative_pose_derivatives(
            self.model.body,
            self.model.parameters,
            estimate.x,
            seen.q,
            seen.cameras[0].frame,
            self.hand,
        )
        z = np.concatenate([estimate.x, self.fit.bias])
        rows = self.model.rows(Sight.of(seen, self.colours), z, FINE_REACH[-1])
        left = np.abs(rows.d - rows.J @ np.concatenate([0 * estimate.x, self.fit.bias]))
        matched = rows.matched / max(rows.length, 1.0)
        return HandPose(
            seen.time,
            D.pose,
            D.by_parameter @ estimate.covariance @ D.by_parameter.T,
            matched,
            float(np.median(left)) if len(left) else np.inf,
            is_lost(matched, seen.masked),
        )
