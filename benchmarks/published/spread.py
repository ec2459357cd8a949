"""The numbers of a summary by dotted name, and the rule for what lies inside a stored spread.

A study is run K times at a small size with K seeds, which gives each of its numbers a mean and a
standard deviation sd. The mean of n further small runs differs from that mean by sd sqrt(1/n + 1/K)
times a Student t of K - 1 degrees of freedom. Inside is what such a chance gives in all but one of
10,000 cases,

    |x - mean| <= max(t sd sqrt(1/n + 1/K), least)

where `least` is what single runs change where the copies happened to agree: three failures more,
one sample more. Numbers that no seed changes have neither, and must come again exactly.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from scipy.stats import t

LEVEL = 1e-4
"""Chance, each number, that a small run of unchanged code falls outside."""
ROUNDING = 1e-6
"""Relative: compilers and processors round differently."""


def numbers(summary: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, float | None]]:
    """(dotted name, value) of each number and None in nested dicts; lists and text are left out."""
    for key, value in summary.items():
        if isinstance(value, Mapping):
            yield from numbers(value, f"{above}{key}.")
        elif value is None or isinstance(value, int | float):
            yield f"{above}{key}", None if value is None else float(value)


def spread(values: Sequence[float | None]) -> dict[str, float] | None:
    """Mean, sd and n over the copies; None if one of them has no number there."""
    known = [value for value in values if value is not None]
    if len(known) < max(len(values), 2):
        return None
    return {
        "mean": digits(np.mean(known)),
        "sd": digits(np.std(known, ddof=1)) if len(set(known)) > 1 else 0.0,
        "n": len(known),
    }


def half_width(stored: Mapping[str, Any], runs: int = 1) -> float:
    """How far the mean of `runs` small runs may lie from the stored one."""
    copies = stored["n"]
    chance = t.ppf(1 - LEVEL / 2, copies - 1) * stored["sd"] * math.sqrt(1 / runs + 1 / copies)
    return float(max(chance, stored.get("least", 0.0), ROUNDING * abs(stored["mean"])))


def inside(value: float | None, stored: Mapping[str, Any], runs: int = 1) -> bool:
    """Whether a number is as the stored ones; what never came is not."""
    return value is not None and abs(value - stored["mean"]) <= half_width(stored, runs)


def digits(value: float) -> float:
    """To seven digits: enough for `ROUNDING`."""
    return float(f"{value:.7g}")
