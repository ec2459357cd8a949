"""The load of a recording with the way down free: what a base that leans makes of a wrench.

A lean of some degrees is no small effect: the turn of the sensor and the load itself give way to
it, and a column that is right where the fit rests is wrong where it belongs. So the load is fitted
anew along the way. With z up,

    g(gamma) = 9.81 (gamma_x, gamma_y, -1) / sqrt(1 + |gamma|^2)        m/s^2, |gamma| = tan(lean)

and Gauss-Newton steps of gamma, the load free beside it (variable projection: Golub and Pereyra
1973), end where no lean is left to be seen. What is left there is compared with what other causes
leave, in the same noise (`wrench_rivals`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.payload.recorded import Part, PayloadFit, fit_payload
from bodyschema.senses.wrenches import load_regressor
from bodyschema.trust.wrench_rivals import GRAVITY, WrenchRival, tilts, way_down
from bodyschema.trust.wrench_rows import WrenchRows

Array = NDArray[np.float64]

STEPS, RESTED = 10, 1e-4
"""Most steps of gamma, and the length of one (rad) after which no more are made."""

BOLDEST = 0.5
"""Length of gamma that one step may go: half of what tells 27 degrees from none."""


@dataclass(frozen=True)
class Lean:
    """Where gravity points by the wrench itself."""

    gamma: Array
    """(2,) towards x and y of the world."""
    fit: PayloadFit
    """Of the load under it."""
    R_world: Array
    """(n, 3, 3) see `wrench_rivals`."""

    def rows(self, learner: LoadLearner) -> tuple[WrenchRows, WrenchRival]:
        """All means under it, and what a further change of gamma does to them."""
        rows = WrenchRows.of(self.fit, learner)
        return rows, WrenchRival("tilt", tilts(rows, self.R_world, self.gamma))


def lean(fit: PayloadFit, learner: LoadLearner, R_world: Array) -> Lean | None:
    """Find it.

    Args:
        fit: of a recording, as gravity is declared.
        learner: with the priors of the sensor.
        R_world: (n, 3, 3) of all means, see `wrench_rivals`.

    Returns:
        None where the steps do not come to rest, or no load is possible on their way.
    """
    found = Lean(np.zeros(2), fit, R_world)
    for _ in range(STEPS):
        step = _step(found, learner)
        step *= min(1.0, BOLDEST / max(float(np.linalg.norm(step)), 1e-12))
        gamma = found.gamma + step
        try:
            parts = _under(fit.parts, R_world, way_down(gamma) - way_down(np.zeros(2)))
            found = Lean(gamma, fit_payload(parts, learner), R_world)
        except InputError:
            return None
        if np.linalg.norm(step) < RESTED:
            return found
    return None


def _step(found: Lean, learner: LoadLearner) -> Array:
    """(2,) the best change of gamma, the load and the sensor free beside it."""
    everything, rival = found.rows(learner)
    rows, Z = everything.take(everything.counts), rival.take(everything.counts).Z
    effect = rows.left_of(Z / rows.sigma[:, None])
    left = rows.left_of(rows.z[:, :, None])[:, 0]
    return np.asarray(np.linalg.lstsq(effect, left, rcond=None)[0])


def _under(parts: Sequence[Part], R_world: Array, change: Array) -> list[Part]:
    """The parts with another way down: a change (3,) of its unit vector in the world."""
    out, a = [], 0
    for part in parts:
        g = GRAVITY * np.einsum("nji,j->ni", R_world[a : a + len(part.means)], change)
        Y = part.means.Y + load_regressor(-g, np.zeros_like(g), np.zeros_like(g))
        out.append(replace(part, means=replace(part.means, Y=Y)))
        a += len(part.means)
    return out
