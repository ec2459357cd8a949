"""First values of X and Y in A_i X = Y B_i that hold against many bad pairs.

Closed forms on all pairs fail when some are bad; on four pairs drawn at random they succeed when
those four are good. Every candidate is scored on all pairs by

    sum log(1 + (|p| / 2 s_p)^2 + (|w| / 2 s_w)^2)

with |p|, |w| the position and rotation parts of the residual and s_p, s_w their smallest 40 %
quantile over the candidates: more than half of the pairs may be bad.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.seeds.closed_forms import mean_transform, solve_ax_xb, solve_ky_xt

Array = NDArray[np.float64]
Frames = tuple[Array, Array]
"""X and Y."""

DRAWS = 200
DRAWN = 4
KEPT = 3
QUANTILE = 0.4


def pair_starts(A: Array, B: Array, seed: int = 0, draws: int = DRAWS) -> list[Frames]:
    """The best candidates, best first.

    Args:
        A: (n, 4, 4) poses known from the robot.
        B: (n, 4, 4) poses seen.
        seed: of the draws.
        draws: how many fours of pairs are tried.
    """
    candidates = _on_all(A, B) + _on_draws(A, B, draws, np.random.default_rng(seed))
    errors = np.array([_errors(A, B, X, Y) for X, Y in candidates])
    levels = np.maximum(np.quantile(errors, QUANTILE, axis=2).min(axis=0), 1e-9)
    score = np.sum(np.log1p(np.sum((errors / (2 * levels[:, None])) ** 2, axis=1)), axis=1)
    return [candidates[k] for k in np.argsort(score, kind="stable")[:KEPT]]


def _on_all(A: Array, B: Array) -> list[Frames]:
    """Closed forms on all pairs, with motions between each pair and partners near and far."""
    n, ones = len(A), np.ones(len(A))
    Y, X = solve_ky_xt(A, B, ones)
    found = [(X, Y)]
    for apart in {1, n // 3, n // 2} - {0}:
        partner = np.roll(np.arange(n), apart)
        found.append(_from_motions(A, B, np.arange(n), partner, ones))
    return found


def _on_draws(A: Array, B: Array, draws: int, rng: np.random.Generator) -> list[Frames]:
    """X from the six motions between four pairs, Y from those pairs."""
    m = min(DRAWN, len(A))
    first, second = np.triu_indices(m, 1)
    k = np.array([rng.choice(len(A), m, replace=False) for _ in range(draws)])
    X, Y = _from_motions(A[k], B[k], first, second, np.ones((draws, len(first))))
    return list(zip(X, Y, strict=True))


def _from_motions(
    A: Array, B: Array, first: NDArray[np.int64], second: NDArray[np.int64], w: Array
) -> Frames:
    """A_j^-1 A_i X = X B_j^-1 B_i for the motions from j to i, then the mean Y; in batches."""
    hand = lie.inverse(A[..., second, :, :]) @ A[..., first, :, :]
    eye = lie.inverse(B[..., second, :, :]) @ B[..., first, :, :]
    X = solve_ax_xb(hand, eye, w)
    return X, mean_transform(A @ X[..., None, :, :] @ lie.inverse(B), np.ones(A.shape[:-2]))


def _errors(A: Array, B: Array, X: Array, Y: Array) -> Array:
    """Position (m) and angle (rad) between A_i X and Y B_i, (2, n).

    Rotations that are an angle t apart differ by sqrt(8) sin(t / 2) in the Frobenius norm.
    """
    position = A[:, :3, :3] @ X[:3, 3] + A[:, :3, 3] - B[:, :3, 3] @ Y[:3, :3].T - Y[:3, 3]
    apart = (A[:, :3, :3] @ X[:3, :3] - Y[:3, :3] @ B[:, :3, :3]).reshape(len(A), 9)
    sine = np.sqrt(np.einsum("ni,ni->n", apart, apart) / 8)
    angle = 2 * np.arcsin(np.minimum(sine, 1.0))
    return np.stack([np.linalg.norm(position, axis=1), angle])
