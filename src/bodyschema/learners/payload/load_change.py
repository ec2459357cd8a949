"""What happened to a held load, from what was believed of it before and after.

grasp     heavier than before, which was the lightest load known, or the tool alone
release   lighter, back to that
swap      another object: both are heavier than the tool alone
shift     the same mass elsewhere
same      the same load: something touched it
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from bodyschema.estimation.loads import com_covariance
from bodyschema.learners.payload.fit import Solution
from bodyschema.model.inertia import Inertia

LoadChange = Literal["grasp", "release", "swap", "shift", "same"]

CLEAR = 4.0
"""Standard deviations that make a difference."""

SLIGHT = 0.02
"""Share of the mass that is no difference: what grasping itself does to a sensor's scale."""

LEAST = 1e-3
"""m by which a centre of mass must have moved."""


def load_change(before: Solution, after: Solution, tool: Inertia | None) -> LoadChange:
    """Name the difference of two loads.

    Args:
        before: the solution before the change.
        after: the solution now.
        tool: what hangs on the sensor when nothing is held; None if nobody knows.
    """
    old, new = before.guess.load(0), after.guess.load(0)
    P_old, P_new = before.phi_covariance(0), after.phi_covariance(0)
    if not _differs(new.mass, old.mass, P_new[0, 0] + P_old[0, 0], 0.1 * SLIGHT):
        C = com_covariance(old, P_old) + com_covariance(new, P_new)
        step = new.com - old.com
        moved = float(step @ np.linalg.solve(C, step)) > CLEAR**2 + 3
        return "shift" if moved and float(np.linalg.norm(step)) > LEAST else "same"
    bare = None if tool is None else tool.mass
    if bare is None or not _differs(old.mass, bare, P_old[0, 0], SLIGHT):
        return "grasp" if new.mass > old.mass else "release"
    if not _differs(new.mass, bare, P_new[0, 0], SLIGHT) or new.mass < bare:
        return "release"
    return "swap"


def _differs(mass: float, other: float, variance: float, slight: float) -> bool:
    """Whether two masses differ by more than doubt and scale explain."""
    margin = CLEAR * float(np.sqrt(variance)) + slight * max(mass, other)
    return abs(mass - other) > margin
