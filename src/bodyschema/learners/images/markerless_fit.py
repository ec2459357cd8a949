"""What pictures without markers say of a body: estimate, fit, and whether it was found at all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import Identifiability
from bodyschema.learners.images.disagreement import Disagreement
from bodyschema.learners.images.doubts import PER_CAMERA
from bodyschema.learners.images.picture_weights import PictureWeights
from bodyschema.learners.images.rim_fit import RimModel
from bodyschema.learners.images.rim_information import without
from bodyschema.senses.images import Images
from bodyschema.vision.contours import fit_contours
from bodyschema.vision.observed import ObservedMask
from bodyschema.vision.poses import piece_poses

Array = NDArray[np.float64]

LOST, LOST_WITHOUT_MASKS = 0.6, 0.5
"""Share of the contour that must fit."""

MOST = 0.5
"""Share of the pictures that must count, or the majority speaks against the answer."""


@dataclass(frozen=True)
class MarkerlessFit:
    """What pictures say of a body."""

    model: RimModel
    z: Array
    """(size,) parameters, turns of the cameras, doubts."""
    whole: Estimate
    """Of the parameters and the turns of the cameras; what is left of z is marginalised."""
    matched: float
    """Share of the imagined contour that was found within 2 pixels, pictures by their weights."""
    residual: float
    """Median distance of the found contour, pixels, without the bias."""
    iou: float
    """Mean overlap with the masks; nan without masks."""
    identifiability: Identifiability
    weights: PictureWeights
    """How much each picture and each piece counted."""
    disagreement: Disagreement
    """How far moments and pieces contradict each other; its kappa is in the covariance."""

    @property
    def estimate(self) -> Estimate:
        """Of the parameters that were asked for, see `wanted_of`."""
        return wanted_of(self.model, self.whole)

    @property
    def bias(self) -> Array:
        """(n_cameras,) pixels that the seen outline lies outward of the body's."""
        n, cameras = len(self.model.variables), self.model.n_cameras
        return self.z[n : n + PER_CAMERA * cameras : PER_CAMERA]

    @property
    def masked(self) -> bool:
        """Whether it was made of masks."""
        return not np.isnan(self.iou)

    def without(self, k: int) -> Array:
        """z (size,) if moment k had not been learned from, to first order."""
        z = self.z.copy()
        live = self.model.scale > 0
        z[live] = self.model.scale[live] * self.disagreement.without(k)
        return z

    @property
    def agreed(self) -> bool:
        """Whether the body was found, and in most of the pictures."""
        there = np.isfinite(self.weights.pictures)
        return not self.lost and bool(self.weights.used[there].mean() > MOST)

    @property
    def lost(self) -> bool:
        """Whether the body is not where the estimate says, or something is before it."""
        return is_lost(self.matched, self.masked)


def wanted_of(model: RimModel, whole: Estimate) -> Estimate:
    """Of the parameters that were asked for, round a body whose cameras are turned as found."""
    n, free = len(model.wanted), model.variables
    body = model.body.with_variables(free.take(range(n, len(free))), whole.x[n:])
    said = without(whole.data_information, free.scale, n)
    return Estimate(body, model.wanted, whole.x[:n], said)


def overlap(model: RimModel, z: Array, frames: Sequence[Images]) -> float:
    """Mean Jaccard index over all pictures; nan without masks."""
    if not frames[0].masked:
        return float("nan")
    body, shares = model.posed(z), []
    for seen in frames:
        cameras = model.cameras(seen.cameras, z)
        T = piece_poses(body, seen.q, cameras, model.surface.frames)
        masks = [ObservedMask.of(picture) for picture in seen.pictures]
        shares.append(fit_contours(model.surface, T, cameras, masks, False).jaccard)
    return float(np.mean(shares))


def is_lost(matched: float, masked: bool) -> bool:
    """Whether so small a share of the contour tells that the body is not there."""
    return matched < (LOST if masked else LOST_WITHOUT_MASKS)
