"""When and where something touches what a wrist holds: the load is learned, then taken off."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from bodyschema.answers.answer import Answer
from bodyschema.answers.held_recording import hold
from bodyschema.answers.payload import is_known, load_answer, load_details
from bodyschema.errors import InputError
from bodyschema.learners.touch.finder import Touch
from bodyschema.learners.touch.known_load import KnownLoad
from bodyschema.learners.touch.search import TouchSearch
from bodyschema.model.solid import Solid
from bodyschema.model.tree import Body
from bodyschema.report.touch import Touches
from bodyschema.senses.wrench_means import Averaging
from bodyschema.senses.wrist_columns import WristTable
from bodyschema.senses.wrist_declaration import (
    LoadSegments,
    MotionReading,
    WristDeclaration,
)
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

SLIM = 0.05
"""Chance of another place from which it is mentioned."""


def find_touches(
    table: WristTable,
    declared: WristDeclaration,
    quiet: tuple[float, ...],
    solid: Solid | None = None,
    gains: float = 0.01,
    false_per_hour: float = 0.1,
    window: float = 0.25,
    motion: MotionReading | None = None,
    described: Body | None = None,
    run: Mapping[str, Any] | None = None,
) -> Answer:
    """Find touches of what a wrist holds.

    Args:
        table: the recording.
        declared: what its columns hold.
        quiet: (from, to) s in which nothing touches, ten seconds of motion or more.
        solid: the object in the sensor's frame; None if its shape is not known.
        gains: share of itself by which each reading may be off.
        false_per_hour: touches an hour that may be felt where there are none.
        window: s that are averaged.
        motion: how the quiet motion is read.
        described: the robot as described, if there is one.
        run: what was asked, to be kept with the answer.

    Raises:
        InputError: anything that cannot be used, in one sentence.
    """
    begin = time.perf_counter()
    samples = table.read(declared).samples
    calm = _between(samples, *quiet)
    held = hold(table, declared, motion, LoadSegments(loaded=tuple(quiet)))
    details, found = load_details(held), None
    if is_known(details):
        search = TouchSearch.taught(
            calm,
            KnownLoad.of(held.fit.solution),
            solid,
            gain_std=gains,
            false_per_hour=false_per_hour,
            averaging=Averaging(window=window),
        )
        found = [touch_entry(touch) for touch in search.touches(samples)]
    answer = load_answer(held, described, run, begin, verb="touch")
    return _told(answer, found)


def _told(answer: Answer, touches: list[dict[str, Any]] | None) -> Answer:
    """The answer of the quiet motion with the touches that were found; None: none was sought."""
    (load,) = answer.details["loads"]
    mass = f"{load['mass']:.4f} ± {load['mass_std']:.4f} kg"
    if touches is None:
        verdict = "load not known"
        says = "No touch was looked for: the quiet motion does not tell the load."
    elif touches:
        verdict, n = "touched", len(touches)
        says = f"{n} touch{'es' * (n > 1)} of a load of {mass}."
    else:
        verdict, says = "untouched", f"Nothing touched the load of {mass}."
    lines = [touch_line(touch) for touch in touches or ()]
    lines += ["Places in mm along the sensor's axes, ± 95 % in the worst direction."] * bool(lines)
    short = {key: load[key] for key in ("mass", "mass_std", "com")}
    sections = (Touches(touches), *answer.sections) if touches else answer.sections
    return replace(
        answer,
        verdict=verdict,
        explanation=says,
        findings=(*lines, *answer.findings),
        details={**answer.details, "load": short, "touches": touches},
        sections=sections,
    )


def _between(samples: WristSamples, low: float, high: float) -> WristSamples:
    time = samples.time
    rows = np.flatnonzero((time >= low) & (time <= high))
    if len(rows) < 2 or time[rows[-1]] - time[rows[0]] < SHORTEST:
        raise InputError(
            f"quiet = [{low:g}, {high:g}] holds {len(rows)} rows of the recording, which runs from "
            f"{time[0]:.13g} to {time[-1]:.13g} s; give {SHORTEST:g} s of motion or more."
        )
    return samples.take(rows)


def touch_entry(touch: Touch) -> dict[str, Any]:
    """A touch in plain types: s, N, Nm, m; places along the sensor's axes."""
    return {
        "begins": touch.begins,
        "ends": touch.ends,
        "force": touch.force.tolist(),
        "verdict": touch.verdict,
        "p_value": touch.p_value,
        "on_surface": bool(touch.inside),
        "couple": touch.couple,
        "couple_std": touch.couple_std,
        "places": [
            {
                "point": place.point.tolist(),
                "covariance": place.covariance.tolist(),
                "normal": None if place.normal is None else place.normal.tolist(),
                "chance": float(place.chance),
            }
            for place in touch.places
        ],
    }


def touch_line(touch: Mapping[str, Any]) -> str:
    """A touch in words."""
    places: Sequence[Mapping[str, Any]] = touch["places"]
    x, y, z = (1e3 * value for value in places[0]["point"])
    spread = np.linalg.eigvalsh(np.array(places[0]["covariance"]))[-1]
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
    others = [other for other in places[1:] if other["chance"] > SLIM]
    return line + (f"; or at {len(others)} more (answer.json tells)" if others else "")
