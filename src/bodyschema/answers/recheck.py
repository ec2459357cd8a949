"""Is what a verb found still true? New data of the same kind against the stored answer.

New samples of senses are tested against the calibration (`monitoring.change`), and watched where
they are a stream. A wrist's load is learned anew from the new recording, and a tracked robot's
offsets from the new pictures, starting from the stored robot; then the two beliefs are compared
(`two_beliefs`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.answers.answer import Answer
from bodyschema.answers.held_recording import HeldRecording
from bodyschema.errors import InputError
from bodyschema.estimation.loads import SIX, com_covariance, moments_covariance
from bodyschema.learners.images.markerless import Markerless
from bodyschema.learners.images.settled import PREFIX
from bodyschema.model.inertia import Inertia
from bodyschema.model.variables import Variables
from bodyschema.monitoring.change import ChangeTest
from bodyschema.monitoring.moved_part import Suspect
from bodyschema.monitoring.stream_check import (
    Change,
    StreamCheck,
    check_stream,
    in_motion,
    is_stream,
)
from bodyschema.monitoring.two_beliefs import two_beliefs
from bodyschema.senses.images import Images
from bodyschema.senses.sense import Sense
from bodyschema.units import millimetres, shown

Array = NDArray[np.float64]

FEWEST, POSTURES = 3, 100
"""Postures that a check needs, and those of a stream that are tested as a whole."""

LOAD_NAMES = (
    "load.mass",
    *(f"load.com_{axis}" for axis in "xyz"),
    *(f"load.moment_{'xyz'[i]}{'xyz'[j]}" for i, j in SIX),
)
LOAD_PARTS = {"mass": (0,), "centre of mass": (1, 2, 3), "moments": tuple(range(4, 10))}


@dataclass(frozen=True)
class Recheck:
    """A test, and how well the new data agree with what is believed of them."""

    test: ChangeTest
    rows: int
    """Samples or pictures that were looked at."""
    size: str
    """How large what is left over typically is, in words."""
    then: str
    """What to do next, if something has changed."""


def recheck_load(stored: Answer, held: HeldRecording, false_alarm: float) -> Recheck:
    """Whether a wrist still carries what it carried at the end of the stored recording.

    Offset and turn of the sensor are found anew, so a sensor that was tared since is no change. A
    recording in which the load changes is judged by the stretch that differs most.

    Args:
        stored: answer of `learn_payload` or `find_touches`.
        held: the new recording, read and fitted.
        false_alarm: chance of calling an unchanged load changed.
    """
    old = [one for one in stored.details["loads"] if one["name"] in stored.details["last"]]
    before = load_numbers(
        Inertia.from_phi(np.sum([list(one["phi"].values()) for one in old], axis=0)),
        np.sum([one["phi_covariance"] for one in old], axis=0),
    )
    tests = []
    for name in held.fit.names:
        now = load_numbers(held.fit.loads[name], held.fit.covariance(name))
        change, C = now[0] - before[0], now[1] + before[1]
        rate = false_alarm / len(held.fit.names)
        tests.append(two_beliefs(change, C, LOAD_PARTS, LOAD_NAMES, rate))
    worst = min(tests, key=lambda test: test.p_value)
    p_value = min(1.0, len(tests) * worst.p_value)
    share = 100 * float(held.fit.unexplained.max())
    size = f"{share:.2g} % of the wrench unexplained in {len(held.kept)} samples"
    then = "look at what the wrist holds, then learn the payload anew."
    return Recheck(replace(worst, p_value=p_value), len(held.kept), size, then)


def load_numbers(load: Inertia, P: Array) -> tuple[Array, Array]:
    """Mass, centre and moments about it (10,), and their covariance, part by part (10, 10)."""
    C = np.zeros((10, 10))
    C[0, 0] = P[0, 0]
    C[1:4, 1:4], C[4:, 4:] = com_covariance(load, P), moments_covariance(load, P)
    moments = [load.moments[i, j] for i, j in SIX]
    return np.array([load.mass, *load.com, *moments]), C


def recheck_pictures(
    stored: Answer,
    learner: Markerless,
    variables: Variables,
    frames: Sequence[Images],
    false_alarm: float,
) -> Recheck:
    """Whether new pictures show the robot where the stored answer says.

    Args:
        stored: answer of `track`.
        learner: with the surface and the doubts; its guesses are used if the stored robot does not
            fit at all.
        variables: what may have changed, round the stored robot.
        frames: new pictures from the same cameras.
        false_alarm: chance of calling an unchanged robot changed.
    """
    fit = replace(learner, seeds=0).fit(stored.body, variables, frames)
    if fit.lost and learner.seeds:
        fit = learner.fit(stored.body, variables, frames)
    then = "look at the robot and at the cameras, then track anew."
    size = f"{fit.residual:.2f} px median distance of the outline in {len(frames)} postures"
    if fit.lost:
        lost = ChangeTest(True, 0.0, (), float("nan"))
        size = f"only {100 * fit.matched:.0f} % of the outline found in {len(frames)} postures"
        return Recheck(lost, len(frames), size, then)
    new, old = fit.estimate, stored.estimate
    rows = [old.variables.names.index(name) for name in new.variables.names]
    C = new.covariance + old.covariance[np.ix_(rows, rows)]
    parts = _parts(new.variables)
    test = two_beliefs(new.x, C, parts, new.variables.names, false_alarm)
    return Recheck(test, len(frames), size, then)


def _parts(variables: Variables) -> Mapping[str, list[int]]:
    """Joints by their offsets, cameras by their places."""
    parts: dict[str, list[int]] = {}
    for i, (name, group) in enumerate(zip(variables.names, variables.groups, strict=True)):
        part = group.removeprefix(PREFIX) if group.startswith(PREFIX) else name.split(".")[0]
        parts.setdefault(part, []).append(i)
    return parts


def recheck_senses(
    stored: Answer, senses: Sequence[Sense], false_alarm: float, least: float | None = None
) -> tuple[Recheck, StreamCheck | None]:
    """Whether a calibrated robot is still the one that was calibrated.

    Args:
        stored: answer of `calibrate` or `learn_skeleton`.
        senses: what is seen of it now.
        false_alarm: chance of calling an unchanged robot changed.
        least: m; see `Answer.check`.

    Returns:
        The test, and what a stream showed over time; None if the samples are no stream.

    Raises:
        InputError: there are too few postures.
    """
    rows = len({int(row) for sense in senses for row in sense.rows})
    if rows < FEWEST:
        raise InputError(
            f"the recording shows {rows} postures; at least {FEWEST} are needed to check."
        )
    stream = None
    if is_stream(senses):
        _refuse_back(senses)
        # Two tests share the allowed rate; the first takes the recording as one moment.
        moved = in_motion(senses)
        if max(len(sense) for sense in moved) < FEWEST:
            raise InputError(
                "the robot rests all through the recording: that cannot tell a change from a slow "
                f"error of the sensor; move it through at least {FEWEST} postures."
            )
        half = false_alarm / 2
        test = stored.check(thinned(moved), half, least)
        stream = check_stream(stored.widened, senses, half)
    else:
        test = stored.check(senses, false_alarm, least)
    sizes = " and ".join(_size(rms, unit) for unit, rms in test.typical.items())
    size = f"{sizes} typical error over {rows} postures"
    then = "look at it, then calibrate anew from a fresh recording."
    return Recheck(test, rows, size, then), stream


def _size(rms: float, unit: str) -> str:
    """In the unit that people read; mm to two decimals."""
    return f"{millimetres(rms)} mm" if unit == "m" else shown(rms, unit)


def _refuse_back(senses: Sequence[Sense]) -> None:
    """A stream is watched in the order of its times, which sorting would make up."""
    for sense in senses:
        steps = np.diff(sense.time)
        if len(steps) and steps.min() < 0:
            at = int(steps.argmin())
            raise InputError(
                f"time goes back by {-steps[at]:.3g} s after row {int(sense.rows[at])} of "
                f"{sense.label}; sort the rows, or check the recordings one by one."
            )


def thinned(senses: Sequence[Sense]) -> list[Sense]:
    """At most POSTURES samples of each sense, evenly spread over the recording."""
    return [
        sense.take(np.unique(np.linspace(0, len(sense) - 1, POSTURES).astype(int)))
        for sense in senses
    ]


def _millimetres(suspect: Suspect | Change) -> float | None:
    """How far a change moves what was seen; None where nobody asked."""
    effect = suspect.effect if isinstance(suspect, Suspect) else float("nan")
    return 1e3 * effect if np.isfinite(effect) else None


def _share(suspect: Suspect | Change) -> float | None:
    """Of what all parts together explain; None where they were not tried."""
    share = suspect.share if isinstance(suspect, Suspect) else float("nan")
    return share if np.isfinite(share) else None


def check_json(found: Recheck, stream: StreamCheck | None = None) -> dict[str, Any]:
    """The answer in plain types; changes in SI, "watched_s" null where there was no stream."""
    test = found.test
    changes = stream.changes if stream is not None else ()
    changed = test.changed or bool(changes)
    suspects: Sequence[Suspect | Change] = changes or test.suspects
    return {
        "verdict": "changed" if changed else "still true",
        "changed": changed,
        "p_value": min([test.p_value, *(change.p_value for change in changes)]),
        "suspects": [
            {
                "part": suspect.part,
                "p_value": suspect.p_value,
                "change": dict(zip(suspect.names, map(float, suspect.change), strict=True)),
                "effect_mm": _millimetres(suspect),
                "share": _share(suspect),
            }
            for suspect in suspects
        ],
        "one_part_explains_it": test.alone,
        "position_rms_mm": 1e3 * rms if np.isfinite(rms := test.position_rms) else None,
        "rows": found.rows,
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
