"""Which posture would tell more of what the pictures left open."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.acting.telling_posture import TellingPosture
from bodyschema.model.kernels import REVOLUTE
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.report.page import render
from bodyschema.units import read_as, significant

Array = NDArray[np.float64]

MOST_GAINS = 3
GAIN = 0.9
"""Share of its standard deviation below which a parameter is named as gaining."""


@dataclass(frozen=True)
class NextPosture:
    """The posture, and what it would tell."""

    details: Mapping[str, Any]
    """Of the answer: "next_posture" and "gains"."""
    title: str = "Where to look next"

    def render(self) -> str:
        """See `Section`."""
        return render(
            "tracking/next_posture.html",
            posture=list(self.details["next_posture"].items()),
            gains=self.details["gains"],
        )


def posture_moves(telling: TellingPosture, body: Body, q: Array) -> dict[str, str]:
    """Joints that would move from the first posture, and their readings in deg or mm."""
    listed = {}
    for j in np.flatnonzero(telling.q != q[0]):
        turns = bool(np.any(body.kind[body.driver == j] == REVOLUTE))
        scale, unit = read_as("rad" if turns else "m")
        listed[body.joints[j]] = f"{scale * telling.q[j]:.0f} {unit}"
    return listed


def gains(telling: TellingPosture, variables: Variables) -> list[str]:
    """The parameters that would gain most."""
    share = telling.then / telling.std
    lines = []
    for i in np.argsort(share)[:MOST_GAINS]:
        scale, unit = read_as(variables.units[i])
        now, then = (significant(scale * float(s[i]), 2) for s in (telling.std, telling.then))
        if share[i] < GAIN:
            lines.append(f"{variables.names[i]} from ± {now} to ± {then} {unit}")
    return lines
