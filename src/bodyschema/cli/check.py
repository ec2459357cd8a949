"""`bodyschema check`: does a calibration still explain a new recording?"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import tyro

from bodyschema.errors import InputError
from bodyschema.monitoring.change import ChangeTest, Suspect, detect_change


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
        from bodyschema.cli.loading import read_senses
        from bodyschema.cli.run_file import run_from_record
        from bodyschema.export.estimate_json import read_result

        if not 0 < self.false_alarm < 1:
            raise InputError(
                f"--false-alarm is a probability, between 0 and 1; got {self.false_alarm}."
            )
        stored = read_result(self.result)
        paths = tuple(str(path.resolve()) for path in self.recording)
        run = replace(run_from_record(stored.run), recording=paths)
        senses = read_senses(run, stored.estimate.reference)
        rows = len({int(row) for sense in senses for row in sense.rows})
        if rows < 3:
            raise InputError(
                f"the recording shows {rows} postures; at least 3 are needed to check."
            )
        answer = detect_change(stored.estimate, senses, stored.fields, self.false_alarm)
        if self.json:
            print(json.dumps(check_json(answer, rows)))
        else:
            print(describe_check(answer, rows, self))
        return 1 if answer.changed else 0


def check_json(answer: ChangeTest, rows: int) -> dict[str, Any]:
    """The answer in plain types; changes in SI."""
    return {
        "verdict": "changed" if answer.changed else "still true",
        "changed": answer.changed,
        "p_value": answer.p_value,
        "suspects": [
            {
                "part": suspect.part,
                "p_value": suspect.p_value,
                "change": dict(zip(suspect.names, map(float, suspect.change), strict=True)),
            }
            for suspect in answer.suspects
        ],
        "position_rms_mm": 1e3 * answer.position_rms,
        "rows": rows,
    }


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


def _blame(suspect: Suspect) -> str:
    units = {"turn": (180 / math.pi, "deg"), "offset": (180 / math.pi, "deg"), "link": (1e3, "mm")}
    parts = []
    for name, value in zip(suspect.names, suspect.change, strict=True):
        what = name.removeprefix(f"{suspect.part}.")
        scale, unit = units[what.split("_")[0]]
        parts.append(f"{what} {scale * value:+.2f} {unit}")
    return f"{suspect.part}: {', '.join(parts)}"
