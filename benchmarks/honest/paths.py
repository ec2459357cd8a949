"""Paths: how the arm moves while it is recorded, stop by stop or smoothly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from honest.world import Motion

Array = NDArray[np.float64]

PAUSE = 3.0
"""s from one stop to the next."""

FRAME = 1 / 30
"""s from one frame of a stop to the next."""

LASTS = 40.0
"""s of a smooth recording."""

TONES = 3
"""Sines that a joint's smooth path is made of."""

SLOWEST, FASTEST = 0.03, 0.16
"""Hz, of these."""


@dataclass(frozen=True)
class Path:
    """Where the joints are at any time."""

    home: Array
    """(n_joints,) rad."""
    spread: Array
    """(n_joints,) rad either way."""
    times: Array
    """(n,) s, of the samples."""

    def motion(self, time: Array) -> Motion:
        """At some times, (n,)."""
        raise NotImplementedError

    def _share(self, time: Array) -> Array:
        return np.asarray((time - self.times[0]) / max(np.ptp(self.times), 1e-9))


@dataclass(frozen=True)
class Stops(Path):
    """A posture at random every few seconds, at rest; some frames of each."""

    stops: Array
    """(m, n_joints) rad."""

    @classmethod
    def draw(
        cls, home: Array, spread: Array, n: int, repeats: int, rng: np.random.Generator
    ) -> Self:
        """n samples, `repeats` of every posture."""
        m = -(-n // repeats)
        begin = PAUSE * np.arange(m) * rng.uniform(0.95, 1.05)
        times = (begin[:, None] + FRAME * np.arange(repeats)).ravel()[:n]
        return cls(home, spread, times, home + spread * rng.uniform(-1, 1, (m, len(home))))

    def motion(self, time: Array) -> Motion:
        """The posture that was reached last."""
        pause = np.searchsorted(self.times, time + 1e-9) - 1
        row = np.clip(pause, 0, None) * len(self.stops) // len(self.times)
        q = self.stops[row]
        return Motion(q, np.zeros_like(q), self._share(time), time)

    def replaced(self, motion: Motion, some: NDArray[np.bool_], rng: np.random.Generator) -> Motion:
        """With other postures for some of the samples."""
        q = motion.q.copy()
        q[some] = self.home + self.spread * rng.uniform(-1, 1, (int(some.sum()), q.shape[1]))
        return Motion(q, motion.dq, motion.when, motion.time)


@dataclass(frozen=True)
class Smooth(Path):
    """A few slow sines in every joint."""

    size: Array
    """(TONES, n_joints) rad."""
    pace: Array
    """(TONES, n_joints) rad/s."""
    phase: Array

    @classmethod
    def draw(
        cls, home: Array, spread: Array, n: int, repeats: int, rng: np.random.Generator
    ) -> Self:
        """n samples; nothing is repeated on a smooth path."""
        shape = (TONES, len(home))
        size = rng.uniform(0.3, 1.0, shape)
        size *= spread / size.sum(axis=0)
        pace = 2 * np.pi * rng.uniform(SLOWEST, FASTEST, shape)
        times = np.linspace(0, LASTS, n)
        return cls(home, spread, times, size, pace, rng.uniform(-np.pi, np.pi, shape))

    def motion(self, time: Array) -> Motion:
        """At any time, between the samples too."""
        angle = self.pace * time[:, None, None] + self.phase
        q = self.home + (self.size * np.sin(angle)).sum(axis=1)
        dq = (self.size * self.pace * np.cos(angle)).sum(axis=1)
        return Motion(q, dq, self._share(time), time)
