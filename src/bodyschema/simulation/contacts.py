"""Contacts of an object with the world: where, how hard, how long, and of what kind.

A point contact pushes at one place of the surface, within its cone of friction; the push rises,
stays and falls, and its direction wanders a little. A soft contact also twists about the normal, as
a pad does that is turned. A moving one slides along the surface.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.solid import Solid

Array = NDArray[np.float64]

Kind = Literal["point", "soft", "moving"]

FRICTION = 0.4
"""Largest share of the push that acts along the surface."""

RISE = 0.1
"""s, until the push is whole."""

WANDER = 0.05
"""rad, standard deviation of the push's direction about its mean."""

PAD = (0.004, 0.010)
"""m, range of the couple of a soft contact over its push."""

NEAR = 1e-6
"""m: the same place."""

SLIDE = (0.05, 0.20)
"""m/s, range of the speed of a moving contact."""


@dataclass(frozen=True)
class Contact:
    """One touch, in the frame of the object's mount."""

    kind: Kind
    begins: float
    """s."""
    lasts: float
    """s."""
    point: Array
    """(3,) m, in the middle of its time."""
    force: Array
    """(3,) N on the object, at its mean direction."""
    sway: Array
    """(3,) rad, by which the direction turns and comes back once."""
    pitch: float
    """m, couple along the force over the force."""
    velocity: Array
    """(3,) m/s of the place."""

    def push(self, time: Array) -> Array:
        """Wrench on the object about the mount's origin, (n,) s -> (n, 6)."""
        since = time - self.begins
        height = np.clip(np.minimum(since, self.lasts - since) / RISE, 0.0, 1.0)
        turn = np.sin(2 * np.pi * since / self.lasts)[:, None] * self.sway
        f = height[:, None] * np.einsum("nij,j->ni", lie.exp_so3(turn), self.force)
        r = self.point + (since - self.lasts / 2)[:, None] * self.velocity
        return np.hstack([f, np.cross(r, f) + self.pitch * f])


def pushes(contacts: Sequence[Contact], time: Array) -> Array:
    """Wrench (n, 6) of all contacts together."""
    return np.asarray(sum((c.push(time) for c in contacts), np.zeros((len(time), 6))))


def draw_contact(
    solid: Solid,
    force: float,
    kind: Kind,
    begins: float,
    rng: np.random.Generator,
    hidden: bool = False,
) -> Contact:
    """A contact anywhere on the surface of an object.

    Args:
        solid: the object, in its mount's frame.
        force: N.
        kind: of the contact.
        begins: s.
        rng: of all the rest.
        hidden: where the line of force has passed another part of the object before, as inside a
            cup; else where it meets the object first.
    """
    lasts = rng.uniform(0.5, 1.0)
    while True:
        point, n = draw_point(solid, rng)
        sideways, turn = FRICTION * np.sqrt(rng.uniform()), rng.uniform(0, 2 * np.pi)
        T = lie.tangent_basis(n)
        f = T @ [sideways * np.cos(turn), sideways * np.sin(turn)] - n
        f /= np.linalg.norm(f)
        first = solid.pressed(f, point, f).points[0]
        if hidden == (np.linalg.norm(first - point) > NEAR):
            break
    pitch = rng.choice([-1.0, 1.0]) * rng.uniform(*PAD) if kind == "soft" else 0.0
    away, speed = rng.uniform(0, 2 * np.pi), rng.uniform(*SLIDE) if kind == "moving" else 0.0
    return Contact(
        kind=kind,
        begins=begins,
        lasts=lasts,
        point=point,
        force=force * f,
        sway=WANDER * rng.normal(size=3),
        pitch=pitch,
        velocity=speed * (T @ [np.cos(away), np.sin(away)]),
    )


def draw_point(solid: Solid, rng: np.random.Generator) -> tuple[Array, Array]:
    """A place (3,) m spread evenly over the surface, and its outward normal (3,)."""
    a, b, c = np.moveaxis(solid.corners, 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    m = rng.choice(len(area), p=area / area.sum())
    low, high = np.sort(rng.uniform(size=2))
    weights = np.array([low, high - low, 1 - high])
    return weights @ solid.corners[m], solid.normals[m]
