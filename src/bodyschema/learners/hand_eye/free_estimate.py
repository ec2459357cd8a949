"""The belief in X and Y of hand-eye calibration as that in two frames of a free hand.

So that it is an estimate like any other: with variables, noise by component, and a covariance that
the rest of the house reads. X and Y move by twists in their own frames (`pose_pairs`); the links of
variables are in the axes of the parent, L = R d, so the information is rotated once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from bodyschema.estimation.estimate import Estimate
from bodyschema.learners.hand_eye.full_poses import HandEye
from bodyschema.learners.hand_eye.pose_pairs import REACH
from bodyschema.model import parts
from bodyschema.model.tree import Body
from bodyschema.model.variables import UNKNOWN_TURN, free_frame, join
from bodyschema.senses.poses import Poses

SCALE, LAG = "eye_scale", "lag"
"""Parts of the body that keep the scale of the eye's lengths, and how late its clock is."""


@dataclass(frozen=True)
class Names:
    """What the frames are called."""

    base: str = "base"
    hand: str = "hand"
    eye: str = "eye"
    target: str = "target"


def hand_eye_estimate(found: HandEye, sense: Poses, described: Body, names: Names) -> Estimate:
    """The belief in X and Y as that in two frames of a free hand.

    Args:
        found: the answer.
        sense: what the eye saw, in true lengths.
        described: the free hand.
        names: of the frames.
    """
    moving, standing = ends(found, names)
    body = described.attach(moving, names.hand, found.X).attach(standing, names.base, found.Y)
    if found.scale != 1:
        body = body.with_part(SCALE, parts.target(found.scale))
    free = (
        free_frame(body, moving, REACH, UNKNOWN_TURN),
        free_frame(body, standing, 10 * REACH, UNKNOWN_TURN),
    )
    variables = join(*free)
    # Twists are taken in the frames' own axes, links in those of their parents.
    own = np.eye(12)
    own[:3, :3], own[6:9, 6:9] = found.X[:3, :3].T, found.Y[:3, :3].T
    information = own.T @ np.linalg.inv(found.covariance) @ own
    values, vectors = np.linalg.eigh(information - np.diag(variables.prior_std**-2.0))
    told = (vectors * values.clip(0.0)) @ vectors.T
    residual = sense.residual(body)
    good = found.weights / max(float(found.weights.sum()), 1e-12)
    sizes = [
        float(np.sqrt(good @ np.mean(residual[:, k] ** 2, axis=1)))
        for k in (slice(0, 3), slice(3, 6))
    ]
    believed = np.sqrt(np.diag(sense.covariance))[[0, 3]]
    noise = {
        f"{sense.label}: {name} ({unit})": size
        for (name, unit, _), size in zip(sense.components, sizes, strict=True)
    }
    levels = (tuple(float(size / std) for size, std in zip(sizes, believed, strict=True)),)
    weights = (np.maximum(found.weights, 1e-9),)
    return Estimate(body, variables, np.zeros(12), (told + told.T) / 2, noise, levels, weights)


def ends(found: HandEye, names: Names) -> tuple[str, str]:
    """The frame that the hand carries, and the one that stands."""
    ends = (names.eye, names.target)
    return ends if found.eye_on == "hand" else (ends[1], ends[0])
