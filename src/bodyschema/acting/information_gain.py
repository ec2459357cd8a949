"""How much a posture would tell of the body before anybody goes there.

In units of the prior, x = D y, with the whitened Jacobians J_i (d, N) of all senses at posture i:

    belief       F = D (data information) D + 1          C = F^-1
    after i      F + J_i^T J_i
    tool error   mean over the work of |J_t D y|^2 = tr(W C),       W = mean of (J_t D)^T J_t D
    "tool"       falls by   tr(S_i^-1 J_i C W C J_i^T),             S_i = 1 + J_i C J_i^T
    "all"        log det F grows by   log det S_i

"tool" is A-optimality weighted by what the body is used for, "all" is D-optimality: every parameter
counts by how far it is from known. Both are exact for one more posture; poses are taken greedily.
An open direction has the variance of its prior, so that closing it pays if the tool can feel it.

A robust learner gives a sample of Student-t noise the Fisher information (nu + d) / (nu + d + 2) of
J^T J / s^2, and so does the forecast.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.loss import Loss, fisher_share
from bodyschema.estimation.normal_equations import (
    level_rows,
    positive_factor,
    solve_factored,
    whiten,
)
from bodyschema.model.kinematics import relative_pose_derivatives
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]
Criterion = Literal["tool", "all"]
Pair = tuple[str, str]
"""(seen_from, seen): the frames between which the tool error counts."""

FREEDOM = Loss().freedom
"""Of the Student-t noise that the batch learner assumes."""


def believed_information(estimate: Estimate) -> Array:
    """F in units of the prior, (N, N): data and prior."""
    D = estimate.variables.scale
    return np.asarray(D[:, None] * estimate.information * D)


def noise_levels(estimate: Estimate, sense: Sense) -> tuple[float, ...]:
    """Learned noise of each component, in units of the believed noise; 1 where none is stored."""
    learned = estimate.noise or {}
    believed = np.sqrt(np.diag(sense.covariance))
    return tuple(
        learned.get(f"{sense.label}: {name} ({unit})", mean) / mean
        for name, unit, rows in sense.components
        for mean in (float(np.mean(believed[rows])),)
    )


def expected_jacobians(
    estimate: Estimate, senses: Sequence[Sense], q: Array, visible: Flags
) -> Array:
    """Whitened Jacobians of all senses at postures q, (n, d, N), in units of the prior.

    Args:
        estimate: the belief, with noise levels.
        senses: what would be seen at a posture; their samples are not used.
        q: (n, n_joints).
        visible: (n, n_senses) which sense would see anything.
    """
    blocks = []
    for sense, seen in zip(senses, visible.T, strict=True):
        ideal = sense.pictured(estimate.body, q)
        part = whiten(ideal, estimate.reference, estimate.variables, estimate.x)
        scale = np.sqrt(fisher_share(FREEDOM, part.residual.shape[1]))
        root = scale / level_rows(sense, noise_levels(estimate, sense))
        J = _by_posture(part.jacobian * root[:, None], ideal.rows, len(q))
        blocks.append(J * seen[:, None, None])
    return np.asarray(np.concatenate(blocks, axis=1) * estimate.variables.scale)


def _by_posture(J: Array, posture: Ints, n: int) -> Array:
    """Jacobians (m, d, N) of samples as those of n postures (n, k, N) with the same J^T J.

    Args:
        J: of one sample a posture, which stay as they are, or of many, as those of an outline.
        posture: (m,) which one a sample belongs to, from 0.
        n: how many there are.
    """
    if len(J) == n:
        return J
    size = J.shape[2]
    found = np.zeros((n, size, size))
    for i in range(n):
        R = np.linalg.qr(J[posture == i].reshape(-1, size), mode="r")
        found[i, : len(R)] = R
    return found


def tool_jacobians(estimate: Estimate, pairs: Sequence[Pair], q: Array) -> Array:
    """Derivative of each pair's position (m) at postures q, (pairs * n, 3, N), prior units."""
    parts = [
        relative_pose_derivatives(
            estimate.reference, estimate.variables, estimate.x, q, seen_from, seen
        ).by_parameter[:, :3]
        for seen_from, seen in pairs
    ]
    return np.asarray(np.concatenate(parts) * estimate.variables.scale)


def covariance_of(F: Array) -> Array:
    """Covariance of an information matrix in units of the prior, (N, N), symmetric."""
    C = solve_factored(positive_factor(F), np.eye(len(F)))
    return np.asarray((C + C.T) / 2)


def gains(J: Array, C: Array, W: Array | None) -> Array:
    """Gain of each posture, (n,): in tr(W C), or in log det F when W is None."""
    n, d, N = J.shape
    S = ((J.reshape(n * d, N) @ C).reshape(n, d, N)) @ np.swapaxes(J, 1, 2) + np.eye(d)
    if W is None:
        return np.asarray(np.linalg.slogdet(S)[1])
    A = ((J.reshape(n * d, N) @ (C @ W @ C)).reshape(n, d, N)) @ np.swapaxes(J, 1, 2)
    return np.asarray(np.trace(np.linalg.solve(S, A), axis1=1, axis2=2))


def greedy(F: Array, J: Array, W: Array | None, n: int) -> Ints:
    """Rows of J that tell most, one after the other, each once, (n,)."""
    chosen: list[int] = []
    for _ in range(min(n, len(J))):
        gain = gains(J, covariance_of(F), W)
        gain[chosen] = -np.inf
        best = int(np.argmax(gain))
        chosen.append(best)
        F = F + J[best].T @ J[best]
    return np.array(chosen, dtype=np.int64)
