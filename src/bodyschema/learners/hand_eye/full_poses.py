"""Hand-eye calibration from full poses, without a robot model.

    eye on the hand    T_base_hand X = Y T_target_eye          X = T_hand_eye,    Y = T_base_target
    eye on the base    T_base_hand X = Y T_eye_target          X = T_hand_target, Y = T_base_eye

Both are A_i X = Y B_i: starts from random fours of pairs (`pair_starts`), then the likeliest of the
fits that `pose_pairs` refines from them. Streams with clocks of their own are `pose_streams`.

The eye's lengths may have a scale of their own: a single moving camera has no other, and a target
printed in another size than was said looks like one. It is free where that raises the logarithm of
the likelihood by more than half the logarithm of the numbers seen (Schwarz 1978) and `MARGIN`.

Copies of a pair count once, and what hangs together or is few widens the covariance (`pair_bars`).

What is wanted is the place of the eye: X where the hand carries it, Y where the base does. Motions
that all turn about one axis leave its translation along that axis open. The covariance says so, and
where its largest standard deviation exceeds what the caller accepts, the answer names the axis and
is not to be trusted.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.estimation.prediction import length_quantile
from bodyschema.learners.hand_eye import pose_pairs
from bodyschema.learners.hand_eye.pair_bars import Linear, freedom, kappa, linear, postures
from bodyschema.learners.hand_eye.pose_pairs import REACH, Moving, PairFit, refine, residual
from bodyschema.seeds.pair_starts import Frames, pair_starts
from bodyschema.threads import one_thread

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Mount = Literal["hand", "base"]

FEWEST_PAIRS = 3
MARGIN = 10.0
"""What a scale must gain beyond the criterion: noise is never quite what the fit takes it for."""

FEWEST_SCALED = 10
"""Pairs from which a scale is looked for: fewer leave too little to judge the noise by."""

ONE_AXIS = 0.05
"""Share of turning about other axes below which all turns are about one."""

LEAST_TURN = 0.01
"""rad: poses that turn less than this from each other show nothing of where the eye is."""


@dataclass(frozen=True)
class HandEye:
    """Where the eye is, and how sure that is."""

    X: Array
    """(4, 4) T_hand_eye, or T_hand_target for an eye on the base."""
    Y: Array
    """(4, 4) T_base_target, or T_base_eye."""
    covariance: Array
    """(12, 12) of the twists (linear, angular) of X in its own frame, then of Y in its own; widened
    by what hangs together in the residuals, and for a noise that was learned from few postures."""
    scale: float
    """Measured over metric translations; 1 unless it was free."""
    noise: Array
    """(6, 6) covariance of a good pair's residual: position m, rotation rad."""
    weights: Array
    """(n,) probability of each pair to be good."""
    uncertain_axis: Array
    """(3,) unit, in the frame that carries the eye: where its translation is known least."""
    largest_std: float
    """m, along that axis."""
    accepted_std: float
    """m, what the caller accepts."""
    eye_on: Mount = "hand"
    """What carries the eye."""
    second_turn: float = 1.0
    """Turning about other axes than the first one, as a share of that about it."""
    predicted_95: float = float("nan")
    """m: error that the place of the eye stays below with 95 %, by this covariance."""
    postures: int = 0
    """Of the hand, each counted once."""
    widened: float = 1.0
    """Standard deviations over those of independent noise: root of kappa in `pair_bars`."""
    inverted: bool = False
    """Whether the noise is that of the inverse of B; see `pose_pairs`."""
    problem: Linear | None = field(default=None, repr=False, compare=False)
    """The rows of the fit."""

    @property
    def determined(self) -> bool:
        """Whether the poses say where the eye is, in every direction."""
        return self.largest_std <= self.accepted_std

    @property
    def verdict(self) -> str:
        """One sentence for people, with the motion that would help."""
        size = f"{1e3 * self.largest_std:.2g} mm"
        if self.determined:
            scaled = (
                "" if self.scale == 1 else f"; the eye's lengths are {self.scale:.4g} times true"
            )
            return f"the translation is known to {size} or better in every direction{scaled}."
        axis = ", ".join(f"{part:+.2f}" for part in self.uncertain_axis)
        open_axis = f"the translation along ({axis}) of the {self.eye_on} is not determined"
        if self.second_turn < ONE_AXIS:
            return (
                f"{open_axis} (std {size}): the hand hardly turned about any other axis; record "
                "poses that tilt across this axis too."
            )
        noise = f"{1e3 * float(np.sqrt(np.trace(self.noise[:3, :3]))):.2g} mm"
        return (
            f"{open_axis} (std {size}): the poses agree to {noise} only; record more that turn "
            "farther, or look whether they are declared as they were recorded."
        )


