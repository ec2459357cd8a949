"""What of a fit to pictures is kept: offsets that the pictures do not tell stay as modelled.

The others are what they are if that is right: with A the information of the estimate x, o what is
not told and d the rest,

    x_o = 0,    x_d + A_dd^-1 A_do x_o

An offset that goes together with the place of a camera is kept as it came: then the camera and the
robot that are written fit each other.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import Identifiability

PREFIX = "frame:"
"""Of the parameter group of a camera whose place was looked for."""

TOLD = 0.5
"""Share of a parameter's prior variance in open directions up to which it is told."""


def settled(estimate: Estimate, known: Identifiability) -> tuple[Estimate, tuple[str, ...]]:
    """The estimate as it is written, and the names of what stays as modelled.

    Args:
        estimate: of what was asked for.
        known: what the pictures tell of it.
    """
    variables = estimate.variables
    cameras = {
        name
        for name, group in zip(variables.names, variables.groups, strict=True)
        if group.startswith(PREFIX)
    }
    still = np.array(
        [
            share > TOLD and not cameras.intersection((name, *known.partners(name)))
            for name, share in zip(variables.names, known.open_share, strict=True)
        ],
        dtype=bool,
    )
    A, x = estimate.information, estimate.x.copy()
    x[~still] += np.linalg.solve(A[np.ix_(~still, ~still)], A[np.ix_(~still, still)] @ x[still])
    x[still] = 0.0
    return replace(estimate, x=x), tuple(variables.names[i] for i in np.flatnonzero(still))
