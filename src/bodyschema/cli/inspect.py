"""`bodyschema inspect`: what is in a recording, and the run file to start from."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from bodyschema.errors import InputError, shown

if TYPE_CHECKING:
    from bodyschema.cli.suggested import Suggestion
    from bodyschema.sources.contents import Contents, Stream

MOST_COLUMNS = 40
"""Of a stream that are printed."""


@dataclass(frozen=True)
class Inspect:
    """Say what is in a recording: streams, rates, gaps, ranges, joints; and a run file for it.

    A table, a bag, a LeRobot data set, or a folder of them. Units, joints and what was seen are
    guessed from names and sizes of numbers: correct the run file before you believe an answer.
    """

    recording: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="PATH")]
    """File or folder; "-" for a table that is piped in, bag.mcap#/topic for one topic."""
    robot: Path | None = None
    """The robot's description (URDF, xacro, DH table), whose joints are looked for."""
    write: Path | None = None
    """Write the run file to start from here; a file that is there is never replaced."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Look and print; see the module's text."""
        import os

        from bodyschema.atomic import new_file
        from bodyschema.cli.reading.robot import read_robot
        from bodyschema.cli.suggested import Suggestion
        from bodyschema.documents import is_there
        from bodyschema.sources.contents import contents

        if self.write is not None and is_there(self.write):
            raise InputError(f"'{self.write}' exists; inspect never replaces a file, name another.")
        body = None if self.robot is None else read_robot(self.robot)
        here = Path() if self.write is None else self.write.parent
        robot = "" if self.robot is None else os.path.relpath(self.robot, here)
        found = contents(self.recording)
        suggested = Suggestion.of(found, body, robot)
        text = suggested.text(here)
        if self.write is not None:
            with new_file(self.write, overwrite=False) as temporary:
                temporary.write_text(text, encoding="utf-8")
        if self.json:
            print(json.dumps(_object(found, suggested, text)))
            return 0
        print(shown("\n".join(_told(found, suggested))))
        print(shown(f"\nThe run file to start from:\n\n{text}"), end="")
        if self.write is not None:
            print(shown(f"\nWritten to {self.write}; read it before you calibrate with it."))
        return 0


def _object(found: Contents, suggested: Suggestion, text: str) -> dict[str, Any]:
    streams = [
        {
            "name": stream.name, "type": stream.kind, "rate_hz": stream.rate_hz,
            "samples": stream.samples, "first_s": _ends(stream)[0], "last_s": _ends(stream)[1],
            "gaps": stream.gaps[0], "longest_gap_s": stream.gaps[1], "clock": stream.clock,
            "columns": {name: [low, high] for name, low, high in _ranges(stream)},
        }
        for stream in found.streams
    ]  # fmt: skip
    return {
        "kind": found.kind, "streams": streams, "joints": dict(suggested.joints),
        "joint_unit": suggested.unit if suggested.joints else None,
        "suggested": text, "notes": list(found.notes), **found.more,
    }  # fmt: skip


def _told(found: Contents, suggested: Suggestion) -> Iterator[str]:
    yield f"{found.kind}, {len(found.streams)} stream{'s' * (len(found.streams) != 1)}"
    for stream in found.streams:
        yield ""
        yield f"{stream.name}  ({stream.kind})"
        yield f"  {_pace(stream)}" + (f"; {stream.note}" if stream.note else "")
        ranges = list(_ranges(stream))
        for name, low, high in ranges[:MOST_COLUMNS]:
            yield f"  {name:32} {low:14.6g} to {high:.6g}"
        if len(ranges) > MOST_COLUMNS:
            yield f"  ... and {len(ranges) - MOST_COLUMNS} columns more"
    yield ""
    for name, value in found.more.items():
        yield f"{name}: {value}"
    yield from found.notes
    if suggested.joints:
        some = ", ".join(f"{j} ({c})" if j != c else j for j, c in suggested.joints.items())
        yield f"joints, guessed to be in {suggested.unit}: {some}"
    elif suggested.body is not None:
        yield f"no column is named like a joint of {suggested.body.name}"
    for seen in suggested.seen:
        group = seen.group
        yield (
            f"may be {group.kind} in {group.unit}: {', '.join(group.columns)} of {seen.stream.name}"
        )


def _pace(stream: Stream) -> str:
    """Samples, rate, times and gaps in words."""
    words = [f"{stream.samples} samples"]
    if stream.rate_hz is not None:
        words.append(f"{stream.rate_hz:.4g} Hz")
    first, last = _ends(stream)
    if first is None or last is None:
        return ", ".join([*words, "no clock"] if stream.rate_hz is None else words)
    words.append(f"{last - first:.3f} s from {first:.3f} s" + (" since 1970" * (first > 1e8)))
    many, longest = stream.gaps
    words.append(f"{many} gaps, the longest {longest:.3g} s" if many else "no gaps")
    return ", ".join(words)


def _ends(stream: Stream) -> tuple[float | None, float | None]:
    if stream.time is None or not len(stream.time):
        return None, None
    return float(stream.time[0]), float(stream.time[-1])


def _ranges(stream: Stream) -> Iterator[tuple[str, float, float]]:
    """Columns with the least and largest of their numbers."""
    import numpy as np

    columns = {} if stream.recording is None else stream.recording.columns
    for name, values in columns.items():
        finite = values[np.isfinite(values)]
        if len(finite) and name != stream.clock:
            yield name, float(finite.min()), float(finite.max())
