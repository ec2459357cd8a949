"""Whether poses of a hand and of what an eye saw were recorded as they are said to be.

Another declaration that explains them far better is named (`trust.neighbours`); where there is
none, and no place of hand and eye explains them, that is said.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.hand_eye.full_poses import HandEye
from bodyschema.model.tree import Body
from bodyschema.senses.poses import Poses
from bodyschema.trust.declarations import Recorded
from bodyschema.trust.neighbours import neighbourhood
from bodyschema.trust.plausibility import misdeclared
from bodyschema.trust.trust import Trust

Array = NDArray[np.float64]
Whose = Literal["robot", "eye"]

USELESS = (0.2, 0.35)
"""Noise of good pairs beyond which no place of hand and eye explains the poses: share of the hand's
travel, and rad."""

TRUE_SIZES = (0.8, 1.25)
"""A scale of the eye's lengths beyond these is no matter of a board's printer."""


def agrees(found: HandEye, A: Array) -> bool:
    """Whether good pairs agree so far that a place of hand and eye explains them."""
    position, turn = _noise(found)
    travel = max(float(np.linalg.norm(np.ptp(A[:, :3, 3], axis=0))), 1e-12)
    return position <= USELESS[0] * travel and turn <= USELESS[1]


def _noise(found: HandEye) -> tuple[float, float]:
    """Size of a good pair's residual in true lengths, m and rad."""
    position = float(np.sqrt(np.trace(found.noise[:3, :3]))) / found.scale
    return position, float(np.sqrt(np.trace(found.noise[3:, 3:])))


def declared_rightly(
    found: HandEye, A: Array, body: Body, sense: Poses, layouts: Mapping[Whose, str]
) -> Trust:
    """Contradicted, with a sentence, where poses are not what they are declared to be.

    Args:
        found: the answer to them as they are declared.
        A: (n, 4, 4) of the hand.
        body: the free hand, with eye and target attached anywhere.
        sense: what the eye saw.
        layouts: in which poses were recorded, where that is known.
    """
    recorded = {who: Recorded(layouts.get(who, ""), "m", "rad") for who in ("robot", "eye")}
    seen = neighbourhood(body, (sense,), {sense.label: recorded["eye"]}, recorded["robot"])
    if seen.neighbours:
        return misdeclared(seen.neighbours)
    if agrees(found, A):
        return Trust()
    position, turn = _noise(found)
    said = (
        f"As declared, the poses agree to {1e3 * position:.3g} mm and {np.rad2deg(turn):.2g} deg: "
        "no place of hand and eye explains them; perhaps rows of the two lists do not belong "
        "together, or one of them is not what it is declared to be."
    )
    return Trust("contradicted", (said,))
