"""A figure with its unit, what is better, and how much worse still counts as the same."""

from __future__ import annotations

import importlib
import math
import time
import traceback
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

PACKAGE = __name__.rpartition(".")[0]

Better = Literal["lower", "higher", "equal"]
Values = Mapping[str, float | None]
"""By the short names of a part's figures; None is what never came (an alarm, a certificate)."""


class Skipped(Exception):
    """A part cannot be measured here; says what is missing."""


@dataclass(frozen=True)
class Figure:
    """One number of a part."""

    name: str
    """Short; `Part.key` puts the part before it."""
    unit: str
    better: Better
    """Which way is better; "equal" where any change is news."""
    tolerance: float
    """How much worse than the frozen value is the same: in the unit, or relative to that value."""
    reason: str
    """Why so much."""
    relative: bool = False
    """Whether the tolerance is a share of the frozen value."""

    def band(self, frozen: float) -> float:
        """The tolerance in the unit."""
        return self.tolerance * abs(frozen) if self.relative else self.tolerance

    def ok(self, value: float | None, frozen: float | None) -> bool:
        """Whether a value is as good as the frozen one, within the tolerance.

        A value that never came, is not finite or was never frozen is not.
        """
        if value is None or frozen is None or not math.isfinite(value):
            return False
        worse = {"lower": value - frozen, "higher": frozen - value, "equal": abs(value - frozen)}
        return worse[self.better] <= self.band(frozen)


@dataclass(frozen=True)
class Part:
    """Figures that one function measures together, in about a minute at most."""

    name: str
    function: str
    """module:function of this package; called with the folder of the data sets."""
    figures: tuple[Figure, ...]
    needs: tuple[str, ...] = ()
    """Data sets, without which it is skipped."""

    def key(self, figure: Figure) -> str:
        """part.figure"""
        return f"{self.name}.{figure.name}"

    @property
    def keys(self) -> dict[str, Figure]:
        """Figures by their whole names."""
        return {self.key(figure): figure for figure in self.figures}


@dataclass(frozen=True)
class Outcome:
    """What measuring a part came to."""

    part: str
    seconds: float
    """Of processor time."""
    values: Mapping[str, float | None] = field(default_factory=dict)
    """By whole names; empty after a failure."""
    skipped: str = ""
    """What is missing, in words."""
    failure: str = ""
    """A traceback."""


def measure(part: Part, data: Path) -> Outcome:
    """Measure one part; a failure is an outcome, so that the others are still measured.

    Args:
        part: what to measure; its module is imported here, so that one that cannot be imported
            costs its own figures only.
        data: folder of the data sets.
    """
    begin = time.process_time()
    try:
        for folder in part.needs:
            if not (data / folder).is_dir():
                raise Skipped(f"needs the data set {folder}, which is not in {data}")
        module, name = part.function.split(":")
        function = getattr(importlib.import_module(f"{PACKAGE}.{module}"), name)
        found: Values = function(data)
        values = {part.key(figure): _number(found[figure.name]) for figure in part.figures}
    except Skipped as word:
        return Outcome(part.name, time.process_time() - begin, skipped=str(word))
    except (Exception, SystemExit):  # a benchmark may end by itself
        return Outcome(part.name, time.process_time() - begin, failure=traceback.format_exc())
    return Outcome(part.name, time.process_time() - begin, values)


def _number(value: float | None) -> float | None:
    return None if value is None else float(value)
