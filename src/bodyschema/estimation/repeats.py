"""Repeats: samples of one posture are counted for what they are worth.

What a model does not explain is the same whenever a posture is held again, and much the same for
all markers of one picture. Such samples agree with one another more than with the model, and to
count each in full would make the belief too sure and let one posture outvote the others.

With z_i the residual in units of its noise, d numbers, rho the correlation of two samples of one
posture and one kind (the intra-class correlation), the sum over a posture of m samples has

    E |sum z_i|^2 = m (1 + (m - 1) rho) (d - h)

h = u/m tr B C B^T, B = sum A_i, the share that the variables have absorbed (A_i whitened, weighted
Jacobians, u the worth of each sample). Solved for rho over all postures of a kind. m samples then
tell as much as m / (1 + (m - 1) rho) that are independent: each is worth

    u = 1 / (1 + (m - 1) rho)        between 1/m, all the same, and 1, all independent
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.descent import State, covariance
from bodyschema.estimation.moments import postures
from bodyschema.estimation.objective import Objective

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

LEAST_LEFT = 0.1
"""Share of the numbers of repeated postures that the variables must leave before anything can be
said of rho; below it all samples count in full."""


def worth(objective: Objective, state: State, same: float) -> tuple[Array, ...]:
    """u of each sample, (n,) a sense, from the residuals of a finished fit.

    Args:
        objective: what was fitted.
        state: where its descent came to rest.
        same: rad or m, see `moments.postures`.
    """
    posture = postures(objective.senses, same, objective.reference)
    found = [np.ones(len(sense)) for sense in objective.senses]
    kinds: dict[object, list[int]] = {}
    for i, sense in enumerate(objective.senses):
        kinds.setdefault((type(sense), sense.seen_from, len(sense.covariance)), []).append(i)
    for members in kinds.values():
        together = np.concatenate([posture[i] for i in members])
        _, group, m = np.unique(together, return_inverse=True, return_counts=True)
        if m.max(initial=0) < 2:
            continue
        rho = correlation(objective, state, members, group, m)
        each = 1 / (1 + (m[group] - 1) * rho)
        ends = np.cumsum([len(posture[i]) for i in members])[:-1]
        for i, u in zip(members, np.split(each, ends), strict=True):
            found[i] = u
    return tuple(found)


def correlation(
    objective: Objective, state: State, members: Sequence[int], group: Ints, m: Ints
) -> float:
    """rho of one kind of samples, between 0 and 1.

    Args:
        objective: what was fitted.
        state: where its descent came to rest.
        members: which of the senses are of the kind.
        group: (n,) posture of each of their samples, from 0.
        m: (n_postures,) samples of each.
    """
    C = covariance(objective, state.shares, state.theta)
    weights = objective.weights(state.place.squares, state.theta)
    scales = objective.noise.rows(np.exp(-state.theta))
    ends = np.cumsum([0, *(len(objective.senses[i]) for i in members)])
    z, A, u = [], [], []
    for i, a, b in zip(members, ends[:-1], ends[1:], strict=True):
        again = m[group[a:b]] > 1
        part, worth = state.place.parts[i], objective.worth[i][again]
        root = np.sqrt(weights[i][again] / np.maximum(worth, 1e-300))[:, None] * scales[i]
        z.append(part.residual[again] * root)
        A.append(part.jacobian[again] * root[..., None])
        u.append(worth)
    repeated = group[m[group] > 1]
    S, B = _sums(np.concatenate(z), repeated), _sums(np.concatenate(A), repeated)
    count, d = m[m > 1], S.shape[1]
    absorbed = np.einsum("gdn,gdn->g", B @ C, B)
    h = absorbed * _sums(np.concatenate(u), repeated) / count**2
    pairs, left = count * (count - 1.0), np.maximum(d - h, 0.0)
    if pairs @ left < LEAST_LEFT * d * pairs.sum():
        return 0.0
    return float(np.clip((np.sum(S**2) - count @ left) / (pairs @ left), 0.0, 1.0))


def _sums(rows: Array, group: Ints) -> Array:
    """Sum of the rows of each group, in the order of the groups' numbers, (n_groups, ...)."""
    order = np.argsort(group, kind="stable")
    begins = np.flatnonzero(np.diff(group[order], prepend=-1))
    return np.add.reduceat(rows[order], begins, axis=0)
