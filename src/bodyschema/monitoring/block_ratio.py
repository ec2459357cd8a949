"""Which part would explain the last seconds better? A likelihood ratio for each block.

Over a window of white innovations e with slope J, and a belief with covariance P,

    s = sum J^T e,   H = sum J^T J,   g_b = s_b^T (H_bb + H_b: P H_:b)^-1 s_b

is chi-square with dim b degrees of freedom while nothing changed: the belief's own error, common to
all samples of the window, is in the second term. An alarm is g_b beyond the point whose probability
is the allowed rate divided by the number of tests, two windows and all blocks (Bonferroni; windows
overlap, so the true rate is lower; blocks share it by their odds, so that what changes often is
noticed soon). Sums are kept in groups of a few samples.

The formula wants one belief for the whole window, which has not learned from it. So samples must
wait for as long as the longest window before they are learned, and when the belief moves by delta,
what is in the window moves along, s <- s - H delta.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

WINDOWS = (3, 12)
"""Groups a window."""


@dataclass(frozen=True)
class Window:
    """State: sums of the last groups, oldest first, and of the unfinished one."""

    s: Array
    """(groups, k)."""
    H: Array
    """(groups, k, k)."""
    samples: int = 0
    """In the unfinished group."""

    @classmethod
    def empty(cls, variables: int) -> Window:
        """Of no sample; the first row is the unfinished group."""
        return cls(np.zeros((1, variables)), np.zeros((1, variables, variables)))

    def move(self, delta: Array) -> Window:
        """As a belief that differs by (k,) would have it."""
        return replace(self, s=self.s - self.H @ delta)


@dataclass(frozen=True)
class BlockRatio:
    """Settings of the test."""

    samples: float
    """Mean number of samples between false alarms, at least."""
    blocks: Mapping[str, Ints]
    odds: Mapping[str, float]
    """How often each block changes, relative to the others."""
    group: int = 5
    """Samples a group."""

    def step(self, state: Window, e: Array, J: Array, P: Array) -> tuple[Window, str]:
        """One sample's white innovations (m,) with slope (m, k) and the belief's covariance.

        Returns:
            the window, and the block with the strongest alarm, or "".
        """
        s, H = state.s.copy(), state.H.copy()
        s[-1] += J.T @ e
        H[-1] += J.T @ J
        if state.samples + 1 < self.group:
            return Window(s, H, state.samples + 1), ""
        return Window(_shift(s), _shift(H)), self._test(s, H, P)

    def _test(self, s: Array, H: Array, P: Array) -> str:
        blame, most = "", 1.0
        for groups in WINDOWS:
            if groups > len(s):
                continue
            window_s, window_H = s[-groups:].sum(axis=0), H[-groups:].sum(axis=0)
            for name, b in self.blocks.items():
                share = ratio(window_s, window_H, P, b) / self.limit(name)
                if share > most:
                    blame, most = name, share
        return blame

    def limit(self, block: str) -> float:
        """The value that g_b must pass."""
        share = self.odds[block] / sum(self.odds.values())
        return limit(share * self.group / self.samples / len(WINDOWS), len(self.blocks[block]))


def _shift(groups: Array) -> Array:
    """Room for a new group; the oldest goes when the longest window is full."""
    return np.concatenate([groups[-WINDOWS[-1] + 1 :], np.zeros((1, *groups.shape[1:]))])


@lru_cache(maxsize=64)
def limit(chance: float, dimension: int) -> float:
    """The value that g_b passes with a chance while nothing changed."""
    return float(chdtri(dimension, min(chance, 0.5)))


def ratio(s: Array, H: Array, P: Array, b: Ints) -> float:
    """g_b of the module's text."""
    S = H[np.ix_(b, b)] + H[b] @ P @ H[:, b]
    # In a window without motion some directions say nothing; the ridge keeps them silent.
    S = S + (1e-9 * np.trace(S) + 1e-300) * np.eye(len(b))
    return float(s[b] @ np.linalg.solve(S, s[b]))


def noticeable(H: Array, P: Array, b: Ints, limit: float) -> float:
    """Smallest change of a block, in its worst direction, that the window would have noticed.

    A change d of the block raises g_b by d^T H_bb (H_bb + H_b: P H_:b)^-1 H_bb d on average. No
    alarm says nothing about changes below this size; without motion it is inf.
    """
    Hbb = H[np.ix_(b, b)]
    S = Hbb + H[b] @ P @ H[:, b]
    S = S + (1e-9 * np.trace(S) + 1e-300) * np.eye(len(b))
    power = np.linalg.eigvalsh(Hbb @ np.linalg.solve(S, Hbb))[0]
    return float(np.sqrt(limit / power)) if power > 1e-6 * np.trace(Hbb) else np.inf
