"""Numbers as people read them: mm, degrees and percent, with no more digits than are known."""

from __future__ import annotations

import math
from collections.abc import Sequence

SHOWN = {"rad": (180 / math.pi, "deg"), "m": (1e3, "mm"), "1": (100.0, "%"), "s": (1e3, "ms")}
"""What people read instead of SI; see `read_as` for other units."""

ABSENT = "–"
"""Where there is no number."""


def read_as(unit: str) -> tuple[float, str]:
    """Scale and name of the unit that people read: mm for m; px, N and others as they are."""
    return SHOWN.get(unit, (1.0, unit))


def significant(value: float | None, digits: int = 3) -> str:
    """A number to so many significant digits, never in powers of ten: 0.00123, 54.7, 1230."""
    if value is None or not math.isfinite(value):
        return ABSENT
    return f"{value:.{_decimals(value, digits)}f}"


def shown(value: float | None, unit: str, digits: int = 3) -> str:
    """An SI value in the unit that people read, with that unit: "1.54 mm"; ABSENT has none."""
    scale, name = read_as(unit)
    text = significant(None if value is None else scale * value, digits)
    return text if text == ABSENT else f"{text} {name}"


def millimetres(metres: float) -> str:
    """A length in mm with two decimals, or more where it is small; as verdicts write it."""
    if not math.isfinite(metres):
        return ABSENT
    return f"{1e3 * metres:.{max(_decimals(1e3 * metres, 3), 2) if metres < 1e-4 else 2}f}"


def with_error(value: float, std: float) -> tuple[str, str]:
    """A signed value and its error, both to the second significant digit of the error."""
    decimals = _decimals(std, 2)
    return signed(value, decimals), f"{std:.{decimals}f}"


def signed(value: float, decimals: int) -> str:
    """A value with its sign, but none on what rounds to zero."""
    text = f"{value:+.{decimals}f}"
    return text if text.strip("+-0.") else text[1:]


def listed(words: Sequence[object], most: int) -> str:
    """ "a, b, c", cut after so many words with the number of the others."""
    shown_words = ", ".join(str(word) for word in words[:most])
    return shown_words + (f" and {len(words) - most} more" if len(words) > most else "")


def _decimals(value: float, digits: int) -> int:
    if not value:
        return digits - 1
    # The ninth digit settles what 0.9999 rounds to.
    exponent = math.floor(math.log10(float(f"{abs(value):.{max(digits - 1, 0)}e}")))
    return min(max(digits - 1 - exponent, 0), 6)
