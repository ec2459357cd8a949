"""A robot without markers: its joint offsets from pictures, and where its hand was in each.

    places     of cameras that nobody has placed (`seeds.camera_places`)
    keys       postures far from each other are learned from (`learners.images.markerless`)
    moments    every picture is asked whether the hand shows where it should be
    held out   moments that were not learned from, or each as if it alone had not been
    elsewhere  cameras that are said to be known are freed, and doubted if that changes much
    trust      `answers.picture_trust`

Pictures that do not show the hand fade by their own weight; none is thrown away. The answer's
parameters are those that are written: what the pictures do not tell stays as modelled
(`learners.images.settled`).
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
from bodyschema.answers.picture_trust import counts, elsewhere_details, picture_trust
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.held_out import Errors
from bodyschema.estimation.prediction import length_quantile, predict_error
from bodyschema.judging.accuracy import Accuracy
from bodyschema.judging.calibration import Calibration
from bodyschema.learners.images.elsewhere import Elsewhere, elsewhere
from bodyschema.learners.images.hand_track import HandPose, HandTracker
from bodyschema.learners.images.markerless import Markerless
from bodyschema.learners.images.markerless_fit import MarkerlessFit
from bodyschema.learners.images.settled import PREFIX, settled
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.report.tracking.evidence import OverlayPicture, TrackEvidence
from bodyschema.report.tracking.moments import Moments
from bodyschema.report.tracking.next_posture import NextPosture, gains, posture_moves
from bodyschema.report.tracking.pictures import Pictures
from bodyschema.report.tracking.trust import Trust
from bodyschema.report.tracking.words import explanation, findings, warnings
from bodyschema.seeds.camera_places import camera_places
from bodyschema.seeds.image_seeds import spread_out
from bodyschema.senses.images import Images

Array = NDArray[np.float64]

TESTED, LEAST_HELD = 20, 5
"""Moments that the errors before and after are measured in, at the most; with fewer than the second
that were not learned from, the others serve as well, one by one left out."""


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

    body: Body
    """As believed, with unplaced cameras where the search has put them."""
    fit: MarkerlessFit
    poses: tuple[HandPose, ...]
    """Of the hand at every moment."""
    keys: tuple[int, ...]
    """Moments that were learned from."""
    before: Mapping[int, float]
    """px: median distance of the outline from the body as believed, at the moments held out."""
    after: Mapping[int, float]
    """px: the same from the body as found without them."""
    rate: float
    """Moments a second."""
    seconds: float
    elsewhere: Elsewhere | None = None
    """The fit with the cameras freed that are said to be known, if there are any."""


def track(
    learner: Markerless,
    body: Body,
    variables: Variables,
    pictures: PictureSource,
    hand: str,
    keys: int = 20,
    progress: Progress = lambda items, total: items,
    unplaced: Sequence[str] = (),
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
        unplaced: cameras that are looked for from nothing; they are free in `variables`.

    Raises:
        InputError: pictures cannot be read or do not fit the body, or cameras cannot be placed.
    """
    begin = time.perf_counter()
    chosen = sorted(spread_out(pictures.q, keys))
    frames, count = list(pictures.seen(chosen)), len(pictures.q)
    body, fit = _fitted(learner, body, variables, frames, unplaced)
    tracker = HandTracker.of(fit, frames, hand)
    held = _held_out(fit, pictures.q, chosen)
    freed = elsewhere(learner, fit, frames)
    start, poses = time.perf_counter(), list[HandPose]()
    before, after = dict[int, float](), dict[int, float]()
    for k, images in enumerate(progress(pictures.seen(range(count)), count)):
        poses.append(tracker.look(images))
        if k in held:
            before[k] = tracker.distance(images, np.zeros(len(fit.z)))
            after[k] = tracker.distance(images, held[k])
    now = time.perf_counter()
    rate = len(poses) / (now - start)
    return Tracked(body, fit, tuple(poses), tuple(chosen), before, after, rate, now - begin, freed)


def _fitted(
    learner: Markerless,
    body: Body,
    variables: Variables,
    frames: Sequence[Images],
    unplaced: Sequence[str],
) -> tuple[Body, MarkerlessFit]:
    """The body as it was before the fit, and the fit that most pictures bear out."""
    places = [camera_places(learner.surface, body, camera, frames) for camera in unplaced]
    bodies = [body] if not places else []
    for together in zip(*places, strict=False):
        placed = body
        for camera, T in zip(unplaced, together, strict=True):
            placed = placed.with_placement(camera, T)
        bodies.append(placed)
    found = [(one, learner.fit(one, variables, frames)) for one in bodies]
    return max(found, key=lambda pair: pair[1].weights.total)


