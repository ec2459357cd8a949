"""Frames for many hypotheses at once: how well each explains what was seen, whatever hangs where.

A hypothesis h is robot kinematics K_i = (R_i, k_i) and what was seen, points p_i or poses
(Q_i, p_i). With X the frame that looks and Y the frame that is seen, on their parents,

    R_i y + k_i = s R_X p_i + t_X        R_i R_Y = R_X Q_i        y the position of Y, s = 1

1. R_X from rotations alone: the leading pair of singular vectors of sum w Q_i x R_i (Shah 2013);
   and from positions alone: A p_i + t = R_i y + k_i is linear in A (3x3), t and y.
2. From both starts R_X, R_Y, y, t_X by turns, each in closed form, as one problem: a rotation that
   suits the rotations alone, or the positions alone, explains nothing.
3. The start that ends lower counts. Cauchy weights on the residuals hold off outliers all the way.

All arrays have the hypotheses first, so that a hundred cost little more than one.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from bodyschema.lie import nearest_rotation

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

ROBUST, TURNS = 4, 12
"""Rounds of weights in the linear starts, and of closed forms by turns."""

ROUGH = (2, 3)
"""The same where a start is only compared with its neighbours."""

PARAMETERS = 9.0
"""Of two frames, of which a point shows R_X, t_X and y; poses R_Y too, from their rotations."""

TINY = 1e-5
"""Of the spread: residuals below it are rounding, and are not compared."""

RANK = 1e-10
"""Eigenvalue, over the largest, below which a direction is not told."""


@dataclass(frozen=True)
class Batch:
    """What was seen at which kinematics, for h hypotheses of n samples."""

    K: Array
    """(h, n, 4, 4) between the parents of the two frames."""
    p: Array
    """(h, n, 3) m, positions seen."""
    Q: Array | None = None
    """(h, n, 3, 3) rotations seen; None for points."""
    use: Mask | None = None
    """(h, n) samples that the hypothesis has; all when None."""
    scaled: Mask | None = None
    """(h,) hypotheses whose s is free; none when None."""

    @property
    def used(self) -> Array:
        """(h, n) 1 for the samples that count."""
        return np.ones(self.p.shape[:2]) if self.use is None else self.use.astype(np.float64)

    def spread(self) -> tuple[Array, Array]:
        """Median distance from the middle of what was seen, (h,) m and (h,) rad."""
        w = self.used
        middle = np.nanmedian(np.where(w[..., None] > 0, self.p, np.nan), axis=1, keepdims=True)
        far = median(np.linalg.norm(self.p - middle, axis=2), w)
        if self.Q is None:
            return far, np.ones(len(far))
        mean = nearest_rotation(np.einsum("hn,hnij->hij", w, self.Q))
        return far, median(angle(self.Q, mean[:, None]), w)


@dataclass(frozen=True)
class FrameFits:
    """The frames of each hypothesis, and what they leave."""

    R_X: Array
    """(h, 3, 3)."""
    scale: Array
    """(h,) s; 1 where it was not free."""
    position: Array
    """(h,) median residual over median spread, as of a sample that the frames had not seen."""
    rotation: Array
    """(h,) the same of rotations; 1 for points."""
    posed: bool
    """Whether rotations were seen."""
    metres: Array
    """(h,) median residual of the positions, in the lengths that were seen."""
    radians: Array
    """(h,) that of the rotations."""
    axes: Array
    """(h, 3, 3) what turns the positions into the frame of the rotations, R_X^T A up to scale; of
    points 1 or -1 by the handedness of A."""

    @property
    def worst(self) -> Array:
        """(h,) the larger of both shares."""
        return np.maximum(self.position, self.rotation) if self.posed else self.position

    @property
    def score(self) -> Array:
        """(h,) log of the residuals' shares, summed; lower is better."""
        return np.asarray(np.log(self.position) + np.log(self.rotation))

    @classmethod
    def of(cls, batch: Batch) -> Self:
        """Fit the frames of every hypothesis."""
        w = batch.used
        A, _ = _linear(batch, w)
        starts = [nearest_rotation(A)]
        starts += [_aligned(batch, w)] if batch.Q is None else [_from_rotations(batch, w)[0]]
        ends = [_by_turns(batch, R, w) for R in starts]
        best = np.argmin([score for *_, score in ends], axis=0)
        far, turned = batch.spread()
        pick = np.arange(len(best))
        R_X, scale, e_p, e_r, _ = (np.stack(part)[best, pick] for part in zip(*ends, strict=True))
        n = w.sum(axis=1)
        blind = n / np.maximum(n - PARAMETERS / 3, 1.0)
        metres, radians = blind * e_p / scale, blind * e_r
        posed = batch.Q is not None
        turned = radians / np.maximum(turned, 1e-6) if posed else np.ones(len(n))
        return cls(
            R_X=R_X,
            scale=scale,
            position=np.maximum(metres / np.maximum(far, 1e-12), TINY),
            rotation=np.maximum(turned, TINY),
            posed=posed,
            metres=metres,
            radians=radians,
            axes=np.swapaxes(starts[1], 1, 2) @ A if posed else _handed(A),
        )


