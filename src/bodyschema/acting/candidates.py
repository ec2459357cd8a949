"""Postures that the robot could take next: within limits, in view, not into itself.

Half of the proposals are uniform over the joint ranges, the other half are recorded postures moved
a little or a lot (by 1 % to 50 % of the range): where a camera must keep the hand in view, few
uniform postures would pass. Joints that are not between the frames of the senses stand still.

Where a board is photographed it has to stay in the picture (`board_view`). No other view is
modelled, since nobody described the camera. What is known is where things were seen: a posture is
in view of a sense when the seen frame would lie, in the frame that looks, within a slightly grown
ellipsoid round its recorded places, and would be looked at from within a slightly grown cone of the
recorded directions (a flat marker has a face).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.acting.board_view import BoardView
from bodyschema.errors import InputError
from bodyschema.estimation.problem import moved_joints
from bodyschema.model.kernels import PRISMATIC
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.limits import contradicted_limits
from bodyschema.model.tree import Body
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

GROWTH = 1.2
"""The recorded view, grown by this, is still in view."""

SLACK = 0.1
"""rad by which the cone of directions grows besides."""

INSIDE = 0.01
"""Share of a joint's range that is kept from either limit."""

BEYOND = (0.5, 0.1)
"""rad and m beyond the recorded range, for a joint without limits."""

FREELY = (np.pi, 0.5)
"""rad and m round zero for a joint without limits that was never recorded."""

ROUNDS = 40
"""Batches of proposals before what was found has to do."""

WORK = 300
"""Postures over which the tool error is averaged."""


@dataclass(frozen=True)
class Candidates:
    """Postures to choose from, and postures that the robot is to be right in."""

    q: Array
    """(n, n_joints)."""
    visible: Flags
    """(n, n_senses) which sense would see anything."""
    work: Array
    """(m, n_joints) over the joint ranges, whether in view or not."""
    joints: tuple[str, ...]
    """The joints that differ."""


@dataclass(frozen=True)
class View:
    """Where one sense has seen things."""

    seen_from: str
    seen: str
    centre: Array
    """(3,) m."""
    whitener: Array
    """(3, 3) takes an offset from the centre to units of the recorded reach."""
    facing: Array
    """(3,) mean direction, in the seen frame, from which it was looked at; unit or zero."""
    cosine: float
    """Of the widest angle to `facing`."""

    @classmethod
    def of(cls, body: Body, sense: Sense) -> View | None:
        """The view of a recorded sense; None where nothing was recorded."""
        if not len(sense):
            return None
        T = relative_pose(body, sense.q, sense.seen_from, sense.seen)
        position = T[:, :3, 3]
        centre = position.mean(axis=0)
        offsets = position - centre
        values, axes = np.linalg.eigh(offsets.T @ offsets / len(T))
        # Places seen in a plane, or in one spot, still have some depth: a twentieth of the largest.
        spread = np.sqrt(values.clip(0) + (0.05 * np.sqrt(values[-1].clip(0)) + 0.01) ** 2)
        whitener = axes.T / spread[:, None]
        reach = GROWTH * float(np.linalg.norm(offsets @ whitener.T, axis=1).max())
        directions = _looked_at_from(T)
        facing = directions.mean(axis=0)
        facing /= max(float(np.linalg.norm(facing)), 1e-12)
        angle = GROWTH * float(np.arccos((directions @ facing).clip(-1, 1)).max()) + SLACK
        widest = float(np.cos(min(angle, np.pi)))
        return cls(sense.seen_from, sense.seen, centre, whitener / max(reach, 1.0), facing, widest)

    def holds(self, body: Body, q: Array) -> Flags:
        """Whether the seen frame is in view at each posture, (n,)."""
        T = relative_pose(body, q, self.seen_from, self.seen)
        near = np.linalg.norm((T[:, :3, 3] - self.centre) @ self.whitener.T, axis=1) <= 1
        return np.asarray(near & (_looked_at_from(T) @ self.facing >= self.cosine - 1e-9))


def _looked_at_from(T_a_b: Array) -> Array:
    """Unit direction from b to a, in b, (n, 3)."""
    towards = -np.einsum("nji,nj->ni", T_a_b[:, :3, :3], T_a_b[:, :3, 3])
    return np.asarray(towards / np.maximum(np.linalg.norm(towards, axis=1), 1e-12)[:, None])


