"""A recording of a wrist, cut where the load changes, and the fit of all its loads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.cli.wrist.other_entries import other_entries
from bodyschema.cli.wrist.payload_file import PayloadFile
from bodyschema.cli.wrist.pose_columns import check_speed
from bodyschema.cli.wrist.wrist_columns import WristRecording, read_wrist
from bodyschema.errors import InputError
from bodyschema.learners.payload.clock_lag import clock_lag, shifted
from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.payload.recorded import Part, PayloadFit, fit_payload
from bodyschema.monitoring.held_load import LoadWatch
from bodyschema.senses.wrench_means import Averaging, WrenchMeans, postures
from bodyschema.senses.wrist_samples import WristSamples

Array = NDArray[np.float64]

TURN_STD = {"exactly": 1e-6, "roughly": float(np.radians(5)), "no": float(np.inf)}
"""rad, by what is known of the sensor's mounting."""

TARED = (0.05, 0.002)
"""N and Nm, what the offset of a tared sensor may still be."""

CHANGES = ("grasp", "release", "swap", "shift")

SLOWEST = 0.08
"""s between samples, beyond which a motion cannot be followed."""

POOR = 0.1
"""Share of the wrench that may be left over before the answer says that something is wrong."""

DOUBTFUL, MUCH = 0.03, 0.3
"""Share from which other entries are tried, and what one must bring it down to, to be named."""

FEWEST_ALONE = 200
"""Samples from which a lag is told."""

MARGIN = 0.6
"""s round a change that belong to neither load."""


@dataclass(frozen=True)
class Happening:
    """Something that happened to the load."""

    time: float
    """s, when it was noticed."""
    event: str
    mass: float | None
    """kg, as soon as it was known again."""


@dataclass(frozen=True)
class HeldRecording:
    """What came out of a recording."""

    run: PayloadFile
    fit: PayloadFit
    events: tuple[Happening, ...]
    notes: tuple[str, ...]
    T_flange_mount: Array
    """(4, 4) from the sensor's axes as declared to the flange."""
    hint: str = ""
    """An entry of the file that would explain the wrench, where the given one does not."""


def identify(run: PayloadFile) -> HeldRecording:
    """Read a run's recording and fit its loads.

    Raises:
        InputError: anything that cannot be used, in one sentence.
    """
    read = read_wrist(run, run.recording)
    learner, moving = _learner(run), _moving(run, read)
    if moving and read.samples.position is not None:
        check_speed(read.samples.time, read.samples.position)
    notes, events = list(read.notes), tuple[Happening, ...]()
    if run.motion.kind == "auto" and read.moving and not moving:
        step = float(np.median(np.diff(read.samples.time)))
        notes.append(
            f"samples are {step:.3g} s apart, too far to follow a motion: every row counts as a "
            "posture at rest; check time_unit if that is wrong."
        )
    elif run.motion.kind == "auto" and run.time is None and not read.moving:
        notes.append(
            "no column is called time, t or timestamp: every row counts as a posture at rest; if "
            'there is a clock, name its column with time = "...".'
        )
    if run.segments.empty or run.segments.loaded or run.empty_recording:
        parts = _declared_parts(run, read, moving)
    else:
        samples = read.samples
        if moving:
            samples, said = _on_one_clock(run, samples, learner)
            notes += said
        means = _means(run, samples, moving)
        events, parts = _found_parts(means, learner, moving)
    fit = fit_payload(parts, learner)
    T = lie.transform(lie.rotation_from_rpy(run.sensor.rpy), run.sensor.xyz)
    share = float(fit.unexplained.max())
    hint = better_entry(run, moving, share) if share > DOUBTFUL else ""
    return HeldRecording(run, fit, events, tuple(notes), T, hint)


def better_entry(run: PayloadFile, moving: bool, share: float) -> str:
    """The entry that, written otherwise, would explain the wrench; "" if there is none.

    Args:
        run: as it is.
        moving: whether its rows are moments of a motion.
        share: of the wrench that it leaves unexplained.
    """
    for words, trial in other_entries(run).items():
        try:
            means = _means(trial, read_wrist(trial, trial.recording).samples, moving)
            fit = fit_payload([Part(means, ("load",))], _learner(trial))
        except InputError:
            continue
        if fit.unexplained.max() < min(0.5 * POOR, MUCH * share):
            return words
    return ""


