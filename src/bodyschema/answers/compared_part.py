"""The rows of a comparison: one part that may differ, one pair of frames that may lie apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ComparedPart:
    """A joint, a frame or another part, and how far it differs beside those before it."""

    part: str
    names: tuple[str, ...]
    """(k,) of its numbers."""
    units: tuple[str, ...]
    change: Array
    """(k,) second less first; rad, m or the units of the part."""
    std: Array
    """(k,) its standard deviations, both results' errors together."""
    covariance: Array
    """(k, k)."""
    deviations: float
    """How many standard deviations that is; of several numbers the length of all together."""
    p_value: float
    """Chance of so much if it has not changed, the number of parts counted in."""
    differs: bool
    alike: tuple[str, ...] = ()
    """Parts that would explain the difference as well."""
    effect: float = 0.0
    """m: 95 % of how far it moves what was seen, over the joints' limits."""
    effect_low: float = 0.0
    effect_high: float = 0.0
    """m: between these with 95 %."""


@dataclass(frozen=True)
class ComparedPair:
    """A frame seen from another, in both results."""

    seen_from: str
    seen: str
    apart: float
    """m: 95 % of how far both results place it apart, over the joints' limits."""
    turned: float
    """rad, likewise."""
    chance: float
    """m: if nothing has changed `apart` stays below this with 95 %."""
    chance_turned: float
    """rad"""
    left: float
    """m: of `apart`, that the parts which differ do not explain."""
    q: Array
    """(n, n_joints) the postures."""
