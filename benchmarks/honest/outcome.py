"""Outcome: what one answer stated, and what was true."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

WRONG = 2.0
"""The true 95 % error may be this many times the stated one: what a user would call a surprise."""


@dataclass(frozen=True)
class Outcome:
    """One run."""

    kind: str
    """"calibrate", "hand-eye", "payload", "track" or "touch"."""
    fault: str
    index: int
    """Number of the run among those of its fault; with the seed it gives the run again."""
    good: bool
    """Nothing is wrong with the recording: only the flag and the width of the bars count."""
    apart: bool
    """No rival is made for this fault; told apart."""
    about: str
    """What was drawn, in words."""
    unit: str
    """Of the two errors; several units in one run are brought to shares of what was stated."""
    stated: float | None
    """95 % error that the answer states; None where it states none."""
    true: float
    """95 % error that it has."""
    level: str
    """Of its trust."""
    verdict: str
    withheld: bool
    reason: str = ""
    """The first of its trust, or why it was refused."""
    crash: str = ""
    """An exception that is no refusal."""
    single: bool = False
    """The true error is one number, not 95 % of many: it is below its 95 % bar nearly always."""
    sense: str = ""
    """What saw the robot, where a kind has several."""
    seconds: float = 0.0
    """Of the processor."""

    @property
    def wrong(self) -> bool:
        """Whether the truth is beyond twice what was stated; a refusal states nothing."""
        if self.stated is None:
            return not self.withheld
        return not self.true <= WRONG * self.stated

    @property
    def flagged(self) -> bool:
        """Whether the answer gave no green light."""
        return self.level != "good" or self.withheld

    @property
    def doubted(self) -> bool:
        """Whether its trust is not good; what counts in a good run."""
        return self.level != "good"

    @property
    def unflagged(self) -> bool:
        """Wrong under a green light."""
        return self.wrong and not self.flagged

    @property
    def ratio(self) -> float:
        """Stated over true; nan where nothing was stated."""
        return math.nan if self.stated is None or not self.true > 0 else self.stated / self.true

    @property
    def name(self) -> str:
        """What `--only` takes to make it again."""
        return f"{self.fault}:{self.index}"

    @property
    def record(self) -> dict[str, Any]:
        """A line of the ledger."""
        return {**asdict(self), "wrong": self.wrong, "unflagged": self.unflagged}
