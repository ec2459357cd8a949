"""Trust: whether an answer may be used, and why not, in sentences."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

Level = Literal["good", "limited", "contradicted"]
LEVELS: tuple[Level, ...] = ("good", "limited", "contradicted")


@dataclass(frozen=True)
class Trust:
    """How far an answer may be believed."""

    level: Level = "good"
    """"limited": usable, its error bars widened by what disagrees; "contradicted": the data speak
    against what the answer presumes, and nothing may be put on a robot."""
    reasons: tuple[str, ...] = ()
    """A sentence each, with the figure that decided; the gravest first."""

    def also(self, other: Trust) -> Trust:
        """Both: the lower level, and all reasons, those of the lower level first."""
        first, second = sorted((self, other), key=lambda t: -LEVELS.index(t.level))
        reasons = tuple(dict.fromkeys((*first.reasons, *second.reasons)))
        return Trust(first.level, reasons)

    @property
    def document(self) -> dict[str, Any]:
        """Plain values, as JSON has them."""
        return {"level": self.level, "reasons": list(self.reasons)}
