"""When and where something touches what a wrist holds: the load is learned, then taken off."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import chdtrc, chdtri

from bodyschema.answers.answer import Answer
from bodyschema.answers.held_recording import hold
from bodyschema.answers.payload import is_known, load_answer, load_details
from bodyschema.errors import InputError
from bodyschema.estimation.prediction import length_quantile
from bodyschema.learners.touch.doubtful import Taught, force_error
from bodyschema.learners.touch.finder import Touch
from bodyschema.learners.touch.known_load import KnownLoad
from bodyschema.learners.touch.search import TouchSearch
from bodyschema.learners.touch.unexplained import Unexplained
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
from bodyschema.threads import one_thread
from bodyschema.trust.trust import Trust

SHORTEST = 5.0
"""s of quiet motion, from which a load can be learned at all."""

WORDS = {
    "point": "",
    "twist": "not a point: there is a couple along the force",
    "beside": "not on the surface: the forces meet beside it",
    "moving": "not one point: the contact moves, spreads, or there are several",
}

SURFACE = 0.002
"""m, one standard deviation that the surface of what is held may be off: meshes are that good, and
mounted that well."""

REACH95 = 2.4477
"""Two-dimensional normal: the radius that holds 95 %."""

LONG = 0.5
"""s in postures that were not taught, from which that is said."""

BESIDE = 0.02
"""Chance, over all touches, that forces meet so far beside the surface; from there on its place is
doubted. Of 28 good simulated touches none is above 1.8, of displaced ones most are above 7."""

SLIM = 0.05
"""Chance of another place from which it is mentioned."""


@one_thread
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
    surface: float = SURFACE,
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
        surface: m, one standard deviation that the object's surface may be off; 0 if it is exact.

    Raises:
        InputError: anything that cannot be used, in one sentence.
    """
    begin = time.perf_counter()
    _between(table.read(declared).samples, *quiet)
    held = hold(table, declared, motion, LoadSegments(loaded=tuple(quiet)))
    felt = None
    if is_known(load_details(held)):
        calm = _between(held.samples, *quiet)
        search = TouchSearch.taught(
            calm,
            KnownLoad.of(held.fit.solution, whole=held.fit.whole),
            solid,
            gain_std=gains,
            false_per_hour=false_per_hour,
            averaging=Averaging(window=window),
            surface=surface,
        )
        felt = Felt.by(search, calm, held.samples)
    answer = load_answer(held, described, run, begin, verb="touch")
    return _told(answer, felt)


@dataclass(frozen=True)
class Felt:
    """What was felt in a recording."""

    touches: list[dict[str, Any]]
    refused: list[dict[str, Any]]
    """Wrenches that are no touch, with the key "why"."""
    outside: float
    """s in postures that the load was not taught in."""
    worst: float
    """N, standard error of the load's force there."""

    @classmethod
    def by(cls, search: TouchSearch, calm: WristSamples, samples: WristSamples) -> Felt:
        """Search a recording.

        Args:
            search: that knows the load.
            calm: the quiet motion.
            samples: the recording.
        """
        taught = Taught.by(search.unexplained(calm), search.finder.noise)
        means = search.averaging.means(samples)
        left, touches, refused = Unexplained.of(means, search.load), [], []
        for touch in search.finder.touches(left):
            why = taught.doubt(touch, left, means.Y)
            if why:
                refused.append({**touch_entry(touch), "why": why})
            else:
                touches.append(touch_entry(touch))
        out = taught.outside(left)
        worst = float(force_error(left.take(out)).max(initial=0.0))
        return cls(touches, refused, float(out.sum()) / left.rate, worst)

    @property
    def trust(self) -> Trust:
        """What speaks against touches, and against their absence."""
        found = []
        if self.outside > LONG or any(one["why"] == "untaught" for one in self.refused):
            found.append(
                f"{self.outside:.1f} s of the recording are in postures outside those that the "
                f"load was taught in: its force is known to ± {self.worst:.2g} N only there, and "
                "no touch is told from that. Teach it in these postures too (quiet)."
            )
        crept = [one for one in self.refused if one["why"] == "crept"]
        if crept:
            size = max(float(np.linalg.norm(one["force"])) for one in crept)
            found.append(
                f"a wrench of up to {size:.2g} N crept in {len(crept)} time"
                f"{'s' * (len(crept) > 1)}, as no touch does: the sensor's offset drifts, or the "
                "load changes. Warm the sensor up, and repeat the quiet motion."
            )
        if any(one["why"] == "load" for one in self.refused):
            found.append(
                "a wrench that lasts is as well explained by another load as by a touch: what is "
                "held slipped, grew, or was put down on something; learn it anew."
            )
        n = len(self.touches)
        beside = [one["beside"] for one in self.touches if self._is_beside(one)]
        if beside:
            found.append(
                f"the forces of {len(beside)} of {n} touches meet beside the surface that was "
                f"described (chance {float(chdtrc(1, max(beside))):.1g} at the most): perhaps it "
                "is elsewhere or of another shape, or another thing was touched, and then the "
                "places of all touches are as wrong. Check [surface]."
            )
        return Trust("limited", tuple(found)) if found else Trust()

    def _is_beside(self, touch: Mapping[str, Any]) -> bool:
        """Whether a touch, one of so many, is not on the surface."""
        surprising = touch["beside"] > chdtri(1, BESIDE / len(self.touches))
        return touch["verdict"] == "beside" or (touch["verdict"] == "point" and bool(surprising))

    @property
    def place_95(self) -> float | None:
        """m that the error of every place stays below with 95 %; None without a touch."""
        told = [np.array(one["places"][0]["covariance"]) for one in self.touches]
        return max((length_quantile([C], np.inf, 0.95) for C in told), default=None)


def _told(answer: Answer, felt: Felt | None) -> Answer:
    """The answer of the quiet motion with what was felt; None: nothing was sought."""
    (load,) = answer.details["loads"]
    mass = f"{load['mass']:.4f} ± {load['mass_std']:.4f} kg"
    touches = None if felt is None else felt.touches
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
    refused = [] if felt is None else felt.refused
    told = replace(
        answer,
        verdict=verdict,
        explanation=says,
        findings=(*lines, *answer.findings),
        details={**answer.details, "load": short, "touches": touches, "refused": refused},
        sections=(Touches(touches), *answer.sections) if touches else answer.sections,
        predicted_95=None if felt is None else felt.place_95,
    )
    return told if felt is None else told.believed(felt.trust)


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
        "beside": touch.beside,
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
