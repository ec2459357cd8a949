"""The posture whose pictures would tell most of what is still unknown of a body seen by cameras.

With A the information of an estimate x in units of its prior, and H_c what the imagined contour of
candidate c would add,

    c* = argmin_c  trace (A + H_c)^-1

over random postures in which the cameras see at least about as much of the body as they have seen
so far. Nothing is moved; what is free of the way there is not asked either.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.identifiability import random_postures
from bodyschema.learners.images.markerless_fit import MarkerlessFit
from bodyschema.learners.images.rim_information import LEAST_EFFECT, without
from bodyschema.model.camera import Camera

Array = NDArray[np.float64]

CANDIDATES = 120
MOVED = 1e-6
"""rad or m; readings that differ by less stand still."""
SEEN = 0.5
"""Share of the contour in the seen postures that must show in a candidate."""


@dataclass(frozen=True)
class TellingPosture:
    """Where to look next."""

    q: Array
    """(n_joints,) encoder readings."""
    std: Array
    """(n_parameters,) standard deviations now."""
    then: Array
    """(n_parameters,) after one more moment there."""


def telling_posture(
    fit: MarkerlessFit, cameras: Sequence[Camera], q: Array, seed: int = 0
) -> TellingPosture | None:
    """Look for it among random postures of the joints that are wanted or have moved.

    Args:
        fit: what is known.
        cameras: those that look.
        q: (n, n_joints) postures that were seen.
        seed: of the candidates.

    Returns:
        The posture; None if the cameras saw too little in all candidates.
    """
    estimate, model = fit.estimate, fit.model
    n, D = len(estimate.variables), estimate.variables.scale
    A = estimate.information * np.outer(D, D)
    wanted = [f"{joint}.offset" in estimate.variables.names for joint in model.body.joints]
    moves = np.array(wanted) | (np.ptp(q, axis=0) > MOVED)
    fresh = random_postures(model.body, CANDIDATES, np.random.default_rng(seed))
    best, least, found = None, np.inf, A
    needed = max(SEEN * float(np.median([_length(fit, cameras, row) for row in q[:5]])), 1.0)
    for candidate in np.where(moves, fresh, q[0]):
        if _length(fit, cameras, candidate) < needed:
            continue
        H = model.imagined(cameras, candidate, fit.z) / LEAST_EFFECT
        B = A + without(H, model.scale, n) / fit.disagreement.kappa * np.outer(D, D)
        trace = float(np.trace(np.linalg.inv(B)))
        if trace < least:
            best, least, found = candidate, trace, B
    if best is None:
        return None
    then = D * np.sqrt(np.diag(np.linalg.inv(found)))
    return TellingPosture(best, estimate.std, then)


def _length(fit: MarkerlessFit, cameras: Sequence[Camera], q: Array) -> float:
    """Pixels of contour that show, every eighth row and column."""
    rim, _ = fit.model.outline(cameras, q, fit.z, 8)
    return float(rim.length.sum())
