"""Two body schemas of one robot: what it expects to see, and what it is made of.

The subjective schema is right if every marker is seen where it is expected. The objective one is
compared joint by joint, at zero posture and in the frame that looks: the directions of the axes,
the lines on which they lie, and the centres of the joints on these lines.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import FIXED
from bodyschema.model.tree import Body
from bodyschema.report.skeleton_picture import places
from bodyschema.simulation.humanoid import EYE
from bodyschema.studies.self_watching import SelfWatching

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SchemaComparison:
    """How a learned body differs from the real one; largest values, unless said otherwise."""

    prediction: float
    """m: error of a marker in the postures tried."""
    axes: float
    """rad: angle between a learned and a real axis."""
    lines: float
    """m: distance of a joint's real centre from its learned axis."""
    centres: float
    """m: distance of a joint's centre from the real one, and"""
    centres_mean: float
    """m: its mean over the joints."""


def compare(watching: SelfWatching, learned: Body, q: Array) -> SchemaComparison:
    """Compare a learned body with the real one.

    Args:
        watching: the robot and what it saw.
        learned: the body that it learned.
        q: (n, n_joints) postures in which predictions are tried.
    """
    real = watching.body
    moving = real.kind != FIXED
    zero = np.zeros(len(real.joints))
    at, axis = (part[moving] for part in places(real, zero, EYE))
    thought_at, thought_axis = (part[moving] for part in places(learned, zero, EYE))
    apart = thought_at - at
    off_line = apart - np.sum(apart * thought_axis, axis=1, keepdims=True) * thought_axis
    # The sine is exact where the cosine is flat.
    angle = np.arctan2(
        np.linalg.norm(np.cross(axis, thought_axis), axis=1), np.sum(axis * thought_axis, axis=1)
    )
    distance = np.linalg.norm(apart, axis=1)
    return SchemaComparison(
        prediction=float(watching.errors(learned, q).max()),
        axes=float(angle.max()),
        lines=float(np.linalg.norm(off_line, axis=1).max()),
        centres=float(distance.max()),
        centres_mean=float(distance.mean()),
    )