def _on_one_clock(
    run: PayloadFile, samples: WristSamples, learner: LoadLearner
) -> tuple[WristSamples, list[str]]:
    """The samples with the wrench on the clock of the motion, and what was done."""
    # A lag is told from one load alone: up to the first change.
    events = watch_events(_means(run, samples, True), learner)
    first = next((event.time for event in events if event.event in CHANGES), np.inf)
    rows = np.flatnonzero(samples.time < first - MARGIN)
    if len(rows) < FEWEST_ALONE:
        return samples, []
    alone = samples.take(rows)
    found = clock_lag(alone, learner, Averaging(run.motion.window))
    if not found.lag:
        return samples, []
    word = "late" if found.lag > 0 else "early"
    said = f"the wrench is {1e3 * abs(found.lag):.0f} ms {word} against the motion; corrected."
    return shifted(samples, found.lag), [said]


def _learner(run: PayloadFile) -> LoadLearner:
    learner = LoadLearner(turn_std=TURN_STD[run.sensor.known])
    if run.wrench.bias == "none":
        learner = replace(learner, force_bias_std=TARED[0], torque_bias_std=TARED[1])
    return learner


def _moving(run: PayloadFile, read: WristRecording) -> bool:
    if run.motion.kind != "auto":
        return run.motion.kind == "moving"
    step = float(np.median(np.diff(read.samples.time)))
    return read.moving and step <= SLOWEST


def _means(run: PayloadFile, samples: WristSamples, moving: bool) -> WrenchMeans:
    made = Averaging(run.motion.window).means(samples) if moving else postures(samples)
    noise = made.std.copy()
    if run.sensor.noise_N is not None and not moving:
        noise[:3] = run.sensor.noise_N
    if run.sensor.noise_Nm is not None and not moving:
        noise[3:] = run.sensor.noise_Nm
    return replace(made, std=noise)


def _declared_parts(run: PayloadFile, read: WristRecording, moving: bool) -> list[Part]:
    """The gripper alone, and the gripper with its object."""
    parts = []
    if run.empty_recording:
        other = read_wrist(run, [run.empty_recording])
        parts.append(Part(_means(run, other.samples, moving), ("gripper",)))
    for name, spans in (("empty", run.segments.empty), ("loaded", run.segments.loaded)):
        loads = ("gripper",) if name == "empty" else ("gripper", "object")
        for low, high in _pairs(spans, name):
            t = read.samples.time
            rows = np.flatnonzero((t >= low) & (t <= high))
            if len(rows) < 2:
                raise InputError(
                    f"segment {name} = [{low:g}, {high:g}] holds {len(rows)} rows; the recording "
                    f"runs from {t[0]:.13g} to {t[-1]:.13g} s."
                )
            parts.append(Part(_means(run, read.samples.take(rows), moving), loads))
    if run.empty_recording and not run.segments.loaded:
        parts.append(Part(_means(run, read.samples, moving), ("gripper", "object")))
    if not any("object" in part.loads for part in parts):
        return [replace(part, loads=("load",)) for part in parts]
    if not any(part.loads == ("gripper",) for part in parts):
        return [replace(part, loads=("load",)) for part in parts]
    return parts


def _pairs(spans: Sequence[Any], name: str) -> list[tuple[float, float]]:
    """[(low, high), ...] of one pair or a list of pairs."""
    listed = [spans] if spans and not isinstance(spans[0], list | tuple) else list(spans)
    for pair in listed:
        if len(pair) != 2 or not pair[0] < pair[1]:
            raise InputError(f"segment {name} must be [from, to] in s, or a list of such pairs.")
    return [(float(low), float(high)) for low, high in listed]


def _found_parts(
    means: WrenchMeans, learner: LoadLearner, moving: bool
) -> tuple[tuple[Happening, ...], list[Part]]:
    """Cut where the watch noticed that the load changed."""
    if not moving or not np.isfinite(learner.turn_std):
        return (), [Part(means, ("load",))]
    events = watch_events(means, learner)
    cuts = [event.time for event in events if event.event in CHANGES]
    if not cuts:
        return events, [Part(means, ("load",))]
    edges, parts = [-np.inf, *cuts, np.inf], []
    for k, (low, high) in enumerate(pairwise(edges)):
        rows = np.flatnonzero((means.time > low + MARGIN) & (means.time < high - MARGIN))
        if len(rows) > 2:
            parts.append(Part(means.take(rows), (f"load {k + 1}",)))
    return events, parts


def watch_events(means: WrenchMeans, learner: LoadLearner) -> tuple[Happening, ...]:
    """What the watch noticed: the first identification, and each change at its alarm."""
    watch = LoadWatch(learner)
    state, events, alarm = watch.start(), list[Happening](), None
    for k in range(len(means)):
        state, report = watch.step(state, means.take(slice(k, k + 1)))
        now = float(means.time[k])
        if report.event == "alarm":
            alarm = now if alarm is None else alarm
        elif report.event:
            mass = None if report.load is None else report.load.mass
            events.append(Happening(now if alarm is None else alarm, report.event, mass))
            alarm = None
    return tuple(events)
