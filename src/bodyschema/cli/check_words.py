"""The answer of `check` in words, with what to do next."""

from __future__ import annotations

import math

from bodyschema.answers.recheck import Recheck
from bodyschema.monitoring.blame import EVERYTHING
from bodyschema.monitoring.change import ChangeTest
from bodyschema.monitoring.moved_part import Suspect
from bodyschema.monitoring.stream_check import UNNAMED, Change, StreamCheck

UNITS = {
    "turn": (180 / math.pi, "deg"),
    "offset": (180 / math.pi, "deg"),
    "link": (1e3, "mm"),
    "mass": (1e3, "g"),
    "com": (1e3, "mm"),
    "moment": (1e3, "g m2"),
}
"""What people read of a parameter, by the first word of its name."""


def describe_changes(stream: StreamCheck) -> str:
    """What changed within a recording, and when, with what to do next."""
    lines = []
    for change in stream.changes:
        when = f"changed at {change.time:.2f} s (row {change.row}"
        lines.append(
            f"{when}, noticed {change.noticed - change.time:.2f} s later): {_what(change)}"
        )
    return "\n".join([*lines, "Next: look at it, then calibrate anew from a fresh recording."])


def _what(change: Change) -> str:
    if change.part == UNNAMED:
        return "the recording ends before it is clear what."
    if change.part == EVERYTHING:
        return "more than one part; what came after was not watched."
    return _blame(change)


def describe_check(found: Recheck, false_alarm: float) -> str:
    """The answer in words, with what to do next."""
    test = found.test
    told = f"{found.size}; p = {test.p_value:.2g} (alarm below {false_alarm:g})."
    if not test.changed:
        return f"still true: {told}"
    lines = [f"changed: {told}"]
    if test.suspects:
        lines += [f"{_which(test)}, moved by about", *(f"  {_blame(one)}" for one in test.suspects)]
    return "\n".join([*lines, f"Next: {found.then}"])


def _which(test: ChangeTest) -> str:
    """What is blamed, and whether it explains all that does not fit."""
    if test.alone:
        return "It is one of these" if len(test.suspects) > 1 else "It is this part"
    share = f"{test.suspects[0].share:.0%}"
    return f"More than one part has moved, or one bends; the best alone explains {share}"


def _blame(suspect: Suspect | Change) -> str:
    stds = suspect.std if isinstance(suspect, Change) else [None] * len(suspect.names)
    parts = []
    for name, value, std in zip(suspect.names, suspect.change, stds, strict=True):
        what = name.removeprefix(f"{suspect.part}.")
        scale, unit = UNITS[what.split("_")[0]]
        sure = "" if std is None else f" +- {scale * std:.2f}"
        parts.append(f"{what} {scale * value:+.2f}{sure} {unit}")
    return f"{suspect.part}: {', '.join(parts)}"
