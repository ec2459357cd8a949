"""Moments: which samples were taken in one posture, and which rows of a recording belong together.

Samples of one row share its moment. A posture that is held, or taken again, is no new one either:
what a model gets wrong there, it gets wrong each time.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from bodyschema.model.kinematics import path_between
from bodyschema.model.tree import Body
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Senses = Sequence[Sense]

SAME_POSTURE = 1e-4
"""rad or m: readings nearer to each other belong to one posture; at a metre from a joint they are a
tenth of a millimetre apart. FR3's arm comes back to within 6e-5 rad."""


def postures(senses: Senses, same: float = SAME_POSTURE, body: Body | None = None) -> list[Ints]:
    """Number of the posture of each sample, (n,) a sense; samples of one posture share it.

    Args:
        senses: what was seen.
        same: rad or m; how far the reading of each joint may be from that of the posture's first
            sample.
        body: whose joints they are; those between no two frames of the senses then do not count.
    """
    q = np.concatenate([sense.q for sense in senses])[:, _joints(senses, body)]
    # Where a robot rests thousands of readings differ by a tick: one of each cell is compared.
    _, first, cell = np.unique(np.floor(q / same), axis=0, return_index=True, return_inverse=True)
    found = _leaders(q[first], same)[cell.ravel()]
    return np.split(found, np.cumsum([len(sense) for sense in senses])[:-1])


def _joints(senses: Senses, body: Body | None) -> Ints:
    """Columns of q that count."""
    if body is None:
        return np.arange(senses[0].q.shape[1])
    paths = [path_between(body, *pair)[0] for sense in senses for pair in sense.pairs]
    drivers = np.concatenate([body.driver[path] for path in paths])
    return np.unique(drivers[drivers >= 0])


def _leaders(points: Array, same: float) -> Ints:
    """For each point the first one, itself or not, that leads and is near enough, (n,).

    Groups have a leader rather than chains of neighbours, or a slow movement would be one posture.
    """
    from scipy.spatial import cKDTree

    leader = np.arange(len(points))
    pairs = cKDTree(points).query_pairs(same, np.inf, output_type="ndarray")
    for i, j in pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]:
        if leader[i] == i and leader[j] == j:
            leader[j] = i
    return leader


def moments_of(
    senses: Senses, same: float = SAME_POSTURE, body: Body | None = None
) -> tuple[Ints, Ints]:
    """All row numbers (n_rows,), sorted, and the number of the moment of each, from 0.

    Rows of one posture are of one moment, and so is what shares a row number.
    """
    rows, index = np.unique(np.concatenate([sense.rows for sense in senses]), return_inverse=True)
    posture = np.concatenate(postures(senses, same, body))
    # A graph with a node for each row and one for each posture, and a link for each sample.
    size = len(rows) + len(posture)
    links = (np.ones(len(posture)), (index.ravel(), len(rows) + posture))
    label = connected_components(coo_array(links, shape=(size, size)), directed=False)[1]
    return rows, np.unique(label[: len(rows)], return_inverse=True)[1].ravel()
