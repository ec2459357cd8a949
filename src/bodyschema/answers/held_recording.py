"""A recording of a wrist, cut where the load changes, and the fit of all its loads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.judging.mended_wrist import mended_fit, mended_samples, world_rotation
from bodyschema.judging.wrist_declarations import (
    better_declaration,
    is_moving,
    load_learner,
    load_means,
)
from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.payload.recorded import Part, PayloadFit, fit_payload
from bodyschema.monitoring.load_segments import (
    Happening,
    declared_segments,
    found_segments,
    on_one_clock,
)
from bodyschema.senses.wrench_means import Averaging, WrenchMeans
from bodyschema.senses.wrist_columns import WristRecording, WristTable
from bodyschema.senses.wrist_declaration import (
    LoadSegments,
    MotionReading,
    WristDeclaration,
)
from bodyschema.senses.wrist_poses import check_speed
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.trust.wrench_doubt import WrenchDoubt, doubt
from bodyschema.trust.wrench_rivals import WeighedRival

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

FOLDS = 5
"""Of the held-out test: stretches of time, as neighbouring windows share samples."""


@dataclass(frozen=True)
class HeldRecording:
    """What came out of a recording."""

    declared: WristDeclaration
    fit: PayloadFit
    read: WristRecording
    """As it was recorded."""
    events: tuple[Happening, ...]
    notes: tuple[str, ...]
    """What was assumed, and what was done."""
    samples: WristSamples
    """As they were used: gravity and clock put right where they had to be."""
    doubt: WrenchDoubt
    """What is not known of the fit, and why."""
    mended: tuple[WeighedRival, ...] = ()
    """Causes that were put right, of tilt, lag, drift and jump."""
    hint: str = ""
    """An entry of the declaration that would explain the wrench, where the given one does not."""

    @property
    def learner(self) -> LoadLearner:
        """That believes what is declared."""
        return load_learner(self.declared)

    @property
    def T_link_mount(self) -> Array:
        """(4, 4) from the sensor's axes as declared to the link or flange that carries it."""
        place = self.declared.sensor
        return lie.transform(lie.rotation_from_rpy(place.rpy), place.xyz)

    @property
    def read_wrenches(self) -> Array:
        """(n, 6) of all parts: as read, the sensor's offset removed, along the mount's axes."""
        R = self.fit.R
        y = np.concatenate([part.means.y for part in self.fit.parts])
        turned = np.hstack([y[:, :3] @ R.T, y[:, 3:] @ R.T])
        return np.asarray(turned - self.fit.solution.guess.bias)

    @property
    def kept(self) -> Flags:
        """(n,) of all parts: samples that were not left out as wild."""
        return np.concatenate(self.fit.kept)

    @property
    def times(self) -> Array:
        """(n,) s of all parts."""
        return np.concatenate([part.means.time for part in self.fit.parts])

    def held_out(self, folds: int = FOLDS) -> Array:
        """(n, 6) N and Nm that loads fitted to other stretches of time leave unexplained.

        A fold whose rest cannot be fitted explains nothing.
        """
        left = self.read_wrenches
        ends = np.cumsum([0, *(len(part.means) for part in self.fit.parts)])
        cuts = np.array_split(np.arange(ends[-1]), min(folds, ends[-1]))
        for cut in cuts:
            out = np.isin(np.arange(ends[-1]), cut)
            inside = [out[a:b] for a, b in pairwise(ends)]
            try:
                left[out] = _predicted(self.fit.parts, inside, self.learner)
            except InputError:
                continue
        return left


