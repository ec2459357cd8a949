"""Two streams of poses with clocks of their own, joined by a lag: t_hand = t_eye + lag.

`lag_search` finds the lags that make both turn by the same angles; from each of them X, Y and the
lag are fitted together (`pose_pairs`), and the likeliest fit is the answer. Its covariance is that
of all thirteen: with the frames held, the lag's error would be far too small, since a slow hand
that is late looks like one that is elsewhere. What hangs together in time widens the lag's error as
it does that of the frames (`pair_bars`).

Hand poses between two readings are interpolated along one screw-free arc (rotation vector and
translation separately); pairs in gaps of the hand's stream are left out.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.learners.hand_eye.full_poses import (
    HandEye,
    Mount,
    answered,
    check_turning,
    likeliest,
)
from bodyschema.learners.hand_eye.lag_search import APART, likely_lags
from bodyschema.learners.hand_eye.pair_bars import kappa
from bodyschema.learners.hand_eye.pose_pairs import PairFit
from bodyschema.learners.hand_eye.stamps import check_stamps
from bodyschema.seeds.pair_starts import pair_starts

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

LARGEST_GAP = 0.2
"""s between readings of the hand, across which it is not interpolated."""

SOLVED_ON, SEARCHED_ON = 400, 150
"""Pairs that the answer and the choice between lags are fitted to, up to twice as many; all would
not say more."""

ROUNDS = 4
"""Fits at most, each to the pairs that the lag of the one before shares with the hand."""

HALF_WINDOW = 0.02
"""s before and after a moment, between which the hand's twist is taken."""

FEWEST_JOINED = 10
"""Readings of the eye within the hand's stream: thirteen numbers are wanted, and a lag shows in
what the others leave."""

SETTLED = 1e-4
"""s that the last fit may move the lag."""

AS_GOOD = 15.0
"""Logarithm of the likelihood, over `SEARCHED_ON` pairs, by which a lag must beat the others to be
the only one."""


@dataclass(frozen=True)
class JoinedStreams:
    """Hand-eye calibration of two streams, and how their clocks differ."""

    hand_eye: HandEye
    lag: float
    """s: t_hand = t_eye + lag."""
    lag_std: float
    """s, of the fit of lag and frames together."""
    rows: Ints
    """Readings of the eye that were used; `hand_eye.weights` belongs to them."""
    T_base_hand: Array
    """(n, 4, 4) hand poses at these readings."""
    twists: Array = field(default_factory=lambda: np.zeros((0, 6)))
    """(n, 6) m/s and rad/s of the hand at these readings, in its own frame."""
    other_lags: tuple[float, ...] = ()
    """s: other lags that explain the streams as well, as in motion that repeats itself."""
    at_edge: bool = False
    """Whether the lag lies where the search ended."""


@dataclass(frozen=True)
class Path:
    """A stream of hand poses."""

    time: Array
    """(n,) s, increasing."""
    T: Array
    """(n, 4, 4)."""

    def rotations(self, at: Array) -> Array:
        """(m, 3, 3); nan where it was not read."""
        R = np.full((len(at), 3, 3), np.nan)
        inside = usable(self.time, at)
        R[inside] = interpolate(self.time, self.T, at[inside])[:, :3, :3]
        return R

    def moving(self, at: Array) -> tuple[Array, Array]:
        """Poses (m, 4, 4), and twists a second in the hand's own frame, (m, 6)."""
        times = np.concatenate([at, at - HALF_WINDOW, at + HALF_WINDOW])
        here, *ends = interpolate(self.time, self.T, times).reshape(3, -1, 4, 4)
        before, after = (lie.inverse(here) @ end for end in ends)
        turn = lie.log_so3(np.swapaxes(before[:, :3, :3], 1, 2) @ after[:, :3, :3])
        twist = np.hstack([after[:, :3, 3] - before[:, :3, 3], turn])
        return here, twist / (2 * HALF_WINDOW)


def join_streams(
    time_hand: ArrayLike,
    T_base_hand: ArrayLike,
    time_eye: ArrayLike,
    T_eye_target: ArrayLike,
    eye_on: Mount = "hand",
    free_scale: bool | None = False,
    largest_lag: float = 5.0,
    accepted_std: float = 0.05,
    seed: int = 0,
) -> JoinedStreams:
    """Find lag, X and Y from two streams.

    Args:
        time_hand: (n,) s, increasing.
        T_base_hand: (n, 4, 4).
        time_eye: (m,) s, increasing.
        T_eye_target: (m, 4, 4).
        eye_on: whether the hand or the base carries the eye.
        free_scale: the eye's translations have one unknown scale; decided by the data when None.
        largest_lag: s; the search goes this far either way, after both streams were set to begin
            together if they do not overlap.
        accepted_std: m; above it the eye's place counts as not determined.
        seed: of the random starts.

    Raises:
        InputError: times that do not increase or are in another unit, or streams without common
            motion.
    """
    path = Path(*_stream(time_hand, T_base_hand, "hand"))
    t, T = _stream(time_eye, T_eye_target, "eye")
    check_stamps(path.time, t)
    check_turning(path.T)
    both = _Streams(path, t, T, eye_on, free_scale, seed)
    middle = 0.0 if _overlap(path.time, t) > LARGEST_GAP else float(path.time[0] - t[0])
    lags = likely_lags(path.rotations, t, T[:, :3, :3], middle, largest_lag, seed)
    tried = [one for lag in lags if (one := both.tried(lag)) is not None]
    if not tried:
        raise InputError(
            f"the streams share no motion at any lag within {largest_lag:g} s; look whether they "
            "are of one recording, and record motions that turn the hand."
        )
    best = max(tried, key=_each)
    as_good = {f.lag for f, n in tried if SEARCHED_ON * (_each(best) - _each((f, n))) < AS_GOOD}
    others = tuple(sorted(lag for lag in as_good if abs(lag - best[0].lag) > APART))
    edge = abs(best[0].lag - middle) > largest_lag - APART
    return both.joined(best[0].lag, accepted_std, others, edge)


