"""What else might explain what a fit of pose pairs has left: rivals, as columns beside X and Y.

    eye moved       its mounting shifts from a row on
    target moved    the target slips from a row on
    drift           either of them goes slowly through the recording
    lag             hand and eye are not read at one moment: the hand's twist, where rows follow one
                    another closely enough to have one
    clock           of streams that a lag has joined, one clock runs faster
    scale           lengths that the eye measures are all too long by one share
    robot scale     the same of the robot's
    lens            what is seen off the middle of the view, or of what was seen, is shifted along
                    its radius by the third power of it
    field           the eye's error grows with the square of where it looks

Their tests are those of every other sense (`trust.rival`), on the rows of `pair_bars`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.estimation.estimate import Estimate
from bodyschema.learners.hand_eye.full_poses import HandEye
from bodyschema.learners.hand_eye.pair_bars import Linear
from bodyschema.learners.hand_eye.pose_pairs import REACH, carried
from bodyschema.senses.poses import Poses
from bodyschema.trust.families import cuts
from bodyschema.trust.rival import Rival
from bodyschema.trust.scores import Scores

Array = NDArray[np.float64]

SMOOTH = 0.5
"""Step of the hand from row to row, over that between rows at random, up to which rows follow one
another."""

FIELD_PAIRS = 12
"""Pairs from which a field of eighteen numbers is looked for."""


@dataclass(frozen=True)
class PairScores(Scores):
    """The rows of a fit of pairs, with a lag and a scale among its variables."""

    told: Array
    """(P,) information of the prior in units of `UNITS`."""

    @classmethod
    def beside(cls, problem: Linear, estimate: Estimate, sense: Poses) -> PairScores:
        """Of a linear problem.

        Args:
            problem: of the fit.
            estimate: that it is.
            sense: all pairs as given.
        """
        n, _, p = problem.J.shape
        some, units = sense.take(problem.row), scales(p)
        A = (problem.J * units).reshape(-1, p)
        told = np.diag(problem.prior) * units**2
        weights = (np.sqrt(problem.weights),)
        sample = np.repeat(np.arange(n), 6)
        return cls(estimate, (some,), weights, problem.z.ravel(), A, sample, problem.posture, told)

    @cached_property
    def precision(self) -> Array:
        """(P,)."""
        return self.told

    @cached_property
    def z(self) -> Array:
        """(N,): the fit is at rest."""
        return self.seen


def scales(size: int) -> Array:
    """Units of the variables, (size,): m and rad of X and of Y, then 1 of a scale, s of a lag."""
    return np.array([*[REACH] * 3, *[3.0] * 3, *[10 * REACH] * 3, *[3.0] * 3, 1.0, 1.0])[:size]


def families(found: HandEye, problem: Linear, streams: bool) -> Iterator[list[Rival]]:
    """All candidates, a list each family; `own` is empty, see `pose_trust`.

    Args:
        found: the answer.
        problem: the rows of its fit.
        streams: whether a lag was fitted.
    """
    J, n = problem.J, len(problem.z)
    ends = {"eye": 0, "target": 6} if found.eye_on == "hand" else {"target": 0, "eye": 6}
    clock = np.arange(n) / max(n - 1, 1) - 0.5
    for who, first in ends.items():
        mine = J[:, :, first : first + 6]
        moved = []
        for cut in cuts(n):
            says = f"the {who} moved at about row {problem.row[cut]}"
            moved.append(
                _rival(f"{who} moved", says, "", mine * (np.arange(n) >= cut)[:, None, None])
            )
        yield moved
        yield [_rival("drift", f"the {who} drifts through the recording", "",
                      mine * clock[:, None, None])]  # fmt: skip
    if streams:
        late = J[:, :, -1:] * clock[:, None, None]
        span = "one clock runs faster and gains {} in the recording"
        yield [_rival("clock", span, "s", late)]
    elif (twists := row_twists(problem.A)) is not None:
        late = J[:, :, :6] @ carried(twists, found.X)[..., None]
        says = "the eye's rows come {} rows after the hand's (before, if negative)"
        yield [_rival("lag", says, "", late)]
    yield from _sizes(found, problem)


def row_twists(A: Array) -> Array | None:
    """Twists a row of a hand whose rows follow one another, (n, 6); None where they do not."""
    if len(A) < 3:
        return None
    place = A[:, :3, 3], lie.log_so3(A[0, :3, :3].T @ A[:, :3, :3])
    near = [np.median(np.linalg.norm(np.diff(x, axis=0), axis=1)) for x in place]
    far = [np.median(np.linalg.norm(x - np.roll(x, len(x) // 2, axis=0), axis=1)) for x in place]
    if max(a / max(b, 1e-12) for a, b in zip(near, far, strict=True)) > SMOOTH:
        return None
    before, after = (
        np.maximum(np.arange(len(A)) - 1, 0),
        np.minimum(np.arange(len(A)) + 1, len(A) - 1),
    )
    step = lie.inverse(A[before]) @ A[after]
    twist = np.hstack([step[:, :3, 3], lie.log_so3(step[:, :3, :3])])
    return np.asarray(twist / (after - before)[:, None])


def _sizes(found: HandEye, problem: Linear) -> Iterator[list[Rival]]:
    P = lie.inverse(found.Y) @ problem.A @ found.X
    seen = lie.inverse(P) if found.eye_on == "hand" else P
    p = seen[:, :3, 3]
    if found.scale == 1:
        yield [_rival("scale", "the eye's lengths are {} too long", "1",
                      problem.whitened(_in_eye(found, seen, p[:, :, None])))]  # fmt: skip
    longer = np.zeros((len(p), 6))
    longer[:, :3] = np.einsum("nji,nj->ni", problem.A[:, :3, :3], problem.A[:, :3, 3])
    yield [_rival("robot scale", "the robot's lengths are {} too short", "1",
                  problem.J[:, :, :6] @ carried(longer, found.X)[..., None])]  # fmt: skip
    side = p * [1.0, 1.0, 0.0]
    off = p - p.mean(axis=0)
    bent = [v * np.sum((v / w) ** 2, axis=1, keepdims=True)
            for v, w in ((side, np.maximum(np.abs(p[:, 2:]), 1e-3)), (off, 1.0))]  # fmt: skip
    says = "the lens is bent otherwise than the camera's calibration says"
    yield [_rival("lens", says, "", problem.whitened(_in_eye(found, seen, b[..., None])))
           for b in bent]  # fmt: skip
    if len(p) < FIELD_PAIRS:
        return
    u = (p - p.mean(axis=0)) / max(float(np.ptp(p, axis=0).max()), 1e-12)
    squares = np.stack([u[:, a] * u[:, b] for a in range(3) for b in range(a, 3)], axis=1)
    curved = np.einsum("nm,dk->ndmk", squares, np.eye(3)).reshape(len(p), 3, -1)
    says = "the eye errs with where it looks, as a lens does"
    yield [_rival("field", says, "", problem.whitened(_in_eye(found, seen, curved)))]


def _in_eye(found: HandEye, seen: Array, effect: Array) -> Array:
    """An effect (n, 3, k) on positions seen, in the frame of the residual, (n, 6, k)."""
    # Residuals are those of T_eye_target, or of its inverse.
    if found.inverted != (found.eye_on == "hand"):
        effect = -np.swapaxes(seen[:, :3, :3], 1, 2) @ effect
    return np.concatenate([effect, np.zeros_like(effect)], axis=1)


def _rival(family: str, says: str, unit: str, Z: Array) -> Rival:
    return Rival(family, says, unit, Z.reshape(-1, Z.shape[2]))