def _held_out(fit: MarkerlessFit, q: Array, keys: Sequence[int]) -> dict[int, Array]:
    """Moments in which errors are measured, and what was found without them, (size,) each.

    Moments that were not learned from, or if they are few those and each key as if it had not been.
    """
    rest = np.setdiff1d(np.arange(len(q)), keys).tolist()
    if len(rest) >= LEAST_HELD:
        return {rest[i]: fit.z for i in spread_out(q[rest], TESTED)}
    alone = {k: fit.without(i) for i, k in enumerate(keys)} if len(keys) > 1 else {}
    return dict.fromkeys(rest, fit.z) | alone


def track_answer(
    found: Tracked,
    described: Body,
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
        hand: frame whose pose is told.
        q: (n_moments, n_joints) that were looked at.
        numbers: of the first camera's pictures at these moments.
        cameras: without distortion; the first one sees the hand.
        run: what was asked.
        overlays: pictures with the outline before and after, for the report.
    """
    fit, body = found.fit, found.body
    estimate, kept = settled(fit.estimate, fit.identifiability)
    names = tuple(camera.name for camera in cameras)
    evidence = TrackEvidence(fit, kept, body, names, hand, q, numbers, found.keys, found.poses)
    telling = None if fit.lost else telling_posture(fit, cameras, q)
    following = {} if telling is None else posture_moves(telling, body, q)
    answer = Calibration(
        verdict="not found" if fit.lost else "found",
        explanation=explanation(evidence),
        fit=estimate,
        nominal=outline_accuracy(found.before),
        held_out=outline_accuracy(found.after),
        identifiability=fit.identifiability,
        outliers=tuple(int(numbers[k]) for k in np.flatnonzero(evidence.lost).tolist()),
        n_rows=len(found.poses),
        groups=("offsets",),
        seconds=found.seconds,
        compared=("as believed", "as found"),
        findings=findings(evidence),
        notes=warnings(evidence),
        corrects=not fit.lost,
        details={
            "lost": bool(fit.lost),
            "matched": fit.matched,
            "residual_px": fit.residual if np.isfinite(fit.residual) else None,
            "iou": fit.iou if np.isfinite(fit.iou) else None,
            "bias_px": fit.bias.tolist(),
            "corrections": {} if fit.lost else corrections(estimate),
            "kept": list(kept),
            "pictures": counts(fit, names),
            "hand_in_camera_m_95": _in_camera_95(found),
            "cameras_elsewhere": elsewhere_details(found.elsewhere),
            "next_posture": following,
            "gains": [] if telling is None else gains(telling, estimate.variables),
        },
        predicted_95=_predicted_95(found, hand, q),
    )
    answer = answer.believed(picture_trust(fit, found.before, found.after, found.elsewhere))
    sections = (Pictures(overlays), Moments(evidence), NextPosture(answer.details), Trust(evidence))
    return Answer.of(answer, (), described, run, verb="track", sections=sections)


def outline_accuracy(distances: Mapping[int, float]) -> Accuracy:
    """Of the outline in the moments held out, px."""
    key = ("outline", "px")
    errors = Errors.of(np.array(list(distances.values())))
    return Accuracy({key: errors}, {key: len(distances)}) if distances else Accuracy({}, {})


def _predicted_95(found: Tracked, hand: str, q: Array) -> float | None:
    """m: that the corrected robot's hand is off in its base, over all moments; none without a body.

    Where a camera is doubted, that of the fit with the cameras freed, and by how much the hand of
    this one is elsewhere. Where the hand is before a camera is another question, with the lens in
    it: each moment's pose has a covariance of its own.
    """
    if found.fit.lost:
        return None
    estimate, freed = found.fit.estimate, found.elsewhere
    base = estimate.reference.frames[0]
    if freed is None or not freed.doubted:
        return predict_error(estimate, q, base, hand).position_overall
    there = [relative_pose(one.body, q, base, hand)[:, :3, 3] for one in (estimate, freed.estimate)]
    moved = float(np.quantile(np.linalg.norm(there[1] - there[0], axis=1), 0.95))
    return float(np.hypot(predict_error(freed.estimate, q, base, hand).position_overall, moved))


def _in_camera_95(found: Tracked) -> float | None:
    """m: that the hand is off before the first camera, over all moments."""
    if found.fit.lost:
        return None
    return length_quantile([pose.covariance[:3, :3] for pose in found.poses], np.inf, 0.95)


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
