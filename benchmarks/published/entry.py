"""What is stored of a study: its full size, its small size, and which of its numbers count."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from fnmatch import fnmatchcase
from typing import Any

from bodyschema.studies.registry import study_class
from published.spread import numbers

CLOCKS = (
    "seconds", "*.seconds", "*ms_per_frame", "*seconds_a_*", "*microseconds*", "*cpu*", "runs",
    "*.runs", "seed", "paper_*", "*.paper_*",
)  # fmt: skip
"""Times of the machine, settings and the paper's own numbers: no results of a seed."""
FIRST_COPY, GATE = 1001, 2001
"""Seeds of the first copy and of the gate's first run: none is that of the full run."""

RARE = ("*.max", "*.most", "*.least", "*.worst", "*.p90", "*.p95", "*_p95", "*_max")
"""Ends of a distribution, of which a run or two say nothing."""
SHARES = {
    "*share*": 0.5, "*within*": 1.0, "*learned": 1.0, "*precision": 0.1, "*recall": 0.2,
    "*detected": 0.5, "*blamed*": 0.5, "*per_hour": 1.0,
}  # fmt: skip
"""Of one or two runs: a single one changes them by so much."""


@dataclass(frozen=True)
class Told:
    """A number that the page of the studies shows."""

    words: str
    """What it is, with its unit."""
    paper: str = ""
    """What the paper gives for it; empty where it gives nothing."""


@dataclass(frozen=True)
class Entry:
    """A study that is stored. Names of numbers are dotted, patterns those of a shell."""

    paper: str
    figure: str
    small: Mapping[str, Any]
    """Settings of a run of some seconds."""
    full: Mapping[str, Any] = field(default_factory=dict)
    """Settings of the stored run that are not the study's defaults."""
    copies: int = 10
    """Small runs whose spread is stored."""
    keys: tuple[str, ...] = ("*",)
    """Numbers that count."""
    leave: tuple[str, ...] = ()
    """Numbers that do not, though they fit: a small run is too small for them."""
    least: Mapping[str, float] = field(default_factory=dict)
    """Pattern -> the least half-width."""
    told: Mapping[str, Told] = field(default_factory=dict)
    """Name -> what the page says of it; the first dozen, by name, when empty."""

    @property
    def name(self) -> str:
        """The name of its file, without .json."""
        return f"{self.paper}_{self.figure}"

    def study(self, settings: Mapping[str, Any], seed: int | None = None) -> Any:
        """The study with these settings; its class is loaded now."""
        study = study_class(self.paper, self.figure)(**settings)
        return study if seed is None else replace(study, seed=seed)

    def command(self, settings: Mapping[str, Any], seed: int) -> str:
        """What a reader types for the same."""
        flags = [f"--{k.replace('_', '-')} {_words(v)}" for k, v in settings.items()]
        head = f"bodyschema study {self.paper} {self.figure}"
        return " ".join([head, *flags, f"--seed {seed}"])

    def chosen(self, summary: Mapping[str, Any]) -> dict[str, float | None]:
        """The numbers of a summary that count, and those that are told."""
        return {
            name: value
            for name, value in numbers(summary)
            if not _fits(name, CLOCKS) and (name in self.told or self.gated(name))
        }

    def gated(self, name: str) -> bool:
        """Whether a small run must have this number."""
        return _fits(name, self.keys) and not _fits(name, self.leave)

    def least_of(self, name: str) -> float:
        """The widest least half-width among the patterns that fit."""
        return max((v for key, v in self.least.items() if fnmatchcase(name, key)), default=0.0)


def _fits(name: str, patterns: Iterable[str]) -> bool:
    return any(fnmatchcase(name, pattern) for pattern in patterns)


def _words(value: object) -> str:
    return " ".join(map(str, value)) if isinstance(value, tuple | list) else str(value)
