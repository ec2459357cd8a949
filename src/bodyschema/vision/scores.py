"""Scores of imagined bodies against what the cameras saw, behind one small interface.

A score takes the poses of many hypotheses and returns one number a hypothesis and view. The number
is a log likelihood up to a positive factor, which the learner sets (tempering, noise level); views
add up. The more the better:

    Overlap           log of the Jaccard index of imagined and observed mask
    Chamfer           minus the mean distance of the imagined contour to the mask's, pixels
    OrientedChamfer   minus the mean distance to an edge of the same direction, pixels; no mask
    Region            evidence of colour inside the silhouette, as a share of what there is; no mask

A body out of view, which says nothing about where it is, gets what a quite wrong one would: the log
of one pixel of overlap, minus the truncation distance, 0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.model.camera import Camera
from bodyschema.vision.colours import ObservedColours
from bodyschema.vision.contours import fit_contours
from bodyschema.vision.edge_image import ObservedEdges
from bodyschema.vision.observed import UNIT, ObservedMask
from bodyschema.vision.oriented import oriented_distances
from bodyschema.vision.region import sums_inside
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]


class Score(Protocol):
    """What a learner asks of a score."""

    def score(self, T_cam_piece: ArrayLike, threads: int = 1) -> Array:
        """Log likelihood up to a factor, finite, and the same for any number of threads.

        Args:
            T_cam_piece: (n_hypotheses, n_cameras, n_pieces, 3 or 4, 4), see `piece_poses`.
            threads: how many work.

        Returns:
            (n_hypotheses, n_cameras).
        """


@dataclass(frozen=True)
class Overlap:
    """Log of the Jaccard index; the likelihood of Vicente et al. 2016, Eq. 20, as it stands."""

    surface: Surface
    cameras: Sequence[Camera]
    seen: Sequence[ObservedMask]

    def score(self, T_cam_piece: ArrayLike, threads: int = 1) -> Array:
        """See `Score.score`."""
        fit = fit_contours(self.surface, T_cam_piece, self.cameras, self.seen, False, threads)
        union = np.maximum(fit.area + fit.observed - fit.inside, 1)
        return np.asarray(np.log(np.maximum(fit.inside, 1) / union))


@dataclass(frozen=True)
class Chamfer:
    """Minus the mean distance of the imagined outer contour to the contour of the mask."""

    surface: Surface
    cameras: Sequence[Camera]
    seen: Sequence[ObservedMask]

    def score(self, T_cam_piece: ArrayLike, threads: int = 1) -> Array:
        """See `Score.score`."""
        fit = fit_contours(self.surface, T_cam_piece, self.cameras, self.seen, True, threads)
        return -np.where(fit.boundary > 0, fit.chamfer, _truncations(self.seen))


@dataclass(frozen=True)
class OrientedChamfer:
    """Minus the mean distance of the imagined outer contour to edges of the same direction."""

    surface: Surface
    cameras: Sequence[Camera]
    seen: Sequence[ObservedEdges]

    def score(self, T_cam_piece: ArrayLike, threads: int = 1) -> Array:
        """See `Score.score`."""
        distance, number = oriented_distances(
            self.surface, T_cam_piece, self.cameras, self.seen, threads
        )
        mean = distance / (UNIT * np.maximum(number, 1))
        return -np.where(number > 0, mean, _truncations(self.seen))


@dataclass(frozen=True)
class Region:
    """Evidence of colour inside the silhouette, as a share of all that speaks for the body."""

    surface: Surface
    cameras: Sequence[Camera]
    seen: Sequence[ObservedColours]

    def score(self, T_cam_piece: ArrayLike, threads: int = 1) -> Array:
        """See `Score.score`."""
        tables = [seen.row_sums for seen in self.seen]
        inside = sums_inside(self.surface, T_cam_piece, self.cameras, tables, threads)
        return np.asarray(inside / np.array([max(seen.most, 1) for seen in self.seen]))


def _truncations(seen: Sequence[ObservedMask] | Sequence[ObservedEdges]) -> Array:
    """Largest distance in each view, (n_cameras,) pixels."""
    return np.array([view.truncation for view in seen])
