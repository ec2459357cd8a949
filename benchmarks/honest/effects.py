"""Effects: joints that turn otherwise than their encoders say, and frames that move."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema import lie
from honest.world import Effect, Motion, Move, World

Array = NDArray[np.float64]


def direction(rng: np.random.Generator) -> Array:
    """(3,) unit."""
    v = rng.normal(size=3)
    return np.asarray(v / np.linalg.norm(v))


def slip(joint: int, by: float, at: float = 0.5) -> Effect:
    """An encoder slips by an angle (rad) at a share of the recording."""

    def turned(motion: Motion) -> Array:
        turn = np.zeros_like(motion.q)
        turn[:, joint] = by * (motion.when >= at)
        return turn

    return turned


def geared(joint: int, by: float) -> Effect:
    """One joint turns by a share more than it reads."""

    def turned(motion: Motion) -> Array:
        return np.asarray(by * motion.q * (np.arange(motion.q.shape[1]) == joint))

    return turned


def waves(size: Array, order: Array, phase: Array) -> Effect:
    """Gears that are not round: size (n_joints,) rad, order, phase (n_joints,)."""

    def turned(motion: Motion) -> Array:
        return np.asarray(size * np.sin(order * motion.q + phase))

    return turned


def sag(world: World, softness: Array, among: Motion) -> Effect:
    """Joints that give way: `softness` (n_joints,) rad at most, over the postures `among`."""
    most = np.abs(world.torques(among)).max(axis=0) + 1e-12

    def turned(motion: Motion) -> Array:
        return np.asarray(softness * world.torques(motion) / most)

    return turned


def hysteresis(half: Array) -> Effect:
    """Joints that lag behind by half their play, against the way they move, (n_joints,) rad."""

    def turned(motion: Motion) -> Array:
        return np.asarray(-half * np.sign(motion.dq))

    return turned


def warming(by: Array, tau: float = 0.4) -> Effect:
    """Joint zeros that creep to `by` (n_joints,) rad."""

    def turned(motion: Motion) -> Array:
        return np.asarray(by * (1 - np.exp(-motion.when / tau))[:, None])

    return turned


def columns(order: ArrayLike, sign: ArrayLike) -> Effect:
    """Columns of the recording that are those of other joints, or count the other way."""
    chosen, signs = np.asarray(order, dtype=np.int64), np.asarray(sign, dtype=np.float64)

    def turned(motion: Motion) -> Array:
        return np.asarray(signs * motion.q[:, chosen] - motion.q)

    return turned


def moved(twist: Array, at: float = 0.5) -> Move:
    """A frame jumps by a twist (6,), m and rad, at a share of the recording."""

    def there(motion: Motion) -> Array:
        return _poses((motion.when >= at)[:, None] * twist)

    return there


def drifting(path: Array) -> Move:
    """A frame wanders along a path (m, 6) of twists, evenly over the recording."""

    def there(motion: Motion) -> Array:
        knots = np.linspace(0, 1, len(path))
        return _poses(np.stack([np.interp(motion.when, knots, c) for c in path.T], axis=1))

    return there


def _poses(twists: Array) -> Array:
    return lie.transform(lie.exp_so3(twists[:, 3:]), twists[:, :3])
