"""Some of many samples, spread over time and over the postures: a start needs no more.

Every moment of a recording stands at a place between 0 and 1, half by when it came and half by how
far the joints had travelled until then. The places are cut into equal pieces, and one moment of
each piece is drawn. A robot that waits is not asked again and again; a share of bad rows stays the
share that it is, whatever their rhythm; and no posture counts for being far from the others, as a
slipped encoder's would be.
"""

from __future__ import annotations

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
S = TypeVar("S", bound=Sense)

MOST = 1000
"""Moments that place a frame. Where 45 % of all are bad, of 1000 drawn at most 50 % are (three
standard errors), of 300 more than half in one recording of 25."""

USUAL_STEP = 0.9
"""Quantile of the joints' steps at which longer ones are cut: a jump is no long journey."""


def spread(sense: S, most: int = MOST) -> S:
    """At most so many moments of a sense; all of it where it has no more.

    Args:
        sense: samples that share time and row belong to one moment and stay together.
        most: moments.
    """
    if len(sense) <= most:
        return sense
    stamps = np.stack([sense.time, sense.rows])
    _, first, moment = np.unique(stamps, axis=1, return_index=True, return_inverse=True)
    if len(first) <= most:
        return sense
    order = np.argsort(first)
    piece = np.minimum((_places(sense.q[first[order]]) * most).astype(int), most - 1)
    shuffled = np.random.default_rng(0).permutation(len(order))
    _, drawn = np.unique(piece[shuffled], return_index=True)
    return sense.take(np.isin(moment.ravel(), order[shuffled[drawn]]))


def _places(q: Array) -> Array:
    """Where each moment stands, (n,) from 0 to 1, by time and by travel."""
    reach = np.ptp(q, axis=0)
    steps = np.linalg.norm(np.diff(q, axis=0) / np.where(reach > 0, reach, 1.0), axis=1)
    travel = np.append(0.0, np.cumsum(np.minimum(steps, np.quantile(steps, USUAL_STEP))))
    time = np.arange(len(q)) / len(q)
    return np.asarray((time + travel / travel[-1]) / 2 if travel[-1] > 0 else time)
