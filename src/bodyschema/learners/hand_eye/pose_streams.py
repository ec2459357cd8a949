"""Two streams of poses with clocks of their own, joined by a lag: t_hand = t_eye + lag.

A rigid body turns at one speed, whoever measures it: |omega| of the hand (in the base) and of the
eye (against its target) are the same function of time but for the lag. The first guess maximises
the correlation of both speeds. Then X, Y and the lag are refined together: with the residuals
r(X, Y, lag) of the pairs (`pose_pairs`), whitened by their noise S and weighted, and J their
derivatives by central differences in all thirteen,

    (sum w J^T S^-1 J) d = -sum w J^T S^-1 r

X and Y are solved for anew at the moved lag, and the lag's part of the inverse is its variance:
with X and Y held, a step of the lag would be too short and its error far too small, as a slow hand
that is late looks like one that is elsewhere.

Hand poses between two readings are interpolated along one screw-free arc (rotation vector and
translation separately); pairs in gaps of the hand's stream are left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.learners.hand_eye.full_poses import HandEye, Mount, solve_hand_eye

Array = NDArray[np.float64]

GRID = 0.01
"""s, of the resampled speeds."""

WINDOW = 0.1
"""s over which a speed is measured: single readings are too noisy."""

LARGEST_GAP = 0.2
"""s between readings of the hand, across which it is not interpolated."""

SOLVED_ON = 400
"""Pairs that each round solves; all of them would not say more."""

ROUNDS = 10

STEPS = np.array([*[1e-4] * 12, 5e-3])
"""m, rad and s: halves of the difference quotients."""


@dataclass(frozen=True)
class JoinedStreams:
    """Hand-eye calibration of two streams, and how their clocks differ."""

    hand_eye: HandEye
    lag: float
    """s: t_hand = t_eye + lag."""
    lag_std: float
    """s."""
    rows: NDArray[np.int64]
    """Readings of the eye that were used; `hand_eye.weights` belongs to them."""
    T_base_hand: Array
    """(n, 4, 4) hand poses at these readings."""


def join_streams(
    time_hand: ArrayLike,
    T_base_hand: ArrayLike,
    time_eye: ArrayLike,
    T_eye_target: ArrayLike,
    eye_on: Mount = "hand",
    free_scale: bool = False,
    largest_lag: float = 5.0,
) -> JoinedStreams:
    """Find lag, X and Y from two streams.

    Args:
        time_hand: (n,) s, increasing.
        T_base_hand: (n, 4, 4).
        time_eye: (m,) s, increasing.
        T_eye_target: (m, 4, 4).
        eye_on: whether the hand or the base carries the eye.
        free_scale: the eye's translations have one unknown scale.
        largest_lag: s; the search goes this far either way, after both streams were set to begin
            together if they do not overlap.

    Raises:
        InputError: times that do not increase, or streams without common motion.
    """
    t_hand, A = _stream(time_hand, T_base_hand, "hand")
    t_eye, T = _stream(time_eye, T_eye_target, "eye")
    base = 0.0 if _overlap(t_hand, t_eye) > WINDOW else float(t_hand[0] - t_eye[0])
    lag = base + _correlated_lag(t_hand, A, t_eye + base, T, largest_lag)
    rows = np.arange(len(t_eye))
    for _ in range(ROUNDS):
        rows = usable(t_hand, t_eye + lag)
        rows = rows[:: max(1, len(rows) // SOLVED_ON)]
        answer = solve_hand_eye(
            interpolate(t_hand, A, t_eye[rows] + lag), T[rows], eye_on, free_scale
        )
        step, std = _lag_step(answer, eye_on, t_hand, A, t_eye[rows] + lag, T[rows])
        lag += step
        if abs(step) < 0.05 * std:
            break
    there = interpolate(t_hand, A, t_eye[rows] + lag)
    answer = solve_hand_eye(there, T[rows], eye_on, free_scale)
    return JoinedStreams(answer, lag, std, rows, there)


def interpolate(time: Array, T: Array, at: Array) -> Array:
    """Poses between readings, (m, 4, 4); constant beyond the ends."""
    k = np.clip(np.searchsorted(time, at) - 1, 0, len(time) - 2)
    share = np.clip((at - time[k]) / (time[k + 1] - time[k]), 0.0, 1.0)
    R, p = T[k, :3, :3], T[k, :3, 3]
    turn = lie.log_so3(np.swapaxes(R, 1, 2) @ T[k + 1, :3, :3])
    rotation = R @ lie.exp_so3(share[:, None] * turn)
    return lie.transform(rotation, p + share[:, None] * (T[k + 1, :3, 3] - p))


def _stream(time: ArrayLike, poses: ArrayLike, name: str) -> tuple[Array, Array]:
    t, T = np.asarray(time, dtype=np.float64), np.asarray(poses, dtype=np.float64)
    if t.ndim != 1 or T.shape != (len(t), 4, 4):
        raise InputError(f"the {name}'s stream has times {t.shape} and poses {T.shape}.")
    back = np.flatnonzero(np.diff(t) <= 0)
    if len(back):
        raise InputError(
            f"the {name}'s time stamps do not increase at row {back[0] + 1}; drop the "
            f"{len(back)} repeated or backward rows."
        )
    return t, T


def _overlap(a: Array, b: Array) -> float:
    return float(min(a[-1], b[-1]) - max(a[0], b[0]))


def _speed(time: Array, T: Array, at: Array) -> Array:
    """Angular speed over a window round each moment, rad/s; 0 where nothing was read."""
    before = interpolate(time, T, at - WINDOW / 2)[:, :3, :3]
    after = interpolate(time, T, at + WINDOW / 2)[:, :3, :3]
    speed = np.linalg.norm(lie.log_so3(np.swapaxes(before, 1, 2) @ after), axis=1) / WINDOW
    inside = np.isin(np.arange(len(at)), usable(time, at))
    return np.where(inside, speed, 0.0)


def usable(time: Array, at: Array) -> NDArray[np.int64]:
    """Moments that lie between two readings of one piece."""
    k = np.clip(np.searchsorted(time, at) - 1, 0, len(time) - 2)
    inside = (at >= time[0]) & (at <= time[-1]) & (time[k + 1] - time[k] <= LARGEST_GAP)
    return np.flatnonzero(inside)


def _correlated_lag(t_hand: Array, A: Array, t_eye: Array, T: Array, largest: float) -> float:
    grid = np.arange(min(t_hand[0], t_eye[0]), max(t_hand[-1], t_eye[-1]), GRID)
    hand, eye = _speed(t_hand, A, grid), _speed(t_eye, T, grid)
    if hand.std() < 1e-6 or eye.std() < 1e-6:
        raise InputError("one of the streams does not turn; record motions that turn the hand.")
    # Gross outliers of a tracker would rule the correlation: cap speeds at a high quantile.
    hand = np.minimum(hand, np.quantile(hand, 0.99)) - hand.mean()
    eye = np.minimum(eye, np.quantile(eye, 0.95)) - eye.mean()
    size = 2 ** int(np.ceil(np.log2(2 * len(grid))))
    product = np.fft.irfft(np.fft.rfft(hand, size) * np.conj(np.fft.rfft(eye, size)), size)
    shifts = np.fft.fftfreq(size, 1 / size)
    allowed = np.abs(shifts) * GRID <= largest
    return float(shifts[np.argmax(np.where(allowed, product, -np.inf))] * GRID)


def _lag_step(
    answer: HandEye, eye_on: Mount, t_hand: Array, A: Array, at: Array, T: Array
) -> tuple[float, float]:
    """Gauss-Newton step of the lag together with X and Y, and its standard deviation, s."""
    seen = lie.inverse(T) if eye_on == "hand" else T
    L = np.linalg.cholesky(answer.noise)

    def whitened(step: Array) -> Array:
        """Residual where X and Y moved by twists in their own frames, and the lag by s."""
        X, Y = answer.X @ _moved(step[:6]), answer.Y @ _moved(step[6:12])
        P = lie.inverse(Y) @ interpolate(t_hand, A, at + step[12]) @ X
        turn = lie.log_so3(seen[:, :3, :3] @ np.swapaxes(P[:, :3, :3], 1, 2))
        r = np.concatenate([seen[:, :3, 3] - answer.scale * P[:, :3, 3], turn], axis=1)
        return np.asarray(np.linalg.solve(L, r.T).T)

    slopes = []
    for i, size in enumerate(STEPS):
        step = size * (np.arange(13) == i)
        slopes.append((whitened(step) - whitened(-step)) / (2 * size))
    J, w = np.stack(slopes, axis=2), answer.weights
    H = np.einsum("n,nij,nik->jk", w, J, J)
    # In units of the steps, so that metres, radians and seconds weigh alike.
    D = np.outer(STEPS, STEPS)
    inverse = np.linalg.inv(H * D + 1e-12 * np.diag(np.diag(H * D)) + 1e-30 * np.eye(13)) * D
    step = -inverse @ np.einsum("n,nij,ni->j", w, J, whitened(np.zeros(13)))
    return float(step[12]), float(np.sqrt(inverse[12, 12]))


def _moved(twist: Array) -> Array:
    """The transform of a small twist, (4, 4)."""
    return lie.transform(lie.exp_so3(twist[3:]), twist[:3])