@one_thread
def solve_hand_eye(
    T_base_hand: ArrayLike,
    T_eye_target: ArrayLike,
    eye_on: Mount = "hand",
    free_scale: bool | None = None,
    accepted_std: float = 0.05,
    seed: int = 0,
) -> HandEye:
    """Solve A X = Y B for pose pairs, some of which may be wrong.

    Args:
        T_base_hand: (n, 4, 4) from the robot.
        T_eye_target: (n, 4, 4) from the eye, one for each.
        eye_on: whether the hand or the base carries the eye.
        free_scale: the eye's translations have one unknown scale; decided by the data when None.
        accepted_std: m; above it the translation counts as not determined.
        seed: of the random starts.

    Raises:
        InputError: too few pairs, arrays that do not match, or poses that do not turn.
    """
    A, T = _poses(T_base_hand, "T_base_hand"), _poses(T_eye_target, "T_eye_target")
    if len(A) != len(T):
        raise InputError(f"there are {len(A)} hand poses and {len(T)} target poses; pair them.")
    if len(A) < FEWEST_PAIRS:
        raise InputError(f"{len(A)} pose pairs cannot fix two frames; record at least 10.")
    check_turning(A)
    _check_postures(A)
    first, copy = _distinct(A, T)
    A, T = A[first], T[first]
    B = lie.inverse(T) if eye_on == "hand" else T
    fit, u = _by_worth(A, B, pair_starts(A, B, seed), free_scale)
    found, problem = answered(fit, A, B, eye_on, accepted_std, worth=u)
    return replace(found, weights=found.weights[copy], problem=replace(problem, row=first))


def check_turning(A: Array) -> None:
    """Refuse poses of a hand (n, 4, 4) that hardly turn.

    Raises:
        InputError: with the turn.
    """
    turns = np.linalg.norm(lie.log_so3(A[0, :3, :3].T @ A[:, :3, :3]), axis=1)
    if turns.max() < LEAST_TURN:
        raise InputError(
            f"the hand turns by {np.rad2deg(turns.max()):.2g} deg at most: without turning, the "
            "place of the eye cannot be seen; record poses that turn about two axes."
        )


def _check_postures(A: Array) -> None:
    count = int(postures(A).max()) + 1
    if count < FEWEST_PAIRS:
        raise InputError(
            f"{len(A)} pose pairs show {count} postures of the hand, and repeats tell nothing new: "
            "two frames need three at the very least; record 10 or more."
        )


def likeliest(
    A: Array,
    B: Array,
    starts: list[Frames],
    free_scale: bool | None,
    moving: Moving | None = None,
    lag: float = 0.0,
    worth: Array | None = None,
) -> PairFit:
    """The likeliest fit, with a scale where it is wanted or, when None, where the data ask for it.

    Args:
        A: (n, 4, 4) poses of the hand.
        B: (n, 4, 4) poses seen.
        starts: X and Y.
        free_scale: the eye's translations have one unknown scale.
        moving: A at any lag, to fit that too.
        lag: s, start.
        worth: (n,) of each pair, in independent ones; 1 when None.
    """
    tried: tuple[bool, ...] = (False, True) if len(A) >= FEWEST_SCALED else (False,)
    tried = tried if free_scale is None else (free_scale,)
    fits = []
    for free in tried:
        refined = [
            refine(A, B, X, Y, inverted, free, moving, lag, worth)
            for X, Y in starts
            for inverted in (False, True)
        ]
        fits.append(max(refined, key=lambda fit: fit.likelihood))
    gain = fits[-1].likelihood - fits[0].likelihood
    return fits[-1] if gain > 0.5 * np.log(6 * len(A)) + MARGIN else fits[0]


