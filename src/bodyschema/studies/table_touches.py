"""The second half of the paper's experiment: the box in the hand is pressed on a table, many times.

Postures are drawn at random and the lift joint is turned until the lowest corner of the box stands
on the table; there the arm rests for a second while the table pushes up, within its friction. Where
the table is touched is then known in the world: the corner, on a plane.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from bodyschema.model.kinematics import relative_pose
from bodyschema.model.solid import Solid
from bodyschema.simulation.contacts import Contact
from bodyschema.simulation.katana import CENTRE, REACH, SPEED, katana
from bodyschema.simulation.loads import Path

Array = NDArray[np.float64]

TABLE = 0.10
"""m, height above the arm's base."""

CLEAR = 0.04
"""m above the table, between two touches."""

LIFT = 1
"""The joint that lowers the box."""

REST = 1.0
"""s on the table."""

FRICTION = 0.3


@dataclass(frozen=True)
class Presses:
    """A motion, and what touches meanwhile."""

    path: Path
    contacts: list[Contact]
    T_world_mount: Array
    """(n, 4, 4) while each contact lasts."""

    @property
    def seconds(self) -> float:
        """Until the last move has ended."""
        return float(self.path.start[-1] + self.path.length[-1])


def draw_presses(solid: Solid, count: int, force: float, rng: np.random.Generator) -> Presses:
    """Press the lowest corner on the table, `count` times, with a force in N, and go up again."""
    ways: list[Array] = []
    contacts: list[Contact] = []
    starts, lengths, poses = [], [], []
    now, speed = 0.5, 0.3 * SPEED
    while len(contacts) < count:
        above, down = _draw_posture(solid, rng)
        if not ways:
            ways.append(above)
        for there in (above, down):
            length = max(0.6, float(np.max(np.abs(there - ways[-1]) * 1.875 / speed)))
            starts.append(now)
            lengths.append(length)
            ways.append(there)
            now += length + 0.1
        T = relative_pose(katana(), down, "base", "hand")
        contacts.append(_pressed(solid, T, force, now, rng))
        poses.append(T)
        now += REST + 0.1
        starts.append(now)
        lengths.append(0.6)
        ways.append(above)
        now += 0.9
    return Presses(Path(np.array(starts), np.array(lengths), np.array(ways)), contacts,
                   np.array(poses))  # fmt: skip


def _draw_posture(solid: Solid, rng: np.random.Generator) -> tuple[Array, Array]:
    """A posture above the table, and the one with the box on it."""
    body = katana()

    def height(lift: float, q: Array) -> float:
        lowered = q.copy()
        lowered[LIFT] = lift
        T = relative_pose(body, lowered, "base", "hand")
        return float((solid.vertices @ T[2, :3] + T[2, 3]).min()) - TABLE

    while True:
        q = np.clip(CENTRE + rng.uniform(-1, 1, 5) * REACH, body.lower, body.upper)
        low, high = body.lower[LIFT], q[LIFT]
        if height(high, q) < CLEAR or height(low, q) > 0:
            continue
        down = q.copy()
        down[LIFT] = brentq(height, low, high, args=(q,))
        return q, down


def _pressed(
    solid: Solid, T: Array, force: float, begins: float, rng: np.random.Generator
) -> Contact:
    """The push of the table on the lowest corner, in the mount's frame."""
    corner = solid.vertices[np.argmin(solid.vertices @ T[2, :3])]
    slip, turn = FRICTION * np.sqrt(rng.uniform()), rng.uniform(0, 2 * np.pi)
    up = np.array([slip * np.cos(turn), slip * np.sin(turn), 1.0])
    f = force * (T[:3, :3].T @ up) / np.linalg.norm(up)
    none = np.zeros(3)
    return Contact("point", begins, REST, corner, f, none, 0.0, none)
