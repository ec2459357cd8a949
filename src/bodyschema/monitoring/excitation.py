"""Was the motion worth watching? What hand and eye cannot tell, and the motion that would.

A world axis a about which alone the hand turns stays fixed in it: (R_h - mean R_h)^T a = 0.
So the eigenvalues of

    S = mean (R_h - mean R_h)(R_h - mean R_h)^T

are the mean squared sway of three world axes, and the eigenvector of the smallest is the axis about
which the hand turned most alone. While it is near zero, camera and point may slide along that axis
together, and if the hand turned about one line in space only, also turn about it: no number of
samples tells. Turning the hand about any other axis does. S is read from the sums of
`point_memory`, where the hand's rotations stand in the rows of the vertical pixel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.hand_eye.point_memory import PointMemory

Array = NDArray[np.float64]

LITTLE = 0.05
"""rad: sway below which an axis counts as still."""


class Turning(NamedTuple):
    """How much the world's axes swayed as the hand saw them."""

    sway: Array
    """(3,) rad, root mean square, smallest first."""
    axes: Array
    """(3, 3) the world axes, unit columns in the same order."""


def turning(memory: PointMemory) -> Turning:
    """How the hand turned in the moments behind the sums."""
    C = memory.C.sum(axis=0)
    weight = max(float(C[37, 37]), 1e-300)
    S = np.zeros((3, 3))
    for k in range(3):
        at = slice(12 + 9 * k, 15 + 9 * k)
        mean = -C[at, 37] / weight
        S += C[at, at] / weight - np.outer(mean, mean)
    values, axes = np.linalg.eigh(S)
    return Turning(np.sqrt(np.maximum(values, 0.0)), axes)


def missing_motion(memory: PointMemory) -> str:
    """A sentence on the motion that is missing; "" when the hand turned about two axes or more."""
    if not memory.count:
        return "nothing was seen yet: bring the point into view."
    found = turning(memory)
    if found.sway[2] < LITTLE:
        return (
            "the hand has hardly turned: turn it about two axes that are not parallel, "
            f"by more than {np.degrees(4 * LITTLE):.0f} degrees."
        )
    if found.sway[0] >= LITTLE:
        return ""
    x, y, z = found.axes[:, 0] * np.sign(found.axes[np.argmax(np.abs(found.axes[:, 0])), 0])
    return (
        f"the hand has turned about the world axis ({x:.2f}, {y:.2f}, {z:.2f}) only; camera and "
        "point may slide along it together: turn the hand about another axis."
    )