def _by_worth(
    A: Array, B: Array, starts: list[Frames], free_scale: bool | None
) -> tuple[PairFit, Array]:
    """The likeliest fit with pairs of one posture counted for what they are worth, and that."""
    fit, posture = likeliest(A, B, starts, free_scale), postures(A)
    if int(posture.max()) + 1 == len(A):
        return fit, np.ones(len(A))
    u = pose_pairs.worth(residual(A, B, fit)[0], fit.weights, posture)
    starts = [(fit.X, fit.Y), *starts]
    return likeliest(A, B, starts, free_scale, worth=u), u


def _distinct(A: Array, T: Array) -> tuple[Ints, Ints]:
    """First row of each different pair, in order, and for each row its place among these."""
    both = np.hstack([A.reshape(-1, 16), T.reshape(-1, 16)])
    _, first, copy = np.unique(both, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    return first[order], np.argsort(order)[copy.ravel()]


def _poses(values: ArrayLike, name: str) -> Array:
    T = lie.matrices(values)
    if T.ndim != 3 or T.shape[1:] != (4, 4):
        raise InputError(f"{name} should have shape (n, 4, 4), it has {T.shape}.")
    bad = np.flatnonzero(~np.isfinite(T).all(axis=(1, 2)))
    if len(bad):
        raise InputError(f"{name} is not finite in row {bad[0]}; drop the {len(bad)} bad rows.")
    return T


def _second_turn(A: Array) -> float:
    """How much less the hand turned about the second axis than about the first: 0 to 1."""
    turns = lie.log_so3(A[0, :3, :3].T @ A[:, :3, :3])
    sizes = np.linalg.svd(turns, compute_uv=False)
    return float(sizes[1] / max(sizes[0], 1e-300))


def answered(
    fit: PairFit,
    A: Array,
    B: Array,
    eye_on: Mount,
    accepted_std: float,
    twists: Array | None = None,
    worth: Array | None = None,
) -> tuple[HandEye, Linear]:
    """The answer that a fit is, with honest bars, and the linear problem near it.

    Args:
        fit: of these pairs.
        A: (n, 4, 4) poses of the hand.
        B: (n, 4, 4) poses seen.
        eye_on: what carries the eye.
        accepted_std: m.
        twists: (n, 6) of the hand a second, where the lag was fitted.
        worth: (n,) of each pair, in independent ones; 1 when None.
    """
    size = len(fit.information)
    prior = np.full(size, 1e-9)
    prior[:3] += REACH**-2
    # Y follows X where the poses leave both open; a weak prior keeps the inverse finite.
    prior[6:9] += (10 * REACH) ** -2
    free_scale = size > 12 + (twists is not None)
    problem = linear(A, B, fit, free_scale, twists, np.diag(prior), worth)
    eye, first = (fit.X, 0) if eye_on == "hand" else (fit.Y, 6)
    rotation, mine = eye[:3, :3], slice(first, first + 3)
    wide, nu = kappa(problem, np.eye(size)[mine]), freedom(fit.weights, problem.posture)
    # With a noise from few postures errors are Student's, of variance nu / (nu - 2).
    covariance = wide * problem.covariance[:12, :12]
    known = covariance * max(nu / max(nu - 2, 1.0), 1.0)
    values, vectors = np.linalg.eigh(rotation @ known[mine, mine] @ rotation.T)
    axis = vectors[:, -1] * np.sign(vectors[np.argmax(np.abs(vectors[:, -1])), -1])
    answer = HandEye(
        fit.X,
        fit.Y,
        known,
        fit.scale,
        fit.noise,
        fit.weights,
        axis,
        float(np.sqrt(values[-1])),
        accepted_std,
        eye_on,
        _second_turn(A),
        length_quantile([covariance[mine, mine]], nu, 0.95),
        int(problem.posture.max()) + 1,
        float(np.sqrt(wide)),
        fit.inverted,
        problem,
    )
    return answer, problem
