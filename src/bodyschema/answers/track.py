"""A robot without markers: its joint offsets from pictures, and where its hand was in each.

    keys       postures far from each other are learned from (`learners.images.markerless`)
    moments    every picture is asked whether the hand shows where it should be
    again      if pictures that do not show the hand were learned from, once more without them

The answer's parameters are those that are written: what the pictures do not tell stays as modelled
(`learners.images.settled`). Held out are moments that were not learned from, if there are any.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from bodyschema.acting.telling_posture import telling_posture
from bodyschema.answers.answer import Answer
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.held_out import Errors
from bodyschema.judging.accuracy import Accuracy
from bodyschema.judging.calibration import Calibration
from bodyschema.learners.images.hand_track import HandPose, HandTracker
from bodyschema.learners.images.markerless import COARSE_REACH, Markerless
from bodyschema.learners.images.markerless_fit import MarkerlessFit
from bodyschema.learners.images.settled import PREFIX, settled
from bodyschema.learners.images.sight import Sight
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.report.tracking.evidence import OverlayPicture, TrackEvidence
from bodyschema.report.tracking.moments import Moments
from bodyschema.report.tracking.next_posture import NextPosture, gains, posture_moves
from bodyschema.report.tracking.pictures import Pictures
from bodyschema.report.tracking.trust import Trust
from bodyschema.report.tracking.words import explanation, findings, warnings
from bodyschema.seeds.image_seeds import spread_out
from bodyschema.senses.images import Images

Array = NDArray[np.float64]

TESTED = 20
"""Moments that the errors before and after are measured in."""


class PictureSource(Protocol):
    """Moments at which cameras saw and encoders were read."""

    @property
    def q(self) -> Array:
        """(n_moments, n_joints) rad and m."""
        ...

    def seen(self, moments: Sequence[int]) -> Iterator[Images]:
        """Pictures of some moments, in order."""
        ...


Progress = Callable[[Iterable[Images], int], Iterable[Images]]
"""Shows how far the work is: takes what is looked at, and how many there will be."""


@dataclass(frozen=True)
class Tracked:
    """What was learned, and what every moment showed."""

    fit: MarkerlessFit
    poses: tuple[HandPose, ...]
    """Of the hand at every moment."""
    keys: tuple[int, ...]
    """Moments that were learned from."""
    before: Mapping[int, float]
    """px: median distance of the outline from the body as believed, at the moments tested."""
    rate: float
    """Moments a second."""
    seconds: float


def track(
    learner: Markerless,
    body: Body,
    variables: Variables,
    pictures: PictureSource,
    hand: str,
    keys: int = 20,
    progress: Progress = lambda items, total: items,
) -> Tracked:
    """Learn from the postures that differ most, then look at every moment.

    Args:
        learner: with the surface, the guesses and the doubts.
        body: as modelled, with its cameras.
        variables: what may be wrong.
        pictures: what was seen.
        hand: frame whose pose is told.
        keys: postures that are learned from.
        progress: shows how far the work is.

    Raises:
        InputError: pictures cannot be read or do not fit the body.
    """
    begin = time.perf_counter()
    chosen = sorted(spread_out(pictures.q, keys))
    found = _once(learner, body, variables, pictures, hand, chosen, progress, begin)
    seen = np.flatnonzero([not pose.lost for pose in found.poses])
    if 0 < len(seen) < len(found.poses) and not np.isin(chosen, seen).all():
        # Pictures that do not show the hand have been learned from: once more without them.
        chosen = sorted(seen[spread_out(pictures.q[seen], keys)].tolist())
        found = _once(learner, body, variables, pictures, hand, chosen, progress, begin)
    return found


def _once(
    learner: Markerless,
    body: Body,
    variables: Variables,
    pictures: PictureSource,
    hand: str,
    keys: Sequence[int],
    progress: Progress,
    begin: float,
) -> Tracked:
    frames, count = list(pictures.seen(keys)), len(pictures.q)
    fit = learner.fit(body, variables, frames)
    tracker = HandTracker.of(fit, frames, hand)
    tested = _tested(pictures.q, keys)
    start, poses, before = time.perf_counter(), list[HandPose](), dict[int, float]()
    for k, images in enumerate(progress(pictures.seen(range(count)), count)):
        poses.append(tracker.look(images))
        if k in tested:
            before[k] = _distance(tracker, images)
    now = time.perf_counter()
    rate = len(poses) / (now - start)
    return Tracked(fit, tuple(poses), tuple(keys), before, rate, now - begin)


def _tested(q: Array, keys: Sequence[int]) -> frozenset[int]:
    """Moments in which errors are measured: not learned from, or all if there are no others."""
    rest = np.setdiff1d(np.arange(len(q)), keys)
    rest = rest if len(rest) else np.arange(len(q))
    return frozenset(int(rest[i]) for i in spread_out(q[rest], TESTED))


def _distance(tracker: HandTracker, images: Images) -> float:
    """px: median distance of what is found from the outline of the body as believed."""
    model, reach = tracker.fit.model, COARSE_REACH[0]
    rows = model.rows(Sight.of(images, tracker.colours), np.zeros(len(model.scale)), reach)
    return float(np.median(np.abs(rows.left))) if len(rows.left) else reach


def track_answer(
    found: Tracked,
    described: Body,
    body: Body,
    hand: str,
    q: Array,
    numbers: Sequence[int],
    cameras: Sequence[Any],
    run: Mapping[str, Any] | None = None,
    overlays: Sequence[OverlayPicture] = (),
) -> Answer:
    """The answer of what was tracked.

    Args:
        found: by `track`.
        described: the robot as described.
        body: the same with its cameras, as believed.
        hand: frame whose pose is told.
        q: (n_moments, n_joints) that were looked at.
        numbers: of the first camera's pictures at these moments.
        cameras: without distortion; the first one sees the hand.
        run: what was asked.
        overlays: pictures with the outline before and after, for the report.
    """
    fit = found.fit
    estimate, kept = settled(fit.estimate, fit.identifiability)
    names = tuple(camera.name for camera in cameras)
    evidence = TrackEvidence(
        fit, kept, body, names, hand, q, numbers, found.keys, found.poses, overlays
    )
    telling = None if fit.lost else telling_posture(fit, cameras, q)
    following = {} if telling is None else posture_moves(telling, body, q)
    nominal, held_out = _accuracy(found)
    answer = Calibration(
        verdict="not found" if fit.lost else "found",
        explanation=explanation(evidence),
        fit=estimate,
        nominal=nominal,
        held_out=held_out,
        identifiability=fit.identifiability,
        outliers=tuple(int(numbers[k]) for k in np.flatnonzero(evidence.lost).tolist()),
        n_rows=len(found.poses),
        groups=("offsets",),
        seconds=found.seconds,
        compared=("as believed", "as found"),
        findings=findings(evidence),
        notes=(*warnings(evidence), *_not_held_out(found)),
        corrects=not fit.lost,
        details={
            "lost": bool(fit.lost),
            "matched": fit.matched,
            "residual_px": fit.residual if np.isfinite(fit.residual) else None,
            "iou": fit.iou if np.isfinite(fit.iou) else None,
            "bias_px": fit.bias.tolist(),
            "corrections": {} if fit.lost else corrections(estimate),
            "kept": list(kept),
            "next_posture": following,
            "gains": [] if telling is None else gains(telling, estimate.variables),
        },
    )
    sections = (Pictures(evidence), Moments(evidence), NextPosture(answer.details), Trust(evidence))
    return Answer.of(answer, (), described, run, verb="track", sections=sections)


def _accuracy(found: Tracked) -> tuple[Accuracy, Accuracy]:
    """Distances of the outline before and after, px, in the moments that were tested."""
    moments = [k for k in found.before if not found.poses[k].lost] or list(found.before)
    after = [found.poses[k].residual for k in moments]
    told = [r if np.isfinite(r) else COARSE_REACH[0] for r in after]
    key, count = ("outline", "px"), {("outline", "px"): len(moments)}
    before = Errors.of(np.array([found.before[k] for k in moments]))
    return Accuracy({key: before}, count), Accuracy({key: Errors.of(np.array(told))}, count)


def _not_held_out(found: Tracked) -> tuple[str, ...]:
    if len(found.keys) < len(found.poses):
        return ()
    return ("All moments were learned from, so the errors are not held out.",)


def corrections(estimate: Estimate) -> dict[str, float]:
    """Offsets that are written, by parameter, rad or m; cameras are left out."""
    variables = estimate.variables
    return {
        name: float(value)
        for name, group, value in zip(variables.names, variables.groups, estimate.x, strict=True)
        if not group.startswith(PREFIX)
    }


def frame_entries(found: Tracked, numbers: Sequence[int]) -> list[dict[str, Any]]:
    """The hand at every moment, in plain types, SI.

    Args:
        found: by `track`.
        numbers: of the first camera's pictures at these moments.
    """
    return [
        {
            "frame": int(number),
            "time": pose.time,
            "T_camera_hand": pose.pose.tolist(),
            "covariance": pose.covariance.tolist(),
            "matched": pose.matched,
            "lost": bool(pose.lost),
        }
        for number, pose in zip(numbers, found.poses, strict=True)
    ]
