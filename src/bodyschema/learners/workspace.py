"""How what senses would see, anywhere in the joint ranges, moves with the variables of a body."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.belief import Slopes
from bodyschema.estimation.identifiability import random_postures
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]

POSTURES = 24
"""Random postures that stand for the workspace."""


def prediction_slopes(
    senses: Iterable[Sense], reference: Body, variables: Variables, x: Array
) -> dict[str, Slopes]:
    """Component -> slope of its prediction in the workspace, of all senses that show it.

    Args:
        senses: one of each kind; samples in them do not matter.
        reference: of the variables.
        variables: that are believed.
        x: where slopes are taken.
    """
    q = random_postures(reference, POSTURES, np.random.default_rng(0))
    found: dict[str, Slopes] = {}
    for sense in senses:
        J = sense.imagined(reference, q).linearize(reference, variables, x).by_parameter
        for name, unit, rows in sense.components:
            same = [found[name].J] if name in found else []
            found[name] = Slopes(np.concatenate([*same, J[:, rows]]), unit)
    return found