def rough_score(batch: Batch) -> Array:
    """Much like `FrameFits.score`, up to a constant, (h,), in a fifth of the time.

    Of poses the linear starts alone: positions and rotations may disagree about R_X, and A need be
    no rotation. Of points that leaves too much free, and a few turns follow.
    """
    w = batch.used
    A, left_over = _linear(batch, w, ROUGH[0])
    if batch.Q is None:
        return _by_turns(batch, nearest_rotation(A), w, ROUGH[1])[-1]
    _, errors = _from_rotations(batch, w)
    position = np.log(np.maximum(median(left_over, w), TINY))
    return np.asarray(position + np.log(np.maximum(median(errors, w), TINY)))


def angle(R: Array, S: Array) -> Array:
    """Angles between rotations (..., 3, 3), (...,) rad; exact near zero and near pi."""
    chord = np.sqrt(((R - S) ** 2).sum(axis=(-2, -1)))
    return np.asarray(2 * np.arcsin(np.minimum(chord / np.sqrt(8), 1.0)))


def median(values: Array, weights: Array) -> Array:
    """(h,) lower median of (h, n) values with weights above zero."""
    ordered = np.sort(np.where(weights > 0, values, np.inf), axis=1)
    count = np.maximum((weights > 0).sum(axis=1), 1)
    return np.asarray(np.take_along_axis(ordered, (count[:, None] - 1) // 2, axis=1)[:, 0])


def _handed(A: Array) -> Array:
    return np.where(np.linalg.det(A) < 0, -1.0, 1.0)[:, None, None] * np.eye(3)


def _cauchy(errors: Array, used: Array, least: Array) -> Array:
    """Weights 1 / (1 + (e / median e)^2), (h, n)."""
    middle = np.maximum(median(errors, used), least)
    return np.asarray(used / (1 + (errors / middle[:, None]) ** 2))


def _linear(batch: Batch, used: Array, rounds: int = ROBUST) -> tuple[Array, Array]:
    """A of A p + t = R y + k, (h, 3, 3) in m/m, by robust least squares of least norm.

    Also what is left of each sample over the size of the k, (h, n).
    """
    h, n = used.shape
    R, k = batch.K[..., :3, :3], batch.K[..., :3, 3]
    w = used / used.sum(axis=1, keepdims=True)
    p = batch.p - np.einsum("hn,hni->hi", w, batch.p)[:, None]
    k = k - np.einsum("hn,hni->hi", w, k)[:, None]
    size_p = np.sqrt(np.einsum("hn,hni->h", w, p**2)) + 1e-12
    size_k = np.sqrt(np.einsum("hn,hni->h", w, k**2)) + 1e-12
    D = np.zeros((h, n, 3, 15))
    for a in range(3):
        D[:, :, a, 3 * a : 3 * a + 3] = p / size_p[:, None, None]
        D[:, :, a, 9 + a] = 1
    D[..., 12:] = -R
    b = (k / size_k[:, None, None])[..., None]
    weights = used
    for _ in range(rounds):
        left = (D * np.sqrt(weights)[..., None, None]).reshape(h, 3 * n, 15)
        right = (b * np.sqrt(weights)[..., None, None]).reshape(h, 3 * n, 1)
        turned = np.swapaxes(left, 1, 2)
        z = _least_norm(turned @ left, turned @ right)
        errors = np.linalg.norm((D @ z[:, None] - b)[..., 0], axis=2)
        weights = _cauchy(errors, used, np.full(h, TINY))
    A: Array = z[:, :9, 0].reshape(h, 3, 3) * (size_k / size_p)[:, None, None]
    return A, errors


def _least_norm(N: Array, b: Array) -> Array:
    """The shortest solution of N x = b, N positive semidefinite, (h, m, m) and (h, m, 1)."""
    values, vectors = np.linalg.eigh(N)
    told = values > RANK * values[:, -1:]
    inverse = np.where(told, 1 / np.where(told, values, 1.0), 0.0)[..., None]
    return np.asarray(vectors @ (inverse * (np.swapaxes(vectors, 1, 2) @ b)))


def _from_rotations(batch: Batch, used: Array) -> tuple[Array, Array]:
    """R_X (h, 3, 3) from rotations alone, and their errors (h, n) rad."""
    assert batch.Q is not None
    h, n = used.shape
    R, Q = batch.K[..., :3, :3], batch.Q
    weights = used
    for _ in range(2):
        flat = np.swapaxes((weights[..., None, None] * Q).reshape(h, n, 9), 1, 2)
        entries = (flat @ R.reshape(h, n, 9)).reshape(h, 3, 3, 3, 3)
        U, _, Vt = np.linalg.svd(entries.transpose(0, 1, 3, 2, 4).reshape(h, 9, 9))
        R_X = np.swapaxes(U[:, :, 0].reshape(h, 3, 3), 1, 2)
        R_Y = np.swapaxes(Vt[:, 0].reshape(h, 3, 3), 1, 2)
        # The pair of vectors is known up to one common sign: rotations have determinant +1.
        sign = np.where(np.linalg.det(R_X) < 0, -1.0, 1.0)[:, None, None]
        R_X, R_Y = nearest_rotation(sign * R_X), nearest_rotation(sign * R_Y)
        errors = angle(R @ R_Y[:, None], R_X[:, None] @ Q)
        weights = _cauchy(errors, used, np.full(h, TINY))
    return R_X, errors


def _aligned(batch: Batch, used: Array) -> Array:
    """R_X (h, 3, 3) of a point in the origin of its link."""
    w = used / used.sum(axis=1, keepdims=True)
    p = batch.p - np.einsum("hn,hni->hi", w, batch.p)[:, None]
    return nearest_rotation(np.einsum("hn,hni,hnj->hij", w, batch.K[..., :3, 3], p))


def _by_turns(
    batch: Batch, R_X: Array, used: Array, turns: int = TURNS
) -> tuple[Array, Array, Array, Array, Array]:
    """R_X, s, median position and rotation residuals (h,), and the score, from a start of R_X."""
    R, k, p, Q = batch.K[..., :3, :3], batch.K[..., :3, 3], batch.p, batch.Q
    Rt = np.swapaxes(R, -1, -2)
    h = len(p)
    s, free = np.ones(h), batch.scaled
    far, _ = batch.spread()
    reach = median(np.linalg.norm(k - k.mean(axis=1, keepdims=True), axis=2), used)
    least = TINY * np.maximum(far, reach) + 1e-12
    weights, s_r, e_r = used, np.ones(h), np.zeros_like(used)
    for _ in range(turns):
        w = weights / weights.sum(axis=1, keepdims=True)
        f = p @ np.swapaxes(R_X, 1, 2)
        if free is not None:
            s = np.where(free, _scale(R, k, f, w), 1.0)
        b = s[:, None, None] * f - k
        mean_R, mean_b = np.einsum("hn,hnij->hij", w, R), np.einsum("hn,hni->hi", w, b)
        back = np.einsum("hn,hni->hi", w, (Rt @ b[..., None])[..., 0])
        square = np.eye(3) - np.swapaxes(mean_R, 1, 2) @ mean_R
        y = _least_norm(square, (back - np.einsum("hji,hj->hi", mean_R, mean_b))[..., None])
        there = (R @ y[:, None])[..., 0]
        t_X = (mean_R @ y)[..., 0] - mean_b
        e_p = np.linalg.norm(there - t_X[:, None] - b, axis=2)
        s_p = np.maximum(median(e_p, used), least)
        total = (e_p / s_p[:, None]) ** 2
        if Q is not None:
            facing = R_X[:, None] @ Q
            R_Y = nearest_rotation(np.einsum("hn,hnij->hij", w, Rt @ facing))
            hand = R @ R_Y[:, None]
            e_r = angle(hand, facing)
            s_r = np.maximum(median(e_r, used), TINY)
            total = (total + (e_r / s_r[:, None]) ** 2) / 2
        weights = used / (1 + total)
        w = weights / weights.sum(axis=1, keepdims=True)
        goal = there + k
        goal = goal - np.einsum("hn,hni->hi", w, goal)[:, None]
        shifted = p - np.einsum("hn,hni->hi", w, p)[:, None]
        M = np.swapaxes(goal * w[..., None], 1, 2) @ shifted * (s / s_p**2)[:, None, None]
        if Q is not None:
            M += np.einsum("hn,hnij->hij", w, hand @ np.swapaxes(Q, 2, 3)) / (s_r**2)[:, None, None]
        R_X = nearest_rotation(M)
    middle = median(e_p, used)
    turn = median(e_r, used)
    score = np.log(middle / s + 1e-12) + (np.log(turn + 1e-9) if Q is not None else 0.0)
    return R_X, s, middle, turn, score


def _scale(R: Array, k: Array, f: Array, w: Array) -> Array:
    """s of R y + k = s f + t, (h,), with y and t free; at least a millionth of the sizes' ratio."""
    C = np.concatenate([R, -f[..., None]], axis=3)
    mean_C, mean_k = np.einsum("hn,hnij->hij", w, C), np.einsum("hn,hni->hi", w, k)
    C, k = C - mean_C[:, None], k - mean_k[:, None]
    size = np.sqrt(np.einsum("hn,hni->h", w, C[..., 3] ** 2)) + 1e-12
    C[..., 3] /= size[:, None, None]
    left = (C * np.sqrt(w)[..., None, None]).reshape(len(w), -1, 4)
    right = (k * np.sqrt(w)[..., None]).reshape(len(w), -1, 1)
    turned = np.swapaxes(left, 1, 2)
    z = _least_norm(turned @ left, -turned @ right)[:, 3, 0] / size
    reach = np.sqrt(np.einsum("hn,hni->h", w, k**2))
    return np.asarray(np.maximum(z, 1e-6 * reach / size))
