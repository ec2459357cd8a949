"""A belief over more parameters than were fitted, so that a plan can ask for them.

A calibration frees only what its recording can support; with few samples that may be the frames
alone. What then limits the tool is what was left out. The wider belief starts at the corrected body
with the priors of all parameters, and takes from the recording what it would have told of them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bodyschema.acting.information_gain import expected_jacobians
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.problem import moved_joints
from bodyschema.model.variables import free_joints, join
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]


def widen(estimate: Estimate, senses: Sequence[Sense], groups: Sequence[str]) -> Estimate:
    """The belief with these joint parameter groups free, and the frames that were free before.

    Args:
        estimate: what was fitted.
        senses: what was seen.
        groups: "offsets", "gears", "axes", "links".

    Raises:
        InputError: no such group.
    """
    old, body = estimate.variables, estimate.body
    frames = old.take([i for i, group in enumerate(old.groups) if group.startswith("frame:")])
    variables = join(free_joints(body, groups, moved_joints(body, senses)), frames)
    blank = np.zeros(len(variables))
    wide = Estimate(body, variables, blank, np.diag(blank), estimate.noise)
    total = np.diag(blank)
    for sense in senses:
        J = expected_jacobians(wide, [sense], sense.q, np.ones((len(sense), 1), dtype=bool))
        J = J.reshape(-1, len(variables)) / variables.scale
        total += J.T @ J
    return Estimate(body, variables, blank, total, estimate.noise)
