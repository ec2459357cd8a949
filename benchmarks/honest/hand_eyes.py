"""Hand-eye: poses of a hand and of what an eye sees, through `bodyschema.learn_hand_eye`.

What counts is the place of the eye, in the hand or in the base. One recording gives one error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import lie
from bodyschema.estimation.prediction import length_quantile
from honest import sights
from honest.effects import direction
from honest.trial import Row, Trial

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


def _eye(change: Callable[[Array], Array]) -> Callable[[Pair, np.random.Generator], Pair]:
    return lambda one, rng: replace(one, B=change(one.B))


def _either(change: Callable[[Array], Array]) -> Callable[[Pair, np.random.Generator], Pair]:
    def changed(one: Pair, rng: np.random.Generator) -> Pair:
        if rng.random() < 0.5:
            return replace(one, A=change(one.A))
        return replace(one, B=change(one.B))

    return changed


def _transposed(T: Array) -> Array:
    """Rotations read column by column."""
    seen = T.copy()
    seen[:, :3, :3] = np.swapaxes(T[:, :3, :3], 1, 2)
    return seen


def _outliers(one: Pair, rng: np.random.Generator) -> Pair:
    bad = np.flatnonzero(rng.random(len(one.B)) < rng.uniform(0.05, 0.3))
    B = one.B.copy()
    B[bad, :3, 3] += 0.05 * rng.normal(size=(len(bad), 3))
    B[bad, :3, :3] = B[bad, :3, :3] @ lie.exp_so3(0.3 * rng.normal(size=(len(bad), 3)))
    return replace(one, B=B)


def _shrunk(one: Pair, rng: np.random.Generator) -> Pair:
    """A target that was printed in another size."""
    factor = float(rng.choice([0.9, 0.97, 1.03, 1.1]))
    return replace(one, B=sights.scaled(factor)(one.B))


def _other_mount(one: Pair, rng: np.random.Generator) -> Pair:
    return replace(one, said="base" if one.eye_on == "hand" else "hand")


def _lens(one: Pair, rng: np.random.Generator) -> Pair:
    """A camera whose lens is bent otherwise than it says: a few mm at the edge."""
    B = one.B.copy()
    off = B[:, :3, 3] - B[:, :3, 3].mean(axis=0)
    bent = off * (off**2).sum(axis=1, keepdims=True)
    B[:, :3, 3] += bent * rng.uniform(1e-3, 5e-3) / np.linalg.norm(bent, axis=1).max()
    return replace(one, B=B)


def trial(
    draw: Draw, change: Callable[[Pair, np.random.Generator], Pair], rng: np.random.Generator
) -> Trial:
    """What the public function is given, and what is true of it."""
    one = change(pair(draw, rng), rng)
    about = f"eye on the {one.eye_on}, {len(one.B)} pairs"
    more: dict[str, Any] = {} if one.times is None else {"times": one.times}
    return Trial(
        about,
        lambda: bs.learn_hand_eye(one.A, one.B, one.said, **more),
        lambda answer: stated_and_true(answer, one),
        single=True,
    )


def stated_and_true(answer: bs.Answer, one: Pair) -> tuple[float, float]:
    """Of the eye's place, m; by its standard deviations where no error is stated."""
    X, Y = answer.details["frames"]
    frame = X if one.said == "hand" else Y
    stated = answer.predicted_95
    if stated is None:
        std = 1e-3 * np.array(frame["std_mm"])
        stated = length_quantile([np.diag(std**2)], np.inf, 0.95)
    return float(stated), one.off(np.array(frame["T_parent_child"]))


def _unchanged(one: Pair, rng: np.random.Generator) -> Pair:
    return one


def _row(name: str, draw: Draw | None = None, change: Any = _unchanged, **more: Any) -> Row:
    return Row("hand-eye", name, partial(trial, draw or Draw(), change), **more)


MM = sights.scaled(1000.0)

ROWS = (
    _row("none", good=True, weight=3),
    _row("none, streams", Draw((100, 200), streams=True), good=True, weight=2),
    _row("3-6 pairs", Draw((3, 4, 5, 6))),
    _row("outliers 5-30 %", change=_outliers),
    _row("6 postures x 10 frames", Draw((60,), repeats=10, noise=sights.by_posture(10))),
    _row("turns about one axis", Draw(one_axis=True)),
    _row("hardly turned", Draw(tilt=0.05)),
    _row("mm", change=_either(MM)),
    _row("inverse", change=_either(lie.inverse)),
    _row("wrong mount", change=_other_mount),
    _row("quaternion order", change=_either(sights.reordered)),
    _row("transposed", change=_either(_transposed)),
    _row("mirror", change=_eye(sights.mirrored)),
    _row("target's scale", change=_shrunk),
    _row("eye bumped half way", Draw(bumped=True)),
    _row("late 50 ms", Draw((100,), smooth=True, late=0.05)),
    _row("AR noise", Draw((40, 80), noise=sights.remembered(0.9))),
    _row("robot 2 mm off", Draw((20, 40), warp=2e-3)),
    _row("clock runs 0.2 % fast", Draw((200,), streams=True, skew=2e-3), apart=True),
    _row("lens", change=_lens, apart=True),
)
