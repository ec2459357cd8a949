"""The answer of the published filter of Vicente, Jamone, Bernardino 2016 on a recording.

The paper has no error bar: what is stated is the spread of the last particles, widened by what was
measured on the paper's own movements, and the answer is never better than "limited". What the
filter presumes is said with it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.answers.answer import Answer
from bodyschema.answers.picture_trust import held_out_against
from bodyschema.answers.track import corrections, outline_accuracy
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import SAYS_LITTLE, Identifiability
from bodyschema.estimation.prediction import predict_error
from bodyschema.judging.calibration import Calibration
from bodyschema.learners.images.hand_track import hand_pose
from bodyschema.learners.images.recorded_filter import NARROW, Filtered
from bodyschema.learners.published.image_likelihood import EDGES, EdgeLikelihood
from bodyschema.model.tree import Body
from bodyschema.report.tracking.evidence import OverlayPicture
from bodyschema.report.tracking.filter_course import Course, FilterCourse
from bodyschema.report.tracking.pictures import Pictures
from bodyschema.trust.trust import Trust
from bodyschema.units import listed

Array = NDArray[np.float64]

METHOD = "particle-filter"
"""In the answer's details, and as `track --method` has it."""

LAST = 10
"""Moments over which the effective size at the end is told."""


def premises(found: Filtered) -> tuple[str, ...]:
    """What the filter takes for granted here, a sentence each."""
    likelihood = found.learner.likelihood
    compared = "masks are compared by their overlap (Eq. 20 of the paper)"
    if isinstance(likelihood, EdgeLikelihood):
        compared = (
            f"edges are compared, {EDGES[likelihood.edges]}, with lambda {likelihood.rate:g} "
            "(Eq. 21); the paper shows that on its robot without an error of the hand, and where "
            "the background has edges of its own it failed in our scenes"
        )
    return (
        "Joint offsets are all that is wrong: places of cameras, lenses and meshes are known.",
        f"What was said to be doubted of them is not used; {compared}.",
        f"The offsets are drawn from ± {np.rad2deg(found.learner.prior):g} degrees and wander: "
        f"their noise falls to {np.rad2deg(found.learner.floor):g} degrees a picture and stays.",
    )


def filtered_answer(
    found: Filtered,
    described: Body,
    hand: str,
    q: Array,
    numbers: Sequence[int],
    run: Mapping[str, Any] | None = None,
    overlays: Sequence[OverlayPicture] = (),
) -> Answer:
    """The answer of the published filter.

    Args:
        found: by `recorded_filter.filtered`.
        described: the robot as described.
        hand: frame whose pose is told.
        q: (n_moments, n_joints) that were looked at.
        numbers: of the first camera's pictures at these moments.
        run: what was asked.
        overlays: pictures with the outline before and after, for the report.
    """
    estimate = found.estimate(-1)
    base = estimate.reference.frames[0]
    said, first, last = premises(found), found.sizes[:LAST], found.sizes[-LAST:]
    answer = Calibration(
        verdict="found" if found.found else "not found",
        explanation=_explanation(found),
        fit=estimate,
        nominal=outline_accuracy(found.before),
        held_out=outline_accuracy(found.after),
        identifiability=_told(estimate),
        outliers=(),
        n_rows=len(found.held),
        groups=("offsets",),
        seconds=found.seconds,
        learner=METHOD,
        compared=("as believed", "as found"),
        findings=said,
        notes=_notes(found, estimate),
        corrects=found.found,
        details={
            "method": METHOD,
            "premises": list(said),
            "particles": found.learner.particles,
            "effective_size": {"first": float(first.mean()), "last": float(last.mean())},
            "lost": not found.found,
            "corrections": corrections(estimate) if found.found else {},
            "moments": {"learned": len(found.infos), "held_out": len(found.held)},
            "held_out_pictures": [int(numbers[k]) for k in found.held],
            "next_posture": {},
            "gains": [],
        },
        predicted_95=predict_error(estimate, q, base, hand).position_overall
        if found.found
        else None,
    )
    answer = answer.believed(_trust(found))
    course = Course(
        tuple(name.removesuffix(".offset") for name in found.variables.names),
        np.array([info.offsets for info in found.infos]),
        np.array([np.sqrt(np.diag(info.covariance)) for info in found.infos]),
        found.sizes,
        [int(numbers[k]) for k in range(len(q)) if k not in found.held],
    )
    sections = (Pictures(overlays), FilterCourse(course))
    return Answer.of(answer, (), described, run, verb="track", sections=sections)


