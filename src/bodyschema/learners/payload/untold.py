"""What the motion did not tell of a load, and which motion would.

A parameter is told when its standard deviation is small on the scale of the thing itself: mass
within 10 %, the centre of mass within 2 cm in every direction, each moment of inertia within half
of the largest. Everything else has a name and a remedy:

    mass          bias and weight are one as long as gravity points one way: tilt the sensor
    centre        along gravity it has no lever: turn gravity across that direction
    moments       need angular acceleration about that axis: swing the wrist about it
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.loads import SIX, com_covariance, moments_covariance
from bodyschema.model.inertia import Inertia

Array = NDArray[np.float64]

MASS, CENTRE, MOMENT = 0.10, 0.02, 0.5
"""Relative, m, and relative to the largest moment: one standard deviation of what is told."""

AXES = "xyz"


@dataclass(frozen=True)
class Untold:
    """One thing that is not known."""

    what: str
    """"mass", "com" or "I_xx" and so on."""
    sentence: str
    """What is not told, and the motion that would tell it."""


def untold(load: Inertia, P: Array) -> tuple[Untold, ...]:
    """Name everything that a load's covariance P (10, 10) leaves open."""
    found = []
    mass = float(np.sqrt(P[0, 0]))
    if mass > MASS * load.mass:
        found.append(
            Untold(
                "mass",
                f"the mass is known to ± {mass:.2g} kg only: tilt the sensor, so that weight "
                "and offset differ.",
            )
        )
    values, directions = np.linalg.eigh(com_covariance(load, P))
    for value, direction in zip(values[::-1], directions.T[::-1], strict=True):
        if np.sqrt(value) > CENTRE:
            along = _named(direction)
            found.append(
                Untold(
                    "com",
                    f"the centre of mass is known to ± {1e3 * np.sqrt(value):.2g} mm only along "
                    f"{along}: turn the sensor until gravity lies across {along}.",
                )
            )
    std = np.sqrt(np.diag(moments_covariance(load, P)))
    largest = float(np.diag(load.moments).max())
    hidden = [AXES[i] + AXES[j] for k, (i, j) in enumerate(SIX) if std[k] > MOMENT * largest]
    axes = ", ".join(sorted({axis for pair in hidden for axis in pair}))
    for pair in hidden:
        found.append(
            Untold(
                f"I_{pair}",
                f"of the moments of inertia {', '.join(hidden)} are not told: swing the wrist "
                f"about the sensor's {axes} axes, with quick changes of speed.",
            )
        )
    return tuple(found)


def _named(direction: Array) -> str:
    """ "z" for a direction near an axis, else its components."""
    k = int(np.argmax(np.abs(direction)))
    if abs(direction[k]) > 0.95:
        return AXES[k]
    sign = np.sign(direction[k])
    return "(" + ", ".join(f"{sign * x:.2f}" for x in direction) + ")"