@dataclass(frozen=True)
class _Streams:
    """Both, and how they are fitted."""

    path: Path
    time: Array
    T: Array
    eye_on: Mount
    free_scale: bool | None
    seed: int
    starts: int = 3

    def tried(self, lag: float) -> tuple[PairFit, Ints] | None:
        """A fit from one start alone, without a scale of its own: enough to choose a lag by."""
        return replace(self, free_scale=False, starts=1).fitted(lag, SEARCHED_ON)

    def fitted(self, lag: float, count: int) -> tuple[PairFit, Ints] | None:
        """Lag, X and Y from so many pairs and a first lag, and the rows; None if too few."""
        rows = usable(self.path.time, self.time + lag)
        if len(rows) < FEWEST_JOINED:
            return None
        rows = rows[:: max(1, len(rows) // count)]
        A, B = self.path.moving(self.time[rows] + lag)[0], self.seen(rows)

        def moving(at: float) -> tuple[Array, Array]:
            return self.path.moving(self.time[rows] + at)

        starts = pair_starts(A, B, self.seed)[: self.starts]
        return likeliest(A, B, starts, self.free_scale, moving, lag), rows

    def seen(self, rows: Ints) -> Array:
        """B of `pose_pairs`, (n, 4, 4)."""
        T = self.T[rows]
        return np.asarray(lie.inverse(T)) if self.eye_on == "hand" else T

    def joined(
        self, lag: float, accepted_std: float, others: tuple[float, ...], edge: bool
    ) -> JoinedStreams:
        """The answer from a lag that is nearly right."""
        for _ in range(ROUNDS):
            found = self.fitted(lag, SOLVED_ON)
            if found is None:
                raise InputError(
                    f"at the lag of {lag:.3g} s the streams share fewer than {FEWEST_JOINED} "
                    "moments; record both for longer."
                )
            fit, rows = found
            settled, lag = abs(fit.lag - lag) < SETTLED, fit.lag
            if settled:
                break
        A, twists = self.path.moving(self.time[rows] + lag)
        answer, problem = answered(fit, A, self.seen(rows), self.eye_on, accepted_std, twists)
        wanted = np.eye(len(fit.information))[-1:]
        std = float(np.sqrt(kappa(problem, wanted) * problem.covariance[-1, -1]))
        return JoinedStreams(answer, lag, std, rows, A, twists, others, edge)


def _each(fitted: tuple[PairFit, Ints]) -> float:
    """Logarithm of the likelihood of a pair."""
    fit, rows = fitted
    return fit.likelihood / len(rows)


def interpolate(time: Array, T: Array, at: Array) -> Array:
    """Poses between readings, (m, 4, 4); constant beyond the ends."""
    k = np.clip(np.searchsorted(time, at) - 1, 0, len(time) - 2)
    share = np.clip((at - time[k]) / (time[k + 1] - time[k]), 0.0, 1.0)
    R, p = T[k, :3, :3], T[k, :3, 3]
    turn = lie.log_so3(np.swapaxes(R, 1, 2) @ T[k + 1, :3, :3])
    rotation = R @ lie.exp_so3(share[:, None] * turn)
    return lie.transform(rotation, p + share[:, None] * (T[k + 1, :3, 3] - p))


def usable(time: Array, at: Array) -> Ints:
    """Moments that lie between two readings of one piece."""
    k = np.clip(np.searchsorted(time, at) - 1, 0, len(time) - 2)
    inside = (at >= time[0]) & (at <= time[-1]) & (time[k + 1] - time[k] <= LARGEST_GAP)
    return np.flatnonzero(inside)


def _stream(time: ArrayLike, poses: ArrayLike, name: str) -> tuple[Array, Array]:
    t, T = np.asarray(time, dtype=np.float64), lie.matrices(poses)
    if t.ndim != 1 or T.shape != (len(t), 4, 4):
        raise InputError(f"the {name}'s stream has times {t.shape} and poses {T.shape}.")
    if len(t) < FEWEST_JOINED:
        raise InputError(
            f"the {name}'s stream has {len(t)} readings; a lag needs {FEWEST_JOINED} at least."
        )
    back = np.flatnonzero(np.diff(t) <= 0)
    if len(back):
        raise InputError(
            f"the {name}'s time stamps do not increase at row {back[0] + 1}; drop the "
            f"{len(back)} repeated or backward rows."
        )
    return t, T


def _overlap(a: Array, b: Array) -> float:
    return float(min(a[-1], b[-1]) - max(a[0], b[0]))
