"""Where to begin when joint zeros may be wrong by up to half a turn: a search without derivatives.

A fit that begins a quarter turn off ends in a local minimum. The frames have a closed form for any
zeros (`frame_fits`), so its misfit is a function of the zeros alone:

    c(o) = sum over senses of log(median residual / median spread), positions and rotations

Coordinate descent takes one joint after the other round the whole circle, the others as they are,
until no joint moves; then in steps that halve. What is left after that is a fit's to do. A descent
that ends with much left over begins again from random zeros; the best end is the start.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import PRISMATIC
from bodyschema.model.tree import Body
from bodyschema.seeds.frame_fits import FrameFits, rough_score
from bodyschema.seeds.open_chain import OpenChain
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]

ANGLES, SWEEPS = 16, 5
"""Of each joint round the circle, and the most turns through all joints."""

FINER = (2, 4, 8, 16, 32)
"""Shares of that step in the sweeps after it, forth and back."""

GAIN = 0.02
"""Least gain in c that moves a joint: zeros that nothing shows stay where they are."""

EXPLAINED = 0.05
"""Median residual over median spread below which a start is good enough."""

RESTARTS = 12
"""From random zeros, where a descent ends above that."""

MOST = 40
"""Samples of each sense: a search needs no more."""


@dataclass(frozen=True)
class ZeroSearch:
    """Zeros found, and how well they and those of the description explain what was seen."""

    offset: Array = field(repr=False)
    """(n_joints,) rad, to be added to those of the body."""
    before: float
    """Largest median residual over median spread, of any sense's positions and rotations."""
    after: float

    @property
    def found(self) -> bool:
        """Whether the search ended anywhere else and explains at least twice as much there."""
        return bool(self.offset.any()) and 2 * self.after < self.before


def search_zeros(
    body: Body,
    senses: Sequence[Sense],
    joints: Sequence[str],
    seed: int = 0,
    restarts: int = RESTARTS,
) -> ZeroSearch | None:
    """Search the zeros of joints; None where no sense has frames in closed form.

    Args:
        body: as described, all frames attached.
        senses: what was seen; points, poses and pictures of boards count.
        joints: that may be wrong; those that slide are left alone.
        seed: of the random zeros.
        restarts: at most, from those.
    """
    chains = OpenChain.all_of(body, senses, MOST)
    turning = [j for j in map(body.joint_index, joints) if _turns(body, j)]
    if not chains or not turning:
        return None
    start = np.zeros(len(body.joints))
    before = _worst(chains, start)
    best = _descended(chains, start, turning)
    rng = np.random.default_rng(seed)
    for _ in range(restarts):
        if _worst(chains, best) < EXPLAINED:
            break
        at = np.zeros(len(body.joints))
        at[turning] = rng.uniform(-np.pi, np.pi, len(turning))
        best = min(best, _descended(chains, at, turning), key=lambda o: _cost(chains, o[None])[0])
    offset = np.where(np.abs(best) > 1e-9, (best + np.pi) % (2 * np.pi) - np.pi, 0.0)
    return ZeroSearch(offset, before, _worst(chains, best))


def _turns(body: Body, joint: int) -> bool:
    return not (body.kind[body.driver == joint] == PRISMATIC).any()


def _descended(chains: Sequence[OpenChain], start: Array, joints: Sequence[int]) -> Array:
    """Zeros (n_joints,) at the end of a descent."""
    step = 2 * np.pi / ANGLES
    circle: Array = step * np.arange(ANGLES, dtype=np.float64)
    at = start
    for _ in range(SWEEPS):
        before = at
        for joint in joints:
            at = _moved(chains, at, joint, circle)
        if (at == before).all():
            break
    for share in FINER:
        near: Array = np.array([0.0, -2.0, -1.0, 1.0, 2.0]) * (step / share)
        for joint in joints:
            at = _moved(chains, at, joint, near)
    return at


def _moved(chains: Sequence[OpenChain], at: Array, joint: int, moves: Array) -> Array:
    """The best of some moves of one joint, the first of them to stay."""
    tried = np.tile(at, (len(moves), 1))
    tried[:, joint] += moves
    cost = _cost(chains, tried)
    best = int(np.argmin(cost))
    return tried[best] if cost[best] < cost[0] - GAIN else at


def _cost(chains: Sequence[OpenChain], offsets: Array) -> Array:
    """c of (h, n_joints) offsets, (h,)."""
    tried = (rough_score(chain.batch(chain.q + offsets[:, None])) for chain in chains)
    return np.asarray(sum(tried))


def _worst(chains: Sequence[OpenChain], offset: Array) -> float:
    fits = [FrameFits.of(chain.batch((chain.q + offset)[None])) for chain in chains]
    return float(max(fit.worst[0] for fit in fits))