def view_of(body: Body, sense: Sense) -> View | BoardView | None:
    """What a sense can see, as far as its recording tells; None where nothing was recorded."""
    board = BoardView.of(body, sense) if isinstance(sense, Pixels) else None
    return board or View.of(body, sense)


def find_candidates(
    body: Body,
    senses: Sequence[Sense],
    n: int,
    rng: np.random.Generator,
    anywhere: bool = False,
    free: Callable[[Array], Flags] | None = None,
) -> Candidates:
    """Draw postures and keep those that can be taken and seen.

    Args:
        body: the corrected body.
        senses: what was seen; senses without samples set no view.
        n: how many candidates to find at most.
        rng: randomness.
        anywhere: do not ask whether the recorded view would hold the posture.
        free: tells which postures (n, n_joints) do not collide, (n,); all when None.

    Raises:
        InputError: hardly any posture passes.
    """
    moved = moved_joints(body, senses)
    columns = [body.joint_index(joint) for joint in moved]
    recorded = np.concatenate([sense.q for sense in senses])
    low, high = joint_ranges(body, recorded)
    rest = np.median(recorded, axis=0) if len(recorded) else np.clip(0.0, low, high)
    views = [None if anywhere else view_of(body, sense) for sense in senses]

    def propose(count: int, near: bool) -> Array:
        q = np.tile(rest, (count, 1))
        q[:, columns] = rng.uniform(low, high, (count, len(low)))[:, columns]
        if near and len(recorded):
            q[:, columns] = _moved(recorded, low, high, count, rng)[:, columns]
        return q[free(q)] if free else q

    found, visible = np.empty((0, len(low))), np.empty((0, len(senses)), dtype=bool)
    for _ in range(ROUNDS):
        q = np.concatenate([propose(n // 2, False), propose(n - n // 2, True)])
        seen = [view.holds(body, q) if view else np.ones(len(q), dtype=bool) for view in views]
        can = np.any(seen, axis=0)
        found, visible = np.vstack([found, q[can]]), np.vstack([visible, np.transpose(seen)[can]])
        if len(found) >= n:
            break
    if not len(found):
        raise InputError(
            "no posture was found that is within limits, in the recorded view and free of "
            "self-collision; look beyond that view with --anywhere, or pass --ignore-collisions."
        )
    work = propose(4 * WORK, False)[:WORK]
    return Candidates(found[:n], visible[:n], work if len(work) else found[:WORK], moved)


def joint_ranges(body: Body, recorded: Array) -> tuple[Array, Array]:
    """Lowest and highest reading of each joint that may be asked for, two (n_joints,).

    Args:
        body: with limits.
        recorded: (n, n_joints) postures, for joints without limits or with such as leave no range.
    """
    slides = np.isin(np.arange(len(body.joints)), body.driver[body.kind == PRISMATIC]).astype(int)
    if len(recorded):
        margin = np.array(BEYOND)[slides]
        low, high = recorded.min(axis=0) - margin, recorded.max(axis=0) + margin
    else:
        high = np.array(FREELY)[slides]
        low = -high
    limited = np.isfinite(body.lower) & np.isfinite(body.upper)
    limited &= ~contradicted_limits(body, recorded)
    inside = INSIDE * (body.upper[limited] - body.lower[limited])
    low[limited], high[limited] = body.lower[limited] + inside, body.upper[limited] - inside
    return low, high


def _moved(recorded: Array, low: Array, high: Array, n: int, rng: np.random.Generator) -> Array:
    """Recorded postures, moved by 1 % to 50 % of the joint ranges."""
    start = recorded[rng.integers(len(recorded), size=n)]
    size = np.exp(rng.uniform(np.log(0.01), np.log(0.5), (n, 1)))
    moved = start + size * (high - low) * rng.normal(size=start.shape)
    return np.asarray(np.clip(moved, low, high))


def travel_order(q: Array, start: Array) -> NDArray[np.int64]:
    """Order in which to visit postures: always the nearest next, by the joint that moves most."""
    left, here, order = list(range(len(q))), start, []
    while left:
        nearest = left[int(np.argmin(np.abs(q[left] - here).max(axis=1)))]
        left.remove(nearest)
        order.append(nearest)
        here = q[nearest]
    return np.array(order, dtype=np.int64)
