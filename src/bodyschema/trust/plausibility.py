"""Plausibility: whether an answer explains what was seen at all, in absolute terms.

A fit is always the best of its kind; nothing in it says whether it is any good. These do:

    share     median of what is left over, held out, to the median distance of what was seen from
              its middle: good recordings leave below 5 %, wrongly declared ones mostly above 45 %
    reach     what was seen spreads no further than some times the reach of the robot

Medians, so that outliers are not asked. A spread counts as at least a share of the robot's reach
(positions) or a few degrees (rotations): noise may be as large as a motion that is hardly one.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.lie import nearest_rotation
from bodyschema.model.kernels import PRISMATIC
from bodyschema.model.kinematics import path_between
from bodyschema.model.tree import Body
from bodyschema.seeds.frame_fits import angle
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.points import Points
from bodyschema.senses.poses import Poses
from bodyschema.senses.sense import Sense
from bodyschema.trust.neighbours import Neighbour
from bodyschema.trust.trust import Trust
from bodyschema.units import shown

Array = NDArray[np.float64]

WARN, REFUSE = 0.12, 0.3
"""Shares above which an answer is limited, and contradicted."""

LEAST_SPREAD = {"m": 0.1, "rad": 0.2, "px": 20.0}
"""Least spread that counts: of positions as a share of the reach, rad, px."""

BEYOND = 20.0
"""Times the robot's reach that what is seen of it cannot spread."""

FEW = 6
"""Samples below which nothing is said."""

MANY = 3
"""Neighbours that a sentence names."""


def refuse_beyond(body: Body, senses: Sequence[Sense], named: Sequence[Neighbour]) -> None:
    """Refuse positions that spread further than the robot can move anything.

    Args:
        body: as described.
        senses: what was seen.
        named: declarations under which it would fit.

    Raises:
        InputError: in one sentence, with what to write if a neighbour says it.
    """
    for sense in senses:
        if not isinstance(sense, Points | Poses) or len(sense) < FEW:
            continue
        far, limit = _spreads(sense)[0], reach(body, sense)
        if far > BEYOND * limit > 0:
            entry = next((n.entry for n in named if n.declaration.key == "unit"), "")
            cause = f"set {entry} for them" if entry else "look at the unit of the lengths"
            raise InputError(
                f"what is seen of '{sense.seen}' from '{sense.seen_from}' spreads over {far:.3g} m "
                f"where the robot reaches {limit:.3g} m; {cause}, or at that of the description."
            )


def plausible(body: Body, senses: Sequence[Sense], residuals: Sequence[Array]) -> Trust:
    """Whether what is left over is small against what was seen.

    Args:
        body: that explains it.
        senses: what was seen.
        residuals: (n, dimension) of each, held out.
    """
    trust = Trust()
    for sense, residual in zip(senses, residuals, strict=True):
        for trial in _left_over(body, sense, residual):
            trust = trust.also(trial)
    return trust


def misdeclared(named: Sequence[Neighbour]) -> Trust:
    """What neighbours say of a recording; good where there are none."""
    if not named:
        return Trust()
    best = named[0]
    words = " or with ".join(neighbour.words for neighbour in named[:MANY])
    more = " (the data do not tell these apart)" if len(named) > 1 else ""
    what = f"Declared otherwise, with {words}{more}, the recording fits {times(best.factor)} better"
    left = f"{_residual(best.before)} are left over as it is declared, {_residual(best.after)} then"
    advice = f"write {best.entry}" if best.entry else "mend the recording or the description"
    return Trust("contradicted", (f"{what}: {left}; {advice} and calibrate again.",))


def times(factor: float) -> str:
    """A factor in words."""
    return f"{factor:.1f} times" if factor < 10 else f"{min(factor, 1e4):.0f} times"


def _residual(left: tuple[float, float]) -> str:
    metres, radians = left
    turn = f" and {shown(radians, 'rad')}" if radians > 0 else ""
    return f"{shown(metres, 'm')}{turn}"


def left_share(body: Body, senses: Sequence[Sense], residuals: Sequence[Array]) -> float:
    """The largest share of what was seen that is left over, of any sense and component."""
    pairs = zip(senses, residuals, strict=True)
    shares = (share for sense, residual in pairs for *_, share in _shares(body, sense, residual))
    return max(shares, default=0.0)


def _shares(
    body: Body, sense: Sense, residual: Array
) -> Iterator[tuple[str, str, float, float, float]]:
    """Name, unit, median residual, spread and share of each component of a sense.

    Of a handful of samples a median says nothing.
    """
    if len(sense) < FEW:
        return
    for (name, unit, rows), spread in zip(sense.components, _spreads(sense), strict=False):
        least = LEAST_SPREAD[unit] * (reach(body, sense) if unit == "m" else 1.0)
        left = float(np.median(np.linalg.norm(residual[:, rows], axis=1)))
        yield name, unit, left, spread, left / max(spread, least, 1e-12)


def _left_over(body: Body, sense: Sense, residual: Array) -> Iterator[Trust]:
    for name, unit, left, spread, share in _shares(body, sense, residual):
        said = (
            f"{sense.label}: half of the {name}s are off by more than {shown(left, unit)}, held "
            f"out, where they spread by {shown(spread, unit)} ({100 * share:.0f} %)"
        )
        if share > REFUSE:
            yield Trust("contradicted", (f"{said}: {REFUSED}",))
        elif share > WARN:
            yield Trust("limited", (f"{said}: {WARNED}",))


REFUSED = (
    "no place of the frames and no correction explains the recording, nor does any other "
    "declaration that was tried; perhaps rows do not belong together, or it is another robot."
)
WARNED = (
    "much of what was seen is not explained; perhaps the robot differs from its description by "
    "more than was freed, or the fit is local."
)


def _spreads(sense: Sense) -> tuple[float, ...]:
    """Median distance from the middle of what was seen, of each component; none for others."""
    if isinstance(sense, Poses):
        R = sense.pose[:, :3, :3]
        turned = float(np.median(angle(R, nearest_rotation(R.mean(axis=0)))))
        return _spread(sense.pose[:, :3, 3]), turned
    if isinstance(sense, Points | Pixels) and len(sense):
        return (_spread(sense.observed),)
    return ()


def _spread(places: Array) -> float:
    middle = np.median(places, axis=0)
    return float(np.median(np.linalg.norm(places - middle, axis=1)))


def reach(body: Body, sense: Sense) -> float:
    """m, the links between the frames that carry those of a sense, and how far joints slide."""
    total, slid = 0.0, np.ptp(sense.q, axis=0) if len(sense) else np.zeros(len(body.joints))
    for a, b in sense.pairs:
        path, _ = path_between(body, a, b)
        ends = {body.frame_index(a), body.frame_index(b)}
        inner = [k for k in path if k not in ends or body.driver[k] >= 0]
        links = float(np.linalg.norm(body.placement[inner, :3, 3], axis=1).sum())
        sliding = [body.driver[k] for k in inner if body.kind[k] == PRISMATIC]
        total = max(total, links + float(slid[sliding].sum()))
    return total