def hold(
    table: WristTable,
    declared: WristDeclaration,
    motion: MotionReading | None = None,
    segments: LoadSegments | None = None,
    empty: WristTable | None = None,
) -> HeldRecording:
    """Read a recording of a wrist and fit its loads.

    Args:
        table: the recording.
        declared: what its columns hold.
        motion: how it is read.
        segments: which times carry the gripper alone, and which an object too.
        empty: another recording with the same columns, of the gripper alone.

    Raises:
        InputError: anything that cannot be used, in one sentence.
    """
    how, cut = motion or MotionReading(), segments or LoadSegments()
    read, learner = table.read(declared), load_learner(declared)
    samples, moving = read.samples, is_moving(how, read)
    if moving and samples.position is not None:
        check_speed(samples.time, samples.position)
    notes = [*read.notes, *_assumed(how, read, declared, moving)]

    def means(part: WristSamples) -> WrenchMeans:
        return load_means(how, part, moving, declared.sensor)

    other = None if empty is None else empty.read(declared).samples
    split = bool(cut.empty or cut.loaded or empty is not None)

    def parts_of(some: WristSamples) -> list[Part]:
        if split:
            # One base carries both recordings.
            alone = None if other is None else replace(other, down=some.down)
            return declared_segments(some, cut, means, alone)
        return [Part(means(some), ("load",))]

    # A tilt looks like a small lag, or like another declaration; by itself it explains more.
    samples, leant = mended_samples(samples, parts_of, learner, ("tilt",), other)
    lag = 0.0
    if moving and not split:
        samples, lag = on_one_clock(samples, learner, Averaging(how.window))

    def fitted(some: WristSamples) -> tuple[tuple[Happening, ...], PayloadFit]:
        parts, happened = parts_of(some), tuple[Happening, ...]()
        if moving and not split:
            happened, parts = found_segments(parts[0].means, learner)
        return happened, fit_payload(parts, learner)

    notes += [_late(lag)] if lag else []
    events, fit = fitted(samples)
    share = float(fit.unexplained.max())
    lever = max(float(np.linalg.norm(load.com)) for load in fit.loads.values())
    hint = better_declaration(table, declared, how, moving, share, lever)
    mended = tuple[WeighedRival, ...]()
    if not hint:
        wanted = ("tilt", "lag") if moving else ("tilt",)
        samples, mended = mended_samples(samples, parts_of, learner, wanted, other)
        events, fit = fitted(samples) if mended else (events, fit)
        mended = leant + mended
        fit, then = mended_fit(fit, samples, learner, other)
        mended += then
    R_world = world_rotation(samples, fit.parts, other)
    left = doubt(fit, learner, R_world, mended)
    fit = replace(fit, whole=left.whole)
    return HeldRecording(declared, fit, read, events, tuple(notes), samples, left, mended, hint)


def _assumed(
    how: MotionReading, read: WristRecording, declared: WristDeclaration, moving: bool
) -> list[str]:
    """Sentences on what the clock was taken for."""
    if how.kind != "auto":
        return []
    if read.moving and not moving:
        step = float(np.median(np.diff(read.samples.time)))
        return [
            f"samples are {step:.3g} s apart, too far to follow a motion: every row counts as a "
            "posture at rest; check time_unit if that is wrong."
        ]
    if declared.time is None and not read.moving:
        return [
            "no column is called time, t or timestamp: every row counts as a posture at rest; if "
            'there is a clock, name its column with time = "...".'
        ]
    return []


def _late(lag: float) -> str:
    word = "late" if lag > 0 else "early"
    return f"the wrench is {1e3 * abs(lag):.0f} ms {word} against the motion; corrected."


def _predicted(parts: Sequence[Part], out: Sequence[Flags], learner: LoadLearner) -> Array:
    """(m, 6) what is left of the samples of a fold, by the loads of all others."""
    rest = [
        replace(part, means=part.means.take(~mask))
        for part, mask in zip(parts, out, strict=True)
        if not mask.all()
    ]
    fit = fit_payload(rest, learner)
    tests = tuple(
        replace(part, means=part.means.take(mask)) for part, mask in zip(parts, out, strict=True)
    )
    known = set(fit.names)
    if any(not known.issuperset(part.loads) for part in tests if len(part.means)):
        raise InputError("a load is seen in one fold alone.")
    tested = replace(fit, parts=tests)
    return np.concatenate([tested.residuals(k) for k, p in enumerate(tests) if len(p.means)])
