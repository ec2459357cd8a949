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
from bodyschema.body.parameters import free_joints, join
from bodyschema.learning.estimate import Estimate
from bodyschema.learning.problem import moved_joints
from bodyschema.senses.observations import Observations

Array = NDArray[np.float64]


def widen(estimate: Estimate, senses: Sequence[Observations], groups: Sequence[str]) -> Estimate:
    """The belief with these joint parameter groups free, and the frames that were free before.

    Args:
        estimate: what was fitted.
        senses: what was seen.
        groups: "offsets", "gears", "axes", "links".

    Raises:
        InputError: no such group.
    """
    old, body = estimate.parameters, estimate.body
    frames = old.take([i for i, group in enumerate(old.groups) if group.startswith("frame:")])
    parameters = join(free_joints(body, groups, moved_joints(body, senses)), frames)
    blank = np.zeros(len(parameters))
    wide = Estimate(body, parameters, blank, np.diag(blank), estimate.noise)
    total = np.diag(blank)
    for sense in senses:
        J = expected_jacobians(wide, [sense], sense.q, np.ones((len(sense), 1), dtype=bool))
        J = J.reshape(-1, len(parameters)) / parameters.scale
        total += J.T @ J
    return Estimate(body, parameters, blank, total, estimate.noise)
