"""Sights: what a sensor makes of true poses, and what people make of what was seen."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from honest.effects import direction
from honest.world import Motion

Array = NDArray[np.float64]

Sight = Callable[[Array, Motion, np.random.Generator], Array]
"""What the sensor makes of true poses (n, 4, 4)."""

Noise = Callable[[np.random.Generator, int, int], Array]
"""n samples of d numbers of about unit size."""


def white(rng: np.random.Generator, n: int, d: int) -> Array:
    """Independent Gaussian numbers."""
    return rng.normal(size=(n, d))


def outliers(share: float, size: float) -> Sight:
    """A share of the rows somewhere else, up to `size` m away and turned at random."""

    def seen(T: Array, motion: Motion, rng: np.random.Generator) -> Array:
        bad = rng.random(len(T)) < share
        away = rng.uniform(0.02, size, (len(T), 1)) * _directions(len(T), rng)
        turn = lie.exp_so3(rng.uniform(0.1, 1.0, (len(T), 1)) * _directions(len(T), rng))
        return _shifted(T, bad[:, None] * away, np.where(bad[:, None, None], turn, np.eye(3)))

    return seen


def shifted_alike(share: float, size: float, corner: bool) -> Sight:
    """A share of the rows off by one vector of `size` m, at random or all in one corner."""

    def seen(T: Array, motion: Motion, rng: np.random.Generator) -> Array:
        where = motion.q @ rng.normal(size=motion.q.shape[1]) if corner else rng.random(len(T))
        bad = where < np.quantile(where, share)
        return _shifted(T, bad[:, None] * size * direction(rng))

    return seen


def quadratic(size: float) -> Sight:
    """A tracker whose field is bent: off by at most `size` m, with the square of the place."""

    def seen(T: Array, motion: Motion, rng: np.random.Generator) -> Array:
        p = T[:, :3, 3] - T[:, :3, 3].mean(axis=0)
        squares = np.stack([p[:, i] * p[:, j] for i in range(3) for j in range(i + 1)], axis=1)
        off = squares @ rng.normal(size=(6, 3))
        return _shifted(T, off * size / np.linalg.norm(off, axis=1).max())

    return seen


def radial(size: float) -> Sight:
    """A tracker that is right in the middle of its view and off by `size` m at the edge."""

    def seen(T: Array, motion: Motion, rng: np.random.Generator) -> Array:
        p = T[:, :3, 3] - T[:, :3, 3].mean(axis=0)
        off = p * (p**2).sum(axis=1, keepdims=True) * rng.choice([-1.0, 1.0])
        return _shifted(T, off * size / np.linalg.norm(off, axis=1).max())

    return seen


def remembered(memory: float) -> Noise:
    """AR(1) noise of unit size, correlated by `memory` from row to row."""

    def noise(rng: np.random.Generator, n: int, d: int) -> Array:
        fresh = rng.normal(size=(n, d)) * np.sqrt(1 - memory**2)
        fresh[0] /= np.sqrt(1 - memory**2)
        for i in range(1, n):
            fresh[i] += memory * fresh[i - 1]
        return fresh

    return noise


def heavy(freedom: float) -> Noise:
    """Student's t."""

    def noise(rng: np.random.Generator, n: int, d: int) -> Array:
        return rng.standard_t(freedom, size=(n, d))

    return noise


def uneven(rng: np.random.Generator, n: int, d: int) -> Array:
    """Six times as much along one direction, and twice as much in a third of the rows."""
    noise = rng.normal(size=(n, d))
    noise[:, d % 3 - 1 if d < 3 else 2] *= 6
    return np.asarray(noise * np.where(rng.random(n) < 1 / 3, 2.0, 1.0)[:, None])


def by_posture(repeats: int) -> Noise:
    """A part that all frames of a posture share, as large as what they do not."""

    def noise(rng: np.random.Generator, n: int, d: int) -> Array:
        common = rng.normal(size=(-(-n // repeats), d)).repeat(repeats, axis=0)[:n]
        return np.asarray((rng.normal(size=(n, d)) + common) / np.sqrt(2))

    return noise


def mirrored(observed: Array) -> Array:
    """The x of everything the other way; rotations stay rotations."""
    seen = observed.copy()
    if seen.ndim == 3:
        S = np.diag([-1.0, 1.0, 1.0])
        seen[:, :3, 3] = seen[:, :3, 3] @ S
        seen[:, :3, :3] = S @ seen[:, :3, :3] @ S
    else:
        seen[:, 0] = (640.0 if seen.shape[1] == 2 else 0.0) - seen[:, 0]
    return seen


def axes_swapped(observed: Array) -> Array:
    """x and y of positions (or u and v of pictures) swapped, rotations left as they are."""
    seen = observed.copy()
    at = (slice(None), [0, 1], 3) if seen.ndim == 3 else (slice(None), [0, 1])
    other = (slice(None), [1, 0], 3) if seen.ndim == 3 else (slice(None), [1, 0])
    seen[at] = observed[other]
    return seen


def inverted(observed: Array) -> Array:
    """Poses of the tracker in the tool."""
    return lie.inverse(observed)


def reordered(observed: Array) -> Array:
    """Quaternions w x y z taken for x y z w."""
    seen = observed.copy()
    x, y, z, w = lie.quaternion_xyzw(observed[:, :3, :3]).T
    seen[:, :3, :3] = lie.rotation_from_xyzw(np.stack([w, x, y, z], axis=1))
    return seen


def scaled(factor: float) -> object:
    """Positions in another unit."""

    def declared(observed: Array) -> Array:
        seen = observed.copy()
        if seen.ndim == 3:
            seen[:, :3, 3] *= factor
        else:
            seen *= factor
        return seen

    return declared


def _directions(n: int, rng: np.random.Generator) -> Array:
    v = rng.normal(size=(n, 3))
    return np.asarray(v / np.linalg.norm(v, axis=1, keepdims=True))


def _shifted(T: Array, by: Array, turned: Array | None = None) -> Array:
    seen = T.copy()
    seen[:, :3, 3] += by
    if turned is not None:
        seen[:, :3, :3] = turned @ seen[:, :3, :3]
    return seen
