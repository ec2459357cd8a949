"""The plainest of the skeletons that nothing seen can tell apart: the one with the shortest links.

Where joint centres may slide along their axes, a learner puts them anywhere. Among all bodies that
predict the same, this takes

    minimise    sum_k |l_k + sum_j u_j m_jk|        over the slides and shifts u, see `invisible`

which is convex. A sum of lengths, not of squares, makes links vanish altogether: axes that meet in
a point, as in a shoulder or a hip, get that point as their common centre. It is solved by weighted
least squares with weights 1 / max(|l_k|, delta), delta falling (Daubechies et al. 2010).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from bodyschema.estimation.invisible import invisible_motions
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense

ROUNDS = 60
SMALLEST = 1e-9
"""Of the longest link: the last delta."""


def with_shortest_links(body: Body, variables: Variables, senses: Sequence[Sense]) -> Body:
    """The body with its joint centres where links are shortest; all that is seen stays as it is.

    Args:
        body: as learned.
        variables: what was free.
        senses: what was seen: the frames that look or are looked at keep their places.
    """
    watched = {frame for sense in senses for frame in (sense.seen_from, sense.seen)}
    motions = [m for m in invisible_motions(body, variables) if m.frame not in watched]
    if not motions:
        return body
    rows = np.stack([motion.row for motion in motions])
    M = np.zeros((len(rows), len(body.frames), 3))
    used = np.flatnonzero(rows.any(axis=0))
    M[:, variables.index[used], variables.component[used]] = rows[:, used]
    l0 = body.placement[:, :3, 3]
    delta = float(np.linalg.norm(l0, axis=1).max())
    shrink = SMALLEST ** (1 / ROUNDS)
    u = np.zeros(len(rows))
    for _ in range(ROUNDS):
        length = np.linalg.norm(l0 + np.tensordot(u, M, axes=1), axis=1)
        root = 1 / np.sqrt(np.maximum(length, delta))
        A = (root[:, None] * M).reshape(len(rows), -1).T
        u = np.linalg.lstsq(A, -(root[:, None] * l0).ravel(), rcond=None)[0]
        delta *= shrink
    return body.with_variables(variables, u @ rows)
