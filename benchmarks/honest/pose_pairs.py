"""Pose pairs: what a robot says of its hand, what an eye says of a target, and what is true."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from honest import sights
from honest.effects import direction

Array = NDArray[np.float64]
Mount = Literal["hand", "base"]


@dataclass(frozen=True)
class Pair:
    """Two lists of poses, and what is true of them."""

    A: Array
    """(n, 4, 4) T_base_hand as the robot says."""
    B: Array
    """(n, 4, 4) T_eye_target as the eye says."""
    X: Array
    """T_hand_eye, or T_hand_target for an eye on the base."""
    Y: Array
    """T_base_target, or T_base_eye."""
    eye_on: Mount
    said: Mount
    """What carries the eye, as the user says."""
    times: tuple[Array, Array] | None = None
    moved: Array | None = None
    """(4, 4) how the eye sits after it was bumped, in itself."""

    def off(self, found: Array) -> float:
        """m: error of the eye's place, the better of before and after."""
        true = self.X if self.eye_on == "hand" else self.Y
        after = true if self.moved is None else true @ self.moved
        return float(min(np.linalg.norm(found[:3, 3] - T[:3, 3]) for T in (true, after)))


@dataclass(frozen=True)
class Draw:
    """What may be drawn."""

    n: tuple[int, ...] = (12, 20, 40)
    repeats: int = 1
    tilt: float = 0.6
    """rad, standard deviation of the hand's turns about each axis."""
    one_axis: bool = False
    smooth: bool = False
    """A hand that moves all the time, seen ten times a second."""
    late: float = 0.0
    """s, by which what the eye saw is older than the hand's pose."""
    streams: bool = False
    """Both with times of their own, from clocks that differ."""
    skew: float = 0.0
    """s per s, by which one clock runs faster."""
    bumped: bool = False
    noise: Callable[..., Array] = sights.white
    warp: float = 0.0
    """m, by which the robot's own poses are off, smoothly in the posture."""


NOISE = (1e-4, 3e-4), (5e-4, 2e-3)
"""m and rad, of the hand's poses and of the eye's."""


def pair(draw: Draw, rng: np.random.Generator) -> Pair:
    """A recording without further faults."""
    eye_on: Mount = "hand" if rng.random() < 0.5 else "base"
    X = lie.transform(lie.exp_so3(rng.normal(size=3)), 0.1 * direction(rng))
    Y = lie.transform(lie.exp_so3(rng.normal(size=3)), rng.uniform(-1, 1, 3))
    n = int(rng.choice(draw.n))
    moves = _wandering(rng, draw) if draw.smooth or draw.streams else None
    t = np.linspace(0.0, 0.1 * n, n) if moves else np.arange(n) * 3.0
    A = moves(t) if moves else _stops(n, draw, rng)
    seen_at = moves(t - draw.late) if moves else A
    moved = _bump(rng) if draw.bumped else None
    B = _seen(seen_at, X, Y, eye_on, moved)
    times = None
    if draw.streams and moves:
        fine, lag = np.arange(-2.0, 0.1 * n + 2.0, 0.02), rng.uniform(-0.3, 0.3)
        A, times = moves(fine), (fine + lag + draw.skew * fine, t)
    if draw.warp:
        A = _warped(A, draw.warp, rng)
    A, B = _noisy(A, NOISE[0], rng, sights.white), _noisy(B, NOISE[1], rng, draw.noise)
    return Pair(A, B, X, Y, eye_on, eye_on, times, moved)


def _seen(A: Array, X: Array, Y: Array, eye_on: Mount, moved: Array | None) -> Array:
    """T_eye_target, with an eye that jumps half way."""
    after = np.eye(4) if moved is None else moved
    late = np.arange(len(A)) >= len(A) / 2
    eye = np.where(late[:, None, None], after, np.eye(4))
    if eye_on == "hand":
        return np.asarray(lie.inverse(A @ X @ eye) @ Y)
    return np.asarray(lie.inverse(Y @ eye) @ A @ X)


def _stops(n: int, draw: Draw, rng: np.random.Generator) -> Array:
    """Postures round a middle, tilted about all axes or about one, `repeats` of each."""
    m = -(-n // draw.repeats)
    turn = draw.tilt * rng.normal(size=(m, 3))
    if draw.one_axis:
        turn = draw.tilt * rng.normal(size=(m, 1)) * direction(rng)
    R = lie.exp_so3(turn) @ lie.exp_so3(rng.normal(size=3))
    place = np.array([0.5, 0.0, 0.4]) + 0.15 * rng.normal(size=(m, 3))
    return lie.transform(R, place).repeat(draw.repeats, axis=0)[:n]


def _wandering(rng: np.random.Generator, draw: Draw) -> Callable[[Array], Array]:
    """A hand that sways about all its axes."""
    pace, phase = 2 * np.pi * rng.uniform(0.1, 0.4, (2, 6)), rng.uniform(-np.pi, np.pi, (2, 6))
    size = np.array([1.0, 1.0, 1.0, 0.2, 0.2, 0.2]) * np.repeat([draw.tilt, 1.0], 3)
    middle = lie.exp_so3(rng.normal(size=3))

    def at(t: Array) -> Array:
        sway = 0.6 * size * np.sin(pace * t[:, None, None] + phase).sum(axis=1)
        return lie.transform(lie.exp_so3(sway[:, :3]) @ middle, sway[:, 3:] + [0.5, 0.0, 0.4])

    return at


def _bump(rng: np.random.Generator) -> Array:
    """3 to 20 mm, and as many milliradians twice."""
    size = rng.uniform(3e-3, 2e-2)
    turn = lie.exp_so3(2 * size * direction(rng))
    return lie.transform(turn, size * direction(rng))


def _warped(A: Array, size: float, rng: np.random.Generator) -> Array:
    """Poses of a robot that is not quite what its controller takes it for."""
    p, turn = A[:, :3, 3] - A[:, :3, 3].mean(axis=0), lie.log_so3(A[:, :3, :3] @ A[0, :3, :3].T)
    by = np.concatenate([p / 0.15, turn / 0.6], axis=1)
    off = by @ rng.normal(size=(6, 6)) + (by**2) @ rng.normal(size=(6, 6))
    off *= size / np.sqrt((off[:, :3] ** 2).sum(axis=1).mean())
    warped = A.copy()
    warped[:, :3, 3] += off[:, :3]
    warped[:, :3, :3] = lie.exp_so3(off[:, 3:]) @ warped[:, :3, :3]
    return warped


def _noisy(
    T: Array, size: tuple[float, float], rng: np.random.Generator, noise: Callable[..., Array]
) -> Array:
    off = noise(rng, len(T), 6) * np.repeat(size, 3)
    seen = T.copy()
    seen[:, :3, 3] += off[:, :3]
    seen[:, :3, :3] = seen[:, :3, :3] @ lie.exp_so3(off[:, 3:])
    return seen
