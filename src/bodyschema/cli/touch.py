"""`bodyschema touch`: when and where something touches what the wrist holds."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
import tyro

from bodyschema.errors import InputError

if TYPE_CHECKING:
    from bodyschema.cli.wrist.touch_file import TouchFile
    from bodyschema.learners.touch.finder import Touch
    from bodyschema.senses.wrist_samples import WristSamples

SHORTEST = 5.0
"""s of quiet motion, from which a load can be learned at all."""

WORDS = {
    "point": "",
    "twist": "not a point: there is a couple along the force",
    "beside": "not on the surface: the line of the force passes beside it",
    "moving": "not one point: the contact moves, spreads, or there are several",
}

REACH95 = 2.4477
"""Two-dimensional normal: the radius that holds 95 %."""


@dataclass(frozen=True)
class TouchVerb:
    """Find touches of what a wrist holds (see docs/touch.md).

    Exit code 1 if the quiet motion does not tell the load well enough.
    """

    run_file: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RUN.toml")]
    """The recording, which columns are what, the object's shape, and when nothing touches it."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Read, learn the load, search; returns 1 when the load is not told."""
        from bodyschema.cli.wrist.held_recording import identify
        from bodyschema.cli.wrist.payload_answer import payload_answer, told
        from bodyschema.cli.wrist.payload_file import Segments
        from bodyschema.cli.wrist.touch_file import read_touch_file
        from bodyschema.cli.wrist.wrist_columns import read_wrist

        file = read_touch_file(self.run_file)
        samples = read_wrist(file.run, file.run.recording).samples
        quiet = _between(samples, *file.touch.quiet)
        only = Segments(loaded=file.touch.quiet)
        held = identify(replace(file.run, segments=only, empty_recording=""))
        payload = payload_answer(held)
        answer = {
            "load": {key: payload["loads"][0][key] for key in ("mass", "mass_std", "com")},
            "touches": None,
            "notes": payload["notes"],
        }
        if told(payload):
            touches = _search(file, quiet, samples, held.fit.solution)
            answer["touches"] = [plain(touch) for touch in touches]
        print(json.dumps(answer) if self.json else describe(answer))
        return 0 if told(payload) else 1


def _search(
    file: TouchFile, quiet: WristSamples, samples: WristSamples, solution: Any
) -> list[Touch]:
    from bodyschema.cli.wrist.touch_file import solid_of
    from bodyschema.learners.touch.known_load import KnownLoad
    from bodyschema.learners.touch.search import TouchSearch
    from bodyschema.senses.wrench_means import Averaging

    settings = file.touch
    search = TouchSearch.taught(
        quiet,
        KnownLoad.of(solution),
        solid_of(file),
        gain_std=settings.gains,
        false_per_hour=settings.false_per_hour,
        averaging=Averaging(window=settings.window),
    )
    return search.touches(samples)


def _between(samples: WristSamples, low: float, high: float) -> WristSamples:
    time = samples.time
    rows = np.flatnonzero((time >= low) & (time <= high))
    if len(rows) < 2 or time[rows[-1]] - time[rows[0]] < SHORTEST:
        raise InputError(
            f"quiet = [{low:g}, {high:g}] holds {len(rows)} rows of the recording, which runs from "
            f"{time[0]:.13g} to {time[-1]:.13g} s; give {SHORTEST:g} s of motion or more."
        )
    return samples.take(rows)


def plain(touch: Touch) -> dict[str, Any]:
    """A touch in plain types: s, N, Nm, m; places along the sensor's axes."""
    return {
        "begins": touch.begins,
        "ends": touch.ends,
        "force": touch.force.tolist(),
        "verdict": touch.verdict,
        "p_value": touch.p_value,
        "on_surface": touch.inside,
        "couple": touch.couple,
        "couple_std": touch.couple_std,
        "places": [
            {
                "point": place.point.tolist(),
                "covariance": place.covariance.tolist(),
                "normal": None if place.normal is None else place.normal.tolist(),
                "chance": place.chance,
            }
            for place in touch.places
        ],
    }


def describe(answer: dict[str, Any]) -> str:
    """The answer in words."""
    load = answer["load"]
    lines = [f"load: {load['mass']:.4f} ± {load['mass_std']:.4f} kg"]
    if answer["touches"] is None:
        lines.append("No touch was looked for: the quiet motion does not tell the load.")
    elif answer["touches"]:
        lines += [_line(touch) for touch in answer["touches"]]
        lines.append("Places in mm along the sensor's axes, ± 95 % in the worst direction.")
    else:
        lines.append("Nothing touched it.")
    return "\n".join([*lines, *(f"Note: {note}" for note in answer["notes"])])


def _line(touch: dict[str, Any]) -> str:
    place = touch["places"][0]
    x, y, z = (1e3 * value for value in place["point"])
    spread = np.linalg.eigvalsh(np.array(place["covariance"]))[-1]
    until = "the end" if touch["ends"] is None else f"{touch['ends']:.2f} s"
    size = float(np.linalg.norm(touch["force"]))
    line = (
        f"{touch['begins']:.2f} s to {until}: {size:.2f} N at ({x:.1f}, {y:.1f}, {z:.1f}) "
        f"± {1e3 * REACH95 * float(np.sqrt(spread)):.1f}"
    )
    if touch["verdict"] != "point":
        return f"{line}; {WORDS[touch['verdict']]}"
    if not touch["on_surface"]:
        line += "; the line of the force just misses the surface"
    others = [other for other in touch["places"][1:] if other["chance"] > 0.05]
    return line + (f"; or at {len(others)} more (--json tells)" if others else "")
