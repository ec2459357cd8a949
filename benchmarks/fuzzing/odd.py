"""Values that break readers: too long, too large, of another type, elsewhere, or markup."""

from __future__ import annotations

import random
from typing import Any

SECRET = "../../outside/secret.txt"
"""A file beside the folder that mutants are read in, which none may touch."""

TEXTS = (
    "", " ", "nan", "-inf", "1e400", "9" * 5000, "0x10", "1_0", "true", "[red]x[/]", "[/]", "[bold",
    "a" * 300, "a/" * 3000, "\x1b[31mred", "\x00", "\u202etxt", "é\u0301", "\ud800", "<b>&", "]]>",
    "'", '"', "\\", "a\nb", "; touch PWNED;", "$(touch PWNED)", "`touch PWNED`", SECRET,
    "/nowhere/at/all", "..", ".", "~", "{row:100000000d}", "{row.__class__}", "{0}", "{row}", "{",
    "{episode_index:100000000d}", "{episode_index!r:>999999999}", "*", "**", "a|b", "a#b", "#",
    "file:///nowhere", "package://x/y", "http://127.0.0.1:9/x", "concat:a|b", "%s%n", "=1+1",
)  # fmt: skip
NUMBERS: tuple[Any, ...] = (
    0, -1, 1, 2, 3, 7, 255, 65536, 2**31 - 1, 2**31, 2**62, 2**63, -(2**63) - 1, 10**30, 1e-320,
    0.5, -0.5, 1e18, 1e154, 1e308, -1e308, float("nan"), float("inf"), float("-inf"),
)  # fmt: skip


def deep(levels: int) -> Any:
    """A list in a list in a list."""
    value: Any = []
    for _ in range(levels):
        value = [value]
    return value


def value(rng: random.Random) -> Any:
    """Anything that TOML or JSON may hold, seldom what is expected."""
    kind = rng.randrange(7)
    if kind < 2:
        return rng.choice(NUMBERS)
    if kind < 4:
        return rng.choice(TEXTS)
    return rng.choice(
        [None, True, False, [], {}, [1], [[]], ["a"], {"a": 1}, {"empty": [0, 3]}, deep(5),
         {"empty": [0, 2**40]}, deep(200), [0.5] * rng.randrange(12), ["a"] * rng.randrange(5)]
    )  # fmt: skip
