"""Trial: one call of a verb, the fault that its input has, and how its answer compares."""

from __future__ import annotations

import time
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from bodyschema.errors import InputError
from honest.outcome import Outcome


@dataclass(frozen=True)
class Trial:
    """What a user does, ready to be done."""

    about: str
    """What was drawn, in words."""
    ask: Callable[[], Any]
    """Calls the verb; returns its answer."""
    compare: Callable[[Any], tuple[float | None, float]]
    """The 95 % error that an answer states, and that it has; in one unit."""
    unit: str = "m"
    single: bool = False
    """See `Outcome.single`."""
    sense: str = ""
    """See `Outcome.sense`."""


@dataclass(frozen=True)
class Row:
    """One row of the campaign's table: a fault of one verb's input."""

    kind: str
    fault: str
    draw: Callable[[np.random.Generator], Trial]
    good: bool = False
    """Nothing is wrong."""
    apart: bool = False
    """No rival is made for it."""
    weight: int = 1
    """Share of the kind's runs."""

    def run(self, index: int, seed: int) -> Outcome:
        """The index-th run; the same whatever else is run."""
        key = zlib.crc32(f"{self.kind}/{self.fault}".encode())
        trial = self.draw(np.random.default_rng([seed, key, index]))
        begin = time.process_time()
        stated, true, said, crash = None, float("nan"), ("good", "refused", True, ""), ""
        try:
            answer = trial.ask()
            stated, true = trial.compare(answer)
            reasons = answer.trust.reasons
            said = (
                answer.trust.level, str(answer.verdict), answer.withheld,
                reasons[0] if reasons else "",
            )  # fmt: skip
        except InputError as refusal:
            said = ("contradicted", "input refused", True, str(refusal))
        except Exception as error:
            crash = f"{type(error).__name__}: {error}"
        level, verdict, withheld, reason = said
        return Outcome(
            self.kind, self.fault, index, self.good, self.apart, trial.about, trial.unit,
            stated, true, level, verdict, withheld, reason, crash, trial.single, trial.sense,
            time.process_time() - begin,
        )  # fmt: skip
