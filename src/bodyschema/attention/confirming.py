"""When to stop looking, and which motion would settle the doubt that is left.

A motion d (J,) would move a cell that is me by K d. By the belief about K it has the energy

    m = |E[K] d|^2 + 2 d^T V d,    V the covariance of a row of K, in units of noise,

and tells about ln(1 + m) nats. The doubt of a cell is P (1 - P), so a motion is worth

    sum over cells of P (1 - P) ln(1 + m).

Compared are each joint alone, by as far as it usually turns, and the last motion once more. A joint
that has not moved yet has a wide V: it comes first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.attention.body_in_view import NextMotion

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

USUAL = 0.1
"""rad or m; by how far a joint is thought to turn that has not moved yet."""
MOTIONS_A_JOINT = 2
"""Motions that each joint must have made before it is enough."""
UNSURE = 0.38
"""A cell is in doubt whose probability is nearer to one half than this."""
MOST_UNSURE = 0.1
"""Doubtful cells to cells that are me, at most, when it is enough."""
LAG_KNOWN = 0.02
"""s; standard deviation of the lag that is good enough."""


@dataclass(frozen=True)
class Moved:
    """State: how the joints have moved so far."""

    motions: Ints
    """(J,) number of motions in which each joint turned."""
    squares: Array
    """(J,) rad^2, sum of squared turns over those."""
    last: Array
    """(J,) rad, turns of the last motion."""

    def usual(self) -> Array:
        """(J,) root mean square of each joint's turns."""
        mean = self.squares / np.maximum(self.motions, 1)
        return np.asarray(np.where(self.motions > 0, np.sqrt(mean), USUAL))


def with_motion(state: Moved, turns: Array, least: float) -> Moved:
    """With one more motion; turns (J,) rad, those below `least` do not count."""
    turned = np.abs(turns) > least
    squares = state.squares + np.where(turned, turns**2, 0.0)
    return Moved(state.motions + turned, squares, turns)


def verdict(
    P: Array, mask: NDArray[np.bool_], seen: Array, moved: Moved, lag_sd: float,
    joints: Sequence[str], own: Ints,
) -> tuple[bool, str]:  # fmt: skip
    """Whether it is enough, and why.

    Args:
        P: (N,) probability of each cell.
        mask: (N,) cells called me.
        seen: (N,) texture, 0 to 1; cells without any cannot be told.
        moved: how the joints have moved.
        lag_sd: s.
        joints: names.
        own: joints that move the body.
    """
    rare = [joints[i] for i in own if moved.motions[i] < MOTIONS_A_JOINT]
    doubt = int(np.sum((np.abs(P - 0.5) < UNSURE) & (seen > 0.5)))
    if not moved.motions.any():
        return False, "no joint has moved yet."
    if not mask.any():
        return False, "nothing in view moves with the joints so far."
    if rare:
        return False, f"moved in fewer than {MOTIONS_A_JOINT} motions: {', '.join(rare)}."
    if doubt > MOST_UNSURE * int(mask.sum()):
        return False, f"{doubt} cells are in doubt beside {int(mask.sum())} that are me."
    if not lag_sd < LAG_KNOWN:
        return False, "the delay of the camera is not known well yet."
    return True, f"{doubt} cells are in doubt beside {int(mask.sum())} that are me."


def next_motion(
    P: Array, seen: Array, K: Array, V: Array, moved: Moved, joints: Sequence[str], own: Ints
) -> NextMotion:
    """The motion that would settle most.

    Args:
        P: (N,) probabilities.
        seen: (N,) texture, 0 to 1.
        K: (N, 2, J) in units of noise per rad.
        V: (J, J) covariance of its rows.
        moved: how the joints have moved.
        joints: names.
        own: joints that move the body.
    """
    usual = moved.usual()
    single = [usual[i] * np.eye(len(joints))[i] for i in own]
    worth = np.array([_worth(P, seen, K, V, d) for d in [moved.last, *single]])
    if worth[0] >= worth[1:].max() and moved.last[own].any():
        joint = joints[int(own[np.argmax(np.abs(moved.last[own]))])]
        return NextMotion("repeat", joint, "what it moved is in doubt, and it would move it again.")
    joint = joints[int(own[np.argmax(worth[1:])])]
    fresh = moved.motions[joints.index(joint)] == 0
    why = "it has not moved yet." if fresh else "it moves most of what is in doubt."
    return NextMotion("joint", joint, why)


def _worth(P: Array, seen: Array, K: Array, V: Array, d: Array) -> float:
    """Expected nats, weighted by doubt."""
    energy = np.sum((K @ d) ** 2, axis=1) + 2 * float(d @ V @ d)
    return float(np.sum(seen * P * (1 - P) * np.log1p(energy)))
