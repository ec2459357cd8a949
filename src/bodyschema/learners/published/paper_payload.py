"""Mass and centre of mass in the paper's form, by the published linear-relation learner.

For a load at rest with R the sensor's orientation in the world, f and tau the wrench and g gravity,

    A x = 0,   A = [[R f, 0, g], [0, -[f]x, -tau]]  (6 x 5),   x = [1/m, c, 1]       (Eq. 37, 38)

C = mean A^T A, x its smallest eigenvector scaled so that the last entry is 1. Identification ends
when lambda_5 is small and lambda_4 large; the paper gives no number, so both are settings. Offsets
of the sensor, its turn on its mount and acceleration have no place in the relation: it presumes
that the first two were removed before and that the arm moves slowly. The full form has them all
(`fit`). Where the text leaves a choice, each way is a reading of its own:

    printed         rows of different units as they stand, smallest eigenvector
    weighted        rows divided by the sensor's noise, smallest eigenvector
    least squares   the last entry is 1 from the start, as Eq. 38 says: not |x| = 1
    at rest         as printed, from samples at which the arm stands still ("low acceleration")
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.learners.learner import in_turn
from bodyschema.learners.published.linear_relation import Direction, Moments, PaperRelation

Array = NDArray[np.float64]

UNKNOWNS = 5

Reading = Literal["printed", "weighted", "least squares", "at rest"]
READINGS: tuple[Reading, ...] = ("printed", "weighted", "least squares", "at rest")

STILL = 0.04
"""rad/s below which the arm counts as standing: twice the noise of a usual encoder over 0.1 s."""

SPAN = 0.1
"""s over which that speed is taken."""


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
        return PaperLoad(moments, found.x if self.satisfied(found) else None), found

    def satisfied(self, found: Direction) -> bool:
        """Whether one direction alone is left."""
        return bool(found.squares[0] < self.smallest and found.squares[1] > self.second)

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


def paper_courses(
    A: Array, noise: Array, still: NDArray[np.bool_], reading: Reading = "printed"
) -> Array:
    """x after each sample in one of the readings, (n, 5), its last entry 1.

    Args:
        A: (n, 6, 5) of `paper_rows`.
        noise: (6,) N and Nm of the sensor.
        still: (n,) samples at which the arm stands, of `standing`.
        reading: of the module's text.
    """
    if reading == "weighted":
        A = A / noise[:, None]
    elif reading == "at rest":
        A = A * still[:, None, None]
    C = np.cumsum(np.einsum("nij,nik->njk", A, A), axis=0)
    if reading == "least squares":
        floor = 1e-12 * np.trace(C, axis1=1, axis2=2)[:, None, None] * np.eye(UNKNOWNS - 1)
        x = np.linalg.solve(C[:, :4, :4] + floor, -C[:, :4, 4:])[:, :, 0]
        return np.hstack([x, np.ones((len(x), 1))])
    v = np.linalg.eigh(C)[1][:, :, 0]
    return v / np.where(np.abs(v[:, 4:]) > 1e-12, v[:, 4:], 1e-12)


def standing(R_world_sensor: Array, time: Array) -> NDArray[np.bool_]:
    """(n,) whether the sensor turns slower than STILL around each sample.

    Args:
        R_world_sensor: (n, 3, 3).
        time: (n,) s, evenly spaced.
    """
    half = max(1, round(SPAN / 2 / float(np.median(np.diff(time)))))
    late = np.minimum(np.arange(len(time)) + half, len(time) - 1)
    early = np.maximum(np.arange(len(time)) - half, 0)
    turn = lie.log_so3(np.swapaxes(R_world_sensor[early], 1, 2) @ R_world_sensor[late])
    return np.asarray(np.linalg.norm(turn, axis=1) < STILL * (time[late] - time[early]))


def load_of(x: Array) -> tuple[float, Array]:
    """Mass, kg, and centre of mass (3,), m, of a scaled solution."""
    return float(1 / x[0]) if x[0] else np.inf, x[1:4]
