"""Accuracy: held-out errors of everything that was seen, each component in its own unit."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.held_out import Errors
from bodyschema.senses.sense import Sense
from bodyschema.units import millimetres, read_as, shown

Array = NDArray[np.float64]
Key = tuple[str, str]
"""Name and unit of a component, such as ("position", "m")."""


@dataclass(frozen=True)
class Accuracy:
    """Held-out errors over the rows that are no outliers, senses with the same component pooled."""

    errors: Mapping[Key, Errors]
    """In SI units; the first is what the answer speaks of."""
    numbers: Mapping[Key, int]
    """How many numbers were seen of each."""

    @classmethod
    def of(
        cls,
        senses: Sequence[Sense],
        residuals: Sequence[Array],
        good: Sequence[NDArray[np.bool_]],
    ) -> Accuracy:
        """Lengths of each component's residual, (n, dimension) a sense, where `good` (n,)."""
        lengths: dict[Key, list[Array]] = {}
        numbers: dict[Key, int] = {}
        for sense, residual, mask in zip(senses, residuals, good, strict=True):
            for name, unit, part in sense.components:
                kept = residual[mask][:, part]
                lengths.setdefault((name, unit), []).append(np.linalg.norm(kept, axis=1))
                numbers[name, unit] = numbers.get((name, unit), 0) + kept.size
        order = sorted(lengths, key=lambda key: key != ("position", "m"))
        return cls({k: Errors.of(np.concatenate(lengths[k])) for k in order}, numbers)

    @property
    def main(self) -> tuple[str, str, Errors]:
        """Name, unit and errors of what the answer speaks of: positions, if any were seen."""
        (name, unit), errors = next(iter(self.errors.items()))
        return name, unit, errors

    @property
    def position(self) -> Errors | None:
        """m; None where no position was seen."""
        return self.errors.get(("position", "m"))

    @property
    def rotation(self) -> Errors | None:
        """rad; None where no pose was seen."""
        return self.errors.get(("rotation", "rad"))

    def worse_than(self, other: Accuracy) -> bool:
        """Whether the errors are larger than others of the same samples.

        Mean logarithm of the ratio of rms errors, each component by the numbers seen of it: with
        one component, simply its rms error.
        """
        total = 0.0
        for key, count in self.numbers.items():
            mine, its = self.errors[key].rms, other.errors[key].rms
            if count and mine > 0 and its > 0:
                total += count * math.log(mine / its)
        return total > 0

    def document(self) -> dict[str, dict[str, float]]:
        """Plain values as people read them: "position_mm" -> rms, median, max."""
        found = {}
        for (name, unit), errors in self.errors.items():
            scale, word = read_as(unit)
            key = f"{name.replace(' ', '_')}_{word.replace('/', '_per_').replace('^', '')}"
            found[key] = {k: scale * getattr(errors, k) for k in ("rms", "median", "max")}
        return found


def change_in_words(before: Accuracy, after: Accuracy) -> str:
    """ "from 5.21 to 0.84 mm rms", with the other components in brackets."""
    spans: list[str] = []
    for (name, unit), errors in after.errors.items():
        old, word = before.errors[name, unit].rms, read_as(unit)[1]
        span = f"from {_figure(old, unit)} to {_figure(errors.rms, unit)} {word} rms"
        spans.append(span if not spans else f"{name} {span}")
    rest = [span for span in spans[1:] if not span.startswith("rotation")]
    return spans[0] + (f" ({'; '.join(rest)})" if rest else "")


def main_in_words(accuracy: Accuracy) -> str:
    """ "0.84 mm" of what the answer speaks of."""
    _, unit, errors = accuracy.main
    return in_words(errors.rms, unit)


def in_words(value: float, unit: str) -> str:
    """ "0.84 mm": an error with its unit."""
    return f"{_figure(value, unit)} {read_as(unit)[1]}"


def _figure(value: float, unit: str) -> str:
    return millimetres(value) if unit == "m" else shown(value, unit).split(" ")[0]
