"""The parameter vector that turns one body into another: the chart of `variables` read backwards.

offset, gear, link, part    x = value - value_0
axis                        x = t B^T a / |B^T a|,    t = atan2(|B^T a|, a_0 . a)
turn                        x = log(R_0^T R)
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.kernels import AXIS, GEAR, LINK, OFFSET, TURN
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables

Array = NDArray[np.float64]


def deviation(reference: Body, body: Body, variables: Variables) -> Array:
    """x with `reference.with_variables(parameters, x)` equal to `body` in what is free.

    Args:
        reference: body at x = 0.
        body: the same tree with other numbers; what is not free in it plays no part.
        variables: what is free.

    Returns:
        (n_parameters,); axes less than pi apart, turns as well.
    """
    normal = np.einsum("kij,ki->kj", reference.tangents, body.axis)
    away = np.linalg.norm(normal, axis=1)
    t = np.arctan2(away, np.sum(reference.axis * body.axis, axis=1))
    tilt = normal * (t / np.where(away > 0, away, 1.0))[:, None]
    turned = np.swapaxes(reference.placement[:, :3, :3], 1, 2) @ body.placement[:, :3, :3]
    values = {
        OFFSET: (body.offset - reference.offset)[:, None],
        GEAR: (body.gear - reference.gear)[:, None],
        AXIS: tilt,
        LINK: body.placement[:, :3, 3] - reference.placement[:, :3, 3],
        TURN: lie.log_so3(turned),
    }
    x = np.zeros(len(variables))
    for code, value in values.items():
        rows = np.flatnonzero(variables.code == code)
        x[rows] = value[variables.index[rows], variables.component[rows]]
    for name, part in reference.parts.items():
        rows, numbers = variables.of_part(name)
        x[rows] = body.part(name).values[numbers] - part.values[numbers]
    return x
