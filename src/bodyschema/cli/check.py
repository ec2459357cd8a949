"""`bodyschema check`: does a calibration still explain a new recording?

A few postures are tested as a whole. A recording with times, long and dense enough, is watched as
well: then the answer also says when something changed.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import tyro

from bodyschema.errors import InputError
from bodyschema.monitoring.change import ChangeTest, Suspect, detect_change
from bodyschema.monitoring.labelling import EVERYTHING
from bodyschema.monitoring.stream_check import (
    UNNAMED,
    Change,
    StreamCheck,
    check_stream,
    is_stream,
)
from bodyschema.senses.sense import Sense

POSTURES = 100
"""Of a stream, that are tested as a whole."""


@dataclass(frozen=True)
class Check:
    """Test a calibration on a new recording: a robot's morning test. Exit code 1 if it changed."""

    result: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RESULT")]
    """Folder that `calibrate` wrote."""
    recording: tuple[Path, ...]
    """New recording with the same columns; several files are joined row by row."""
    false_alarm: float = 0.01
    """Chance of calling an unchanged robot changed."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Test; returns 1 when the body has changed."""
        from bodyschema.answers.answer import load
        from bodyschema.cli.loading import read_senses
        from bodyschema.cli.run_file import run_from_record

        if not 0 < self.false_alarm < 1:
            raise InputError(
                f"--false-alarm is a probability, between 0 and 1; got {self.false_alarm}."
            )
        stored = load(self.result)
        paths = tuple(str(path.resolve()) for path in self.recording)
        run = replace(run_from_record(stored.run), recording=paths)
        senses = read_senses(run, stored.estimate.reference)
        rows = len({int(row) for sense in senses for row in sense.rows})
        if rows < 3:
            raise InputError(
                f"the recording shows {rows} postures; at least 3 are needed to check."
            )
        stream = None
        if is_stream(senses):
            # Two tests share the allowed rate; the first takes the recording as one moment.
            half = self.false_alarm / 2
            answer = detect_change(stored.estimate, thinned(senses), stored.fields, half)
            stream = check_stream(stored.estimate, senses, half)
        else:
            answer = detect_change(stored.estimate, senses, stored.fields, self.false_alarm)
        if self.json:
            print(json.dumps(check_json(answer, rows, stream)))
        elif stream is not None and stream.changes:
            print(describe_changes(stream))
        else:
            print(describe_check(answer, rows, self))
        return 1 if answer.changed or (stream is not None and stream.changes) else 0


def thinned(senses: Sequence[Sense]) -> list[Sense]:
    """At most POSTURES samples of each sense, evenly spread over the recording."""
    return [
        sense.take(np.unique(np.linspace(0, len(sense) - 1, POSTURES).astype(int)))
        for sense in senses
    ]


def check_json(answer: ChangeTest, rows: int, stream: StreamCheck | None = None) -> dict[str, Any]:
    """The answer in plain types; changes in SI, "watched_s" null where there was no stream."""
    changes = stream.changes if stream is not None else ()
    changed = answer.changed or bool(changes)
    suspects: Sequence[Suspect | Change] = changes or answer.suspects
    return {
        "verdict": "changed" if changed else "still true",
        "changed": changed,
        "p_value": min([answer.p_value, *(change.p_value for change in changes)]),
        "suspects": [
            {
                "part": suspect.part,
                "p_value": suspect.p_value,
                "change": dict(zip(suspect.names, map(float, suspect.change), strict=True)),
            }
            for suspect in suspects
        ],
        "position_rms_mm": 1e3 * answer.position_rms,
        "rows": rows,
        "watched_s": stream.seconds if stream is not None else None,
        "changes": [
            {
                "part": change.part,
                "time_s": change.time,
                "row": change.row,
                "noticed_s": change.noticed,
                "change": dict(zip(change.names, change.change, strict=True)),
                "std": dict(zip(change.names, change.std, strict=True)),
                "p_value": change.p_value,
            }
            for change in changes
        ],
    }


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


def describe_check(answer: ChangeTest, rows: int, asked: Check) -> str:
    """The answer in words, with what to do next."""
    size = f"{1e3 * answer.position_rms:.2f} mm typical error over {rows} postures"
    if not answer.changed:
        return f"still true: {size}; p = {answer.p_value:.2g} (alarm below {asked.false_alarm:g})."
    blamed = "\n".join(f"  {_blame(suspect)}" for suspect in answer.suspects)
    which = "It is one of these" if len(answer.suspects) > 1 else "It is this part"
    return (
        f"changed: {size}; p = {answer.p_value:.2g} (alarm below {asked.false_alarm:g}).\n"
        f"{which}, moved by about\n{blamed}\n"
        "Next: look at it, then calibrate anew from a fresh recording."
    )


def _blame(suspect: Suspect | Change) -> str:
    units = {"turn": (180 / math.pi, "deg"), "offset": (180 / math.pi, "deg"), "link": (1e3, "mm")}
    stds = suspect.std if isinstance(suspect, Change) else [None] * len(suspect.names)
    parts = []
    for name, value, std in zip(suspect.names, suspect.change, stds, strict=True):
        what = name.removeprefix(f"{suspect.part}.")
        scale, unit = units[what.split("_")[0]]
        sure = "" if std is None else f" +- {scale * std:.2f}"
        parts.append(f"{what} {scale * value:+.2f}{sure} {unit}")
    return f"{suspect.part}: {', '.join(parts)}"
