"""Whether an answer from pictures may be believed: pictures that count, and what contradicts it.

Pictures have weights of their own (`learners.images.picture_weights`), and what moments, pieces and
held-out pictures contradict has widened the error bars (`learners.images.disagreement`). Here it is
said where that is not enough: also where cameras seem to stand elsewhere than they are said to
(`learners.images.elsewhere`).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from bodyschema.learners.images.disagreement import Disagreement
from bodyschema.learners.images.elsewhere import Elsewhere
from bodyschema.learners.images.markerless_fit import MarkerlessFit
from bodyschema.trust.trust import Trust

PER_PICTURE = 6
"""Unknowns that one picture of a rigid body tells."""

USUAL = 0.75
"""Share of the pictures: if fewer count the answer is limited."""

FEW_MOMENTS = 3
"""With fewer moments that count, what they contradict each other is hardly known."""

WIDENED = {True: 1.5, False: 3.0}
"""Times the error bars that noise alone would give, with masks and without. Of good simulated arms
none reaches 1.4 with masks; what light does to edges contradicts itself up to 2.4 times."""

WORSE = 0.3
"""pixels that held-out outlines may lie farther off than those of the body as believed: as well as
an edge is found."""


def picture_trust(
    fit: MarkerlessFit,
    before: Mapping[int, float],
    after: Mapping[int, float],
    freed: Elsewhere | None = None,
) -> Trust:
    """What speaks against a fit.

    Args:
        fit: to the pictures of several moments.
        before: px, distance of the outline from the body as believed, by moments held out.
        after: the same from the body as found.
        freed: the fit with the cameras freed that are said to be known, if there are any.
    """
    if fit.lost:
        share = f"{100 * fit.matched:.0f} % of the imagined contour"
        return Trust("contradicted", (f"The body was not found: {share} is in the pictures.",))
    against = [*_pictures_against(fit), *held_out_against(before, after)]
    limits = [*_pictures_few(fit), *_widened(fit.disagreement)]
    if freed is not None and freed.doubted:
        if _explains(freed, fit.disagreement):
            against.insert(0, _stands_elsewhere(freed, fit.disagreement))
        else:
            limits.insert(0, _perhaps_elsewhere(freed))
    if against:
        return Trust("contradicted", tuple(against))
    return Trust("limited" if limits else "good", tuple(limits))


def counted(fit: MarkerlessFit) -> tuple[int, int]:
    """How many pictures count, and of how many in which the body would show."""
    return int(fit.weights.used.sum()), int(np.isfinite(fit.weights.pictures).sum())


def counts(fit: MarkerlessFit, cameras: Sequence[str]) -> dict[str, object]:
    """Weights and factors in plain types.

    Args:
        fit: to the pictures.
        cameras: their names.
    """
    used, there = counted(fit)
    weights, apart = fit.weights, fit.disagreement
    columns = zip(cameras, np.nan_to_num(weights.pictures).T.tolist(), strict=True)
    pieces = zip(fit.model.surface.frames, np.nan_to_num(weights.pieces).tolist(), strict=True)
    return {
        "used": used,
        "of": there,
        "weights": dict(columns),
        "cameras": dict(zip(cameras, weights.cameras.tolist(), strict=True)),
        "pieces": dict(pieces),
        "widened_by": math.sqrt(apart.kappa),
        "variance_by": {
            "pieces": apart.by_piece,
            "moments": apart.by_moment,
            "doubts": apart.by_doubt,
            "halves": apart.by_half,
        },
    }


def _pictures_against(fit: MarkerlessFit) -> list[str]:
    used, there = counted(fit)
    unknowns, lines = len(fit.model.wanted), []
    if not fit.agreed:
        lines.append(
            f"Only {used} of {there} pictures show the body where the answer says: the majority "
            "speaks against it. Compare pictures and rows of the recording, masks and meshes."
        )
    if used < (needed := math.ceil(unknowns / PER_PICTURE)):
        lines.append(
            f"{used} of {there} pictures count, and {unknowns} unknowns ask for {needed} or more; "
            "take more pictures, or free less."
        )
    return lines


def held_out_against(before: Mapping[int, float], after: Mapping[int, float]) -> list[str]:
    """Why the correction does not hold in moments that were not learned from, if it does not.

    Args:
        before: px, distance of the outline from the body as believed, by moment.
        after: the same from the body as found.
    """
    if not after:
        return []
    was, now = (float(np.median(list(errors.values()))) for errors in (before, after))
    if now <= was + WORSE:
        return []
    return [
        f"In pictures that were held out the outline is {now:.1f} pixels off after the correction "
        f"and {was:.1f} before: it does not hold beyond what it was learned from. Take more "
        "postures, or free less."
    ]


def _pictures_few(fit: MarkerlessFit) -> list[str]:
    used, there = counted(fit)
    moments, lines = int(fit.weights.used.any(axis=1).sum()), []
    if used < USUAL * there:
        lines.append(
            f"{used} of {there} pictures count; the others do not show the body where it should "
            "be. Look at their overlays."
        )
    if moments < FEW_MOMENTS:
        lines.append(
            f"The answer rests on {moments} moment{'s' * (moments != 1)}, which hardly tell how "
            f"far they contradict each other; take {FEW_MOMENTS} or more."
        )
    return lines


def _widened(apart: Disagreement) -> list[str]:
    """By whom most, and how much more than by noise."""
    if apart.contradiction <= WIDENED[apart.masked] ** 2:
        return []
    shares = {
        "links": apart.by_piece,
        "postures": apart.by_moment,
        "halves of the pictures": apart.by_half,
        "lens, mounting or meshes and what was said of them": apart.by_doubt,
    }
    who = max(shares, key=lambda name: shares[name])
    worst = apart.names[int(np.argmax(apart.piece_shares))]
    most = f", most of all '{worst}' (perhaps its mesh or its joint)" if who == "links" else ""
    factor = math.sqrt(apart.contradiction)
    return [
        f"The error bars are {factor:.1f} times those of noise alone: {who} contradict each "
        f"other{most}. Look at the overlays; check meshes, lens and masks."
    ]


def elsewhere_details(freed: Elsewhere | None) -> dict[str, object] | None:
    """What freeing the cameras showed, in plain types: m, rad; None where nothing was freed."""
    if freed is None:
        return None
    return {
        "surprise": freed.surprise,
        "freedom": freed.freedom,
        "p_value": freed.p_value,
        "contradiction_left": freed.left,
        "contradiction_left_by_rivals": dict(freed.rivals),
        "shifts": {camera: list(freed.shift(camera)) for camera in freed.cameras},
    }


def _explains(freed: Elsewhere, apart: Disagreement) -> bool:
    """Whether freed cameras, and neither lens nor meshes, make what is contradicted usual."""
    usual = WIDENED[apart.masked] ** 2
    return apart.contradiction > usual >= freed.left and min(freed.rivals.values()) > usual


def _stands_elsewhere(freed: Elsewhere, apart: Disagreement) -> str:
    share = (apart.contradiction - freed.left) / (apart.contradiction - 1)
    second = min(freed.rivals, key=lambda name: freed.rivals[name])
    rest = (apart.contradiction - freed.rivals[second]) / (apart.contradiction - 1)
    return (
        f"{_moved(freed)}: that explains {100 * share:.0f} % of what the pictures contradict each "
        f"other, and wrong {second} {100 * max(rest, 0.0):.0f} %. The camera is elsewhere than it "
        'is said to be; measure its place, or say that it is known = "roughly".'
    )


def _perhaps_elsewhere(freed: Elsewhere) -> str:
    return (
        f"{_moved(freed)} (chance {freed.p_value:.1g} if it were where it is said to be): perhaps "
        "it is elsewhere, or lens or meshes are wrong. The error bars are those of a camera that "
        'is known = "roughly"; measure its place, or say so.'
    )


def _moved(freed: Elsewhere) -> str:
    """The camera that moves farthest, and how far."""
    camera = max(freed.cameras, key=lambda name: freed.shift(name))
    along, turn = freed.shift(camera)
    return (
        f"The pictures move camera '{camera}' by {1e3 * along:.0f} mm and "
        f"{math.degrees(turn):.1f} degrees if they may"
    )
