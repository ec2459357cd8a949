"""Whether the body was found, how well the hand is known, and what to look at first, in words."""

from __future__ import annotations

import numpy as np

from bodyschema.report.tracking.evidence import TrackEvidence
from bodyschema.units import listed, shown

MOST_ROWS = 16
LARGE_BIAS = 1.0
"""pixels that a camera's outline lies off all round the body: the mask, or the mesh."""


def explanation(evidence: TrackEvidence) -> str:
    """The verdict in a sentence or two."""
    fit = evidence.fit
    names = fit.estimate.variables.groups
    joints = names.count("offsets")
    placed = len({group for group in names if group != "offsets"})
    found = f"{joints} joint offset{'s' * (joints != 1)}"
    if placed:
        found += f" and the place of {placed} camera{'s' * (placed > 1)}"
    pictures = int(np.isfinite(fit.weights.pictures).sum())
    if fit.lost:
        return (
            f"The body was not found: in {pictures} pictures only {100 * fit.matched:.0f} % of the "
            f"imagined contour could be found whatever the {found} might be. Nothing was corrected."
        )
    return (
        f"{found[0].upper()}{found[1:]}, {int(fit.weights.used.sum())} of {pictures} pictures "
        f"used: {100 * fit.matched:.0f} % of "
        f"the imagined contour lies within 2 pixels of what was seen, half of it within "
        f"{fit.residual:.2f}."
    )


def findings(evidence: TrackEvidence) -> tuple[str, ...]:
    """How well the hand is known, and how often it was lost."""
    gone, total = int(evidence.lost.sum()), len(evidence.poses)
    lost = f"The hand is lost in {gone} of {total} rows."
    if evidence.fit.lost:
        return (lost,)
    good = ~evidence.lost
    seen = good if good.any() else ~good
    metres, turn = np.median(evidence.std[seen], axis=0)
    shift = np.median(evidence.shift[seen], axis=0)
    return (
        f"'{evidence.hand}' is known in camera '{evidence.cameras[0]}' to "
        f"± {shown(float(metres), 'm', 2)} and ± {shown(float(turn), 'rad', 2)} (one standard "
        f"deviation in the worst direction), {shown(float(shift[0]), 'm')} and "
        f"{shown(float(shift[1]), 'rad')} from where it was believed to be.",
        lost,
    )


def warnings(evidence: TrackEvidence) -> tuple[str, ...]:
    """What has to be known before the answer is used."""
    lines = [*_unused(evidence), *_lost(evidence), *_biased(evidence)]
    if evidence.kept and not evidence.fit.lost:
        lines.append(
            f"Left as modelled, because the pictures do not tell: {listed(evidence.kept, 8)}."
        )
    return tuple(lines)


def _unused(evidence: TrackEvidence) -> list[str]:
    """Pictures that count little, and why: by what was found in each."""
    if evidence.fit.lost:
        return []
    weights = evidence.fit.weights
    gone = np.argwhere(~weights.used & np.isfinite(weights.pictures))
    if not len(gone):
        return []
    names = [
        f"{evidence.cameras[c]} {evidence.numbers[evidence.learned_from[k]]} "
        f"({weights.pictures[k, c]:.2f})"
        for k, c in gone.tolist()
    ]
    return [
        "Pictures that count little, with their weights, as less than half of what they should "
        f"show was found: {listed(names, MOST_ROWS)}."
    ]


def _lost(evidence: TrackEvidence) -> list[str]:
    gone = np.flatnonzero(evidence.lost).tolist()
    if len(gone) == len(evidence.poses) and not evidence.fit.lost:
        return [
            f"The body was found, but what carries '{evidence.hand}' shows in no picture as it "
            "is modelled: is something mounted on it? Name another hand, or correct its "
            "mesh; the offsets come from the other links."
        ]
    if not gone:
        return []
    numbers = listed([evidence.numbers[i] for i in gone], MOST_ROWS)
    return [
        f"The hand is lost in {len(gone)} of {len(evidence.poses)} moments: pictures "
        f"{numbers}. Their poses are what the encoders say, and nothing confirms them."
    ]


def _biased(evidence: TrackEvidence) -> list[str]:
    lines = []
    for camera, bias in zip(evidence.cameras, evidence.fit.bias, strict=True):
        if abs(bias) > LARGE_BIAS:
            way = "outside" if bias > 0 else "inside"
            lines.append(
                f"The outline in camera '{camera}' lies {abs(bias):.1f} pixels {way} the "
                "imagined one all round: its masks, its focus or the meshes are off."
            )
    return lines