def _explanation(found: Filtered) -> str:
    n, m = len(found.variables), len(found.infos)
    what = f"{n} joint offset{'s' * (n != 1)} by the filter of Vicente et al. (2016)"
    now = float(np.median(list(found.after.values())))
    if not found.found:
        return (
            f"The body was not found: after {m} pictures of {what}, half of the outline lies "
            "nowhere within 40 pixels in those held out. Nothing was corrected."
        )
    was = float(np.median(list(found.before.values())))
    return (
        f"{what}, {found.learner.particles} particles, {m} moments in their order: in "
        f"{len(found.held)} others half of the outline lies within {now:.1f} pixels, "
        f"{was:.1f} before."
    )


def _trust(found: Filtered) -> Trust:
    """Contradicted as other answers from pictures; never good, see the module."""
    if not found.found:
        return Trust("contradicted", (_explanation(found),))
    against = held_out_against(found.before, found.after)
    if against:
        return Trust("contradicted", tuple(against))
    size = 100 * float(found.sizes[-LAST:].mean())
    return Trust(
        "limited",
        (
            "The published filter has no error bar. What is stated is the spread of its particles "
            f"{NARROW:g} times as wide; so much it was too narrow on 40 simulated movements. In "
            f"the last {min(LAST, len(found.infos))} moments they weighed alike to "
            f"{size:.1f} % (effective size over their number). Compare with `bodyschema track` "
            "without --method.",
        ),
    )


def _told(estimate: Estimate) -> Identifiability:
    """Which offsets the particles have narrowed: to less than half of the prior's variance."""
    prior = estimate.variables.prior_std
    said = np.linalg.eigvalsh(estimate.data_information * np.outer(prior, prior))
    share = np.clip(np.diag(estimate.covariance) / prior**2, 0.0, 1.0)
    return Identifiability(int(np.sum(said >= SAYS_LITTLE)), (), share)


def _notes(found: Filtered, estimate: Estimate) -> tuple[str, ...]:
    """What has to be known before the answer is used."""
    lines = []
    wide = [
        name
        for name, share in zip(found.variables.names, _told(estimate).open_share, strict=True)
        if share > 1 / (1 + SAYS_LITTLE)
    ]
    if wide:
        lines.append(f"The particles have hardly narrowed: {listed(wide, 8)}.")
    return tuple(lines)


def filtered_frames(
    found: Filtered, q: Array, numbers: Sequence[int], eye: str, hand: str
) -> list[dict[str, Any]]:
    """The hand at every moment as it was believed then, in plain types, SI.

    Args:
        found: by `filtered`.
        q: (n_moments, n_joints).
        numbers: of the first camera's pictures at these moments.
        eye: frame of the first camera.
        hand: frame.
    """
    frames = []
    for k, (number, posture) in enumerate(zip(numbers, q, strict=True)):
        belief = found.beliefs[k]
        T, covariance = hand_pose(found.estimate(belief), posture, eye, hand)
        frames.append(
            {
                "frame": int(number),
                "time": found.times[k],
                "T_camera_hand": T.tolist(),
                "covariance": covariance.tolist(),
                "offsets": found.infos[belief].offsets.tolist(),
                "effective_size": float(found.sizes[belief]),
                "held_out": k in found.held,
            }
        )
    return frames
