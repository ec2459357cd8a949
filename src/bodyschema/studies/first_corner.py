"""Several corners at once: the published learner for each, the first to finish wins.

Nabeshima and Kuniyoshi, section 4.3: every corner that is detected on the body is a tip of its own.
While identifying, each is given to a learner of its own; the first whose rule holds ends it for
all, and its corner alone is watched ("one of red circles changes to a red rectangle"). When its
error has been too large for long enough, all begin anew. A corner that is not seen, in one picture
or the other, says nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.hand_eye.stereo_points import triangulated_rows
from bodyschema.learners.published.linear_relation import PaperRelation, Relation

Array = NDArray[np.float64]

UNKNOWNS = 16
"""Camera's rotation and place, and the corner in the hand."""


@dataclass(frozen=True)
class Corners:
    """State: what is known of each corner."""

    relations: tuple[Relation, ...]
    winner: int | None = None
    """The corner that is watched; None while identifying."""


@dataclass(frozen=True)
class FirstCorner:
    """Learners of K corners that stop together."""

    count: int
    """K."""
    ssd: float
    """Closeness to a rotation below which one of them stops."""

    def start(self) -> Corners:
        """Nothing seen."""
        return Corners((self._learner.start(),) * self.count)

    def step(self, state: Corners, T_world_hand: Array, seen: Array) -> tuple[Corners, str]:
        """One moment.

        Args:
            state: before it.
            T_world_hand: (4, 4).
            seen: (K, 3) m in the camera, nan where a corner is not seen.

        Returns:
            the state, and "identified", "alarm" or "".
        """
        if state.winner is not None:
            return self._watched(state, state.winner, T_world_hand, seen)
        relations, winner = list(state.relations), None
        for k in np.flatnonzero(np.isfinite(seen).all(axis=1)):
            rows = triangulated_rows(T_world_hand, seen[k])
            relations[k], (look,) = self._learner.step(relations[k], (rows,))
            if look.event == "identified" and winner is None:
                winner = int(k)
        return Corners(tuple(relations), winner), "" if winner is None else "identified"

    def _watched(
        self, state: Corners, winner: int, T_world_hand: Array, seen: Array
    ) -> tuple[Corners, str]:
        if not np.isfinite(seen[winner]).all():
            return state, ""
        rows = triangulated_rows(T_world_hand, seen[winner])
        relation, (look,) = self._learner.step(state.relations[winner], (rows,))
        if look.event == "changed":
            return self.start(), "alarm"
        known = (*state.relations[:winner], relation, *state.relations[winner + 1 :])
        return replace(state, relations=known), ""

    @property
    def _learner(self) -> PaperRelation:
        return PaperRelation(UNKNOWNS, closest=self.ssd)
