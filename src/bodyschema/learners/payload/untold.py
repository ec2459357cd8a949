"""What the motion did not tell of a load, and which motion would.

A parameter is told when its standard deviation is small on the scale of the thing itself: mass
within 10 %, the centre of mass within 2 cm in every direction, each moment of inertia within half
of the largest. Everything else has a name and a remedy:

    mass          bias and weight are one as long as gravity points one way: tilt the sensor
    centre        along gravity it has no lever: turn gravity across that direction
    moments       need angular acceleration about that axis: swing the wrist about it

Where the weight hardly turns in the sensor, the mass rests on its small changes, and whatever errs
in step with them (drift, friction of cables, hysteresis) is multiplied: then it is not told,
however small the residuals are.
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

LEAST_SPAN = 0.12
"""Spread of gravity in the sensor, over itself, below which no mass is told beside an unknown
offset: turns of 10 degrees to either side. An error of a per cent in step makes 8 of mass."""

AXES = "xyz"


@dataclass(frozen=True)
class Untold:
    """One thing that is not known."""

    what: str
    """"mass", "com" or "I_xx" and so on."""
    sentence: str
    """What is not told, and the motion that would tell it."""


def untold(
    load: Inertia, P: Array, noise: Array | None = None, span: float = np.inf
) -> tuple[Untold, ...]:
    """Name everything that is left open of a load.

    Args:
        load: what was found.
        P: (10, 10) covariance of phi.
        noise: (10, 10) that of noise alone; P when None.
        span: spread of gravity along the sensor's axes over itself, where the offset is unknown.
    """
    found = []
    mass = float(np.sqrt(P[0, 0]))
    if mass > MASS * load.mass or span < LEAST_SPAN:
        found.append(Untold("mass", _mass_sentence(load, mass, noise, span)))
    values, directions = np.linalg.eigh(com_covariance(load, P))
    for value, direction in zip(values[::-1], directions.T[::-1], strict=True):
        if np.sqrt(value) > CENTRE:
            along = _named(direction)
            remedy = f"turn the sensor until gravity lies across {along}."
            if noise is not None:
                by_noise = float(direction @ com_covariance(load, noise) @ direction)
                remedy = remedy if by_noise > CENTRE**2 else ELSEWHERE
            found.append(
                Untold(
                    "com",
                    f"the centre of mass is known to ± {1e3 * np.sqrt(value):.2g} mm only along "
                    f"{along}: {remedy}",
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


ELSEWHERE = "not for want of motion: remove what is said under trust, then record again."


def _mass_sentence(load: Inertia, mass: float, noise: Array | None, span: float) -> str:
    if span < LEAST_SPAN:
        return (
            f"the mass is not told: gravity turned by {np.degrees(span):.1f} degrees only, so "
            f"that an error in step with it counts {1 / max(span, 1e-3):.0f}-fold: tilt the sensor "
            "by 30 degrees or more to either side."
        )
    if noise is not None and float(np.sqrt(noise[0, 0])) <= MASS * load.mass:
        return f"the mass is known to ± {mass:.2g} kg only, {ELSEWHERE}"
    return (
        f"the mass is known to ± {mass:.2g} kg only: tilt the sensor, so that weight and offset "
        "differ."
    )


def _named(direction: Array) -> str:
    """ "z" for a direction near an axis, else its components."""
    k = int(np.argmax(np.abs(direction)))
    if abs(direction[k]) > 0.95:
        return AXES[k]
    sign = np.sign(direction[k])
    return "(" + ", ".join(f"{sign * x:.2f}" for x in direction) + ")"
