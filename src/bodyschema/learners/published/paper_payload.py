"""Mass and centre of mass in the paper's form, by the published linear-relation learner.

For a load at rest with R the sensor's orientation in the world, f and tau the wrench and g gravity,

    A x = 0,   A = [[R f, 0, g], [0, -[f]x, -tau]]  (6 x 5),   x = [1/m, c, 1]       (Eq. 37, 38)

C = mean A^T A, x its smallest eigenvector scaled so that the last entry is 1. The rows have
different units and are taken as they are printed. Identification ends when lambda_5 is small and
lambda_4 large; the paper gives no number, so both are settings. Offsets of the sensor and
acceleration have no place in the relation: this is what the full form adds (`fit`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.learners.learner import in_turn
from bodyschema.learners.published.linear_relation import Direction, Moments, PaperRelation

Array = NDArray[np.float64]

UNKNOWNS = 5


@dataclass(frozen=True)
class PaperLoad:
    """State: what was seen, and the answer once the identification has ended."""

    moments: Moments
    x: Array | None = None
    """(5,) while observing; None while identifying."""


@dataclass(frozen=True)
class PaperPayload:
    """The published identification of a held object."""

    smallest: float = 0.5
    """lambda_5 must be below it; N^2 and (m/s^2)^2 mixed as printed."""
    second: float = 1.0
    """lambda_4 must be above it."""
    every: int = 1
    """Samples between two decompositions."""

    def start(self) -> PaperLoad:
        """Nothing seen yet."""
        return PaperLoad(Moments.empty(UNKNOWNS))

    def step(
        self, state: PaperLoad, moment: tuple[Array, ...]
    ) -> tuple[PaperLoad, tuple[Direction | None, ...]]:
        """The state after the rows (6, 5) of one moment, and the direction if it was looked at."""
        return in_turn(self._look, state, moment)

    def _look(self, state: PaperLoad, A: Array) -> tuple[PaperLoad, Direction | None]:
        moments = state.moments.add(A)
        if state.x is not None or moments.count % self.every:
            return PaperLoad(moments, state.x), None
        found = self.solve(moments)
        ended = found.squares[0] < self.smallest and found.squares[1] > self.second
        return PaperLoad(moments, found.x if ended else None), found

    def solve(self, moments: Moments) -> Direction:
        """The smallest direction, its last entry 1."""
        return PaperRelation(UNKNOWNS, rotation=False, scale="last").solve(moments)


def paper_rows(R_world_sensor: Array, force: Array, torque: Array, down: Array) -> Array:
    """A of the module's text, (n, 6, 5).

    Args:
        R_world_sensor: (n, 3, 3).
        force: (n, 3) N, by the sensor on the object.
        torque: (n, 3) Nm.
        down: (3,) m/s^2, gravity in the world.
    """
    A = np.zeros((len(force), 6, UNKNOWNS))
    A[:, :3, 0] = np.einsum("nij,nj->ni", R_world_sensor, force)
    A[:, :3, 4] = down
    A[:, 3:, 1:4] = -lie.skew(force)
    A[:, 3:, 4] = -torque
    return A


def load_of(x: Array) -> tuple[float, Array]:
    """Mass, kg, and centre of mass (3,), m, of a scaled solution."""
    return float(1 / x[0]) if x[0] else np.inf, x[1:4]
