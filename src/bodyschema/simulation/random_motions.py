"""Random small motions about one posture, with rests between them: how a robot looks for itself.

Each motion moves a random set of joints; each joint follows a minimum-jerk course

    s(x) = x^3 (10 - 15 x + 6 x^2),   x from 0 to 1,

over a part of the motion's length of its own, so that the joints do not move in proportion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

RATE = 30.0
"""Frames a second."""
SHORTEST, LONGEST = 0.5, 0.8
"""s, a motion."""
LEAST_REST, MOST_REST = 0.5, 0.7
"""s between motions."""
LEAD = 0.7
"""s of rest before the first motion and after the last one."""
PERTURBED = 0.1
"""Share by which a motion that is made again differs in width and length, at most."""
CONFIRMED = 3
"""Motions that make one with its confirmation: the motion, the way back, and once more."""


@dataclass(frozen=True)
class Motions:
    """A course of joint angles that can be asked at any time."""

    home: Array
    """(J,) rad where the first motion begins."""
    begin: Array
    """(M, J) s, when each joint begins in each motion."""
    length: Array
    """(M, J) s."""
    turn: Array
    """(M, J) rad; 0 for a joint that does not move."""
    end: Array
    """(M,) s, by when each motion is over."""

    @property
    def seconds(self) -> float:
        """From the first frame to the last."""
        return float(self.end[-1] + LEAD)

    def at(self, time: Array) -> Array:
        """(n, J) angles at times (n,)."""
        x = np.clip((time[:, None, None] - self.begin) / self.length, 0.0, 1.0)
        return np.asarray(self.home + np.sum(self.turn * x**3 * (10 - 15 * x + 6 * x * x), axis=1))


def draw_motions(home: Array, count: int, reach: Array, rng: np.random.Generator) -> Motions:
    """Motions of random joints to random places about home.

    Args:
        home: (J,) rad.
        count: number of motions.
        reach: (J,) rad; joints stay within home +- reach.
        rng: of joints, places, lengths and rests.
    """
    J = len(home)
    begin, length, turn = np.empty((count, J)), np.empty((count, J)), np.zeros((count, J))
    end, now, here = np.empty(count), LEAD, np.zeros(J)
    for m in range(count):
        whole = rng.uniform(SHORTEST, LONGEST)
        share = rng.uniform(0.7, 1.0, J)
        length[m], begin[m] = share * whole, now + rng.uniform(size=J) * (1 - share) * whole
        moved = rng.uniform(size=J) < 0.5
        moved[rng.integers(J)] = True
        # A joint that moves goes to the other side of home, so that every motion is seen.
        there = -np.where(here == 0, rng.choice([-1.0, 1.0], J), np.sign(here))
        there *= rng.uniform(0.3, 1.0, J) * reach
        turn[m] = np.where(moved, there - here, 0.0)
        here = here + turn[m]
        end[m] = now + whole
        now = end[m] + rng.uniform(LEAST_REST, MOST_REST)
    return Motions(home, begin, length, turn, end)


def with_confirmation(drawn: Motions, rng: np.random.Generator) -> Motions:
    """Each motion, then back to the posture where it began, then the motion again, perturbed.

    Args:
        drawn: (M, J) motions; they keep the places that they go to.
        rng: of perturbations and rests.

    Returns:
        3 M motions.
    """
    M, J = drawn.turn.shape
    begin, length, turn = (np.empty((CONFIRMED * M, J)) for _ in range(3))
    end, now, here = np.empty(CONFIRMED * M), LEAD, np.zeros(J)
    starts = np.concatenate([[LEAD], drawn.end[:-1]])
    places = np.cumsum(drawn.turn, axis=0)
    for m in range(M):
        # What came between the last motion and this one is a rest of all joints.
        first = max(float(starts[m]), float(drawn.end[m]) - LONGEST)
        way = np.where(drawn.turn[m] != 0, places[m] - here, 0.0)
        for part, sign in enumerate((1.0, -1.0, 1.0)):
            row, other = CONFIRMED * m + part, float(part > 0)
            turn[row] = sign * way * (1 + other * rng.uniform(-PERTURBED, PERTURBED, J))
            slower = 1 + other * rng.uniform(-PERTURBED, PERTURBED)
            begin[row] = now + slower * (drawn.begin[m] - first)
            length[row], end[row] = slower * drawn.length[m], now + slower * (drawn.end[m] - first)
            here = here + turn[row]
            now = end[row] + rng.uniform(LEAST_REST, MOST_REST)
    return Motions(drawn.home, begin, length, turn, end)
