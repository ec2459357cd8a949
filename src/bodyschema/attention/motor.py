"""When the joints move: the stream of positions cut into motions, and positions some time ago.

A joint moves when it has turned by more than `turn` within `window`; encoder noise must stay below.
A motion is over when no joint has moved for `rest`, so that what the eyes see late still counts, or
when it has lasted `longest`: a robot that never rests has its motion cut into pieces.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MEMORY = 96
"""Frames whose positions are kept."""


@dataclass(frozen=True)
class Motor:
    """State: the latest positions, and the motion that is going on."""

    time: Array
    """(MEMORY,) s, oldest first; -inf before there were any."""
    q: Array
    """(MEMORY, J) positions at those times."""
    moved: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, dtype=bool))
    """(J,) the joints that move now."""
    began: float = np.nan
    """s, when the motion that is going on began; nan outside motions."""
    last_moved: float = -np.inf
    """s, when a joint moved last."""
    ended: bool = False
    """Whether this frame ends a motion."""

    def at(self, time: Array) -> Array:
        """(k, J) positions at times (k,), between frames by straight lines, the nearest outside."""
        n = int(np.isfinite(self.time).sum())
        known, q = self.time[-n:], self.q[-n:]
        if n == 1:
            return np.repeat(q, len(time), axis=0)
        right = np.clip(np.searchsorted(known, time), 1, n - 1)
        span = known[right] - known[right - 1]
        share = np.clip((time - known[right - 1]) / span, 0.0, 1.0)[:, None]
        return np.asarray((1 - share) * q[right - 1] + share * q[right])


@dataclass(frozen=True)
class MotionCutter:
    """Cuts a stream of joint positions into motions."""

    turn: float = 0.004
    """rad or m."""
    window: float = 0.16
    """s"""
    rest: float = 0.3
    """s"""
    longest: float = 1.5
    """s"""

    def start(self, joints: int) -> Motor:
        """Before the first frame."""
        return Motor(np.full(MEMORY, -np.inf), np.zeros((MEMORY, joints)), np.zeros(joints, bool))

    def step(self, state: Motor, time: float, q: Array) -> Motor:
        """One frame's positions (J,)."""
        held = Motor(np.append(state.time[1:], time), np.vstack([state.q[1:], q]))
        moved = np.abs(q - held.at(np.array([time - self.window]))[0]) > self.turn
        began = np.nan if state.ended else state.began
        last = time if moved.any() else state.last_moved
        if np.isnan(began) and moved.any():
            began = time
        ended = time - began >= self.longest or time - last >= self.rest
        ended = bool(ended and not np.isnan(began))
        return Motor(held.time, held.q, moved, began, last, ended)
