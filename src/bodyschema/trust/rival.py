"""Rival: something that is not in the model and might explain what the fit has left.

Let it change the residuals by Z gamma. To first order the best gamma beside the fitted variables is

    K = Z^T Z - Z^T A C A^T Z,    b = Z^T z,    gamma = -K^+ b,    gain = b^T K^+ b

and the gain, what |z|^2 would lose, is weighed by an F test (a score test: Rao 1948) with the
number of its family's candidates. Had it been in the model, the variables would have moved by

    dx = -C A^T Z gamma

so that the robot errs by J dx, and by the rival's own effect where that stays.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.special import betainc

from bodyschema.estimation.estimate import Estimate
from bodyschema.trust.scores import Scores
from bodyschema.trust.target import Target, length_95

Array = NDArray[np.float64]

SPARE = 20.0
"""Numbers left over beside a fit and a rival, below which nothing is said of it: levels and weights
were learnt from the same few."""

RANK = 1e-6
"""Share of a rival's own effect that the variables must leave of it to be seen at all."""


@dataclass(frozen=True)
class Rival:
    """A candidate of a family."""

    family: str
    """"lag", "frame moved", ...; candidates of one family share a Bonferroni factor."""
    words: str
    """What it says of the robot, with {} for its size."""
    unit: str
    """Of gamma, SI."""
    Z: Array
    """(N, k) its effect on the whitened residuals."""
    own: tuple[Array, ...] = ()
    """(n, 3, k) for each target: its effect there; empty if it passes."""
    passes: bool = False
    """Whether the robot is either before or after it, and the better of both counts."""


@dataclass(frozen=True)
class Weighed:
    """A rival beside the fit."""

    family: str
    says: str
    """In words, with its size."""
    gamma: Array
    """(k,) its size, SI."""
    share: float
    """Of the squared residuals that it explains."""
    p_value: float
    """Chance of such a gain without it, for the best of its family."""
    criterion: float
    """Gain in log likelihood less what its numbers and its candidates cost (Schwarz 1978)."""
    bias: float
    """m: 95 % of the error of the targets if it is true."""
    moved: Array = field(repr=False)
    """(P,) dx, in units of the prior."""


def weigh(rival: Rival, n_candidates: int, scores: Scores, B: Array) -> Weighed | None:
    """Test one rival; None where the variables leave nothing of it to be seen.

    Args:
        rival: with its effect.
        n_candidates: of its family.
        scores: of the fit.
        B: (N, P) A L with C = L L^T.
    """
    size = np.linalg.norm(rival.Z, axis=0)
    if not np.all(np.isfinite(size)) or not np.any(size > 0):
        return None
    scale = np.where(size > 0, size, 1.0)
    Z = rival.Z / scale
    V = B.T @ Z
    values, vectors = np.linalg.eigh(Z.T @ Z - V.T @ V)
    seen = values > RANK
    k = int(seen.sum())
    if not k or scores.freedom < k + SPARE:
        return None
    b = vectors[:, seen].T @ (Z.T @ scores.z)
    gain = min(float(np.sum(b**2 / values[seen])), (1 - 1e-12) * scores.squared)
    step = -vectors[:, seen] @ (b / values[seen])
    share, left = gain / scores.squared, scores.freedom - k
    # F of (k, left): its upper tail is an incomplete beta of the unexplained share.
    p = float(betainc(left / 2, k / 2, 1 - share))
    cost = 0.5 * k * np.log(scores.freedom) + np.log(n_candidates)
    return Weighed(
        rival.family,
        rival.words.format(_size(step / scale, rival.unit)),
        step / scale,
        share,
        min(p * n_candidates, 1.0),
        float(-0.5 * scores.freedom * np.log1p(-share) - cost),
        np.nan,
        -scores.root @ (V @ step),
    )


def bias(weighed: Weighed, rival: Rival, estimate: Estimate, targets: tuple[Target, ...]) -> float:
    """95 % of the error that a rival, if true, leaves at the targets; the largest, m."""
    found = []
    for i, target in enumerate(targets):
        J = target.slopes(estimate).by_parameter[:, :3] * estimate.variables.scale
        moved = J @ weighed.moved
        own = rival.own[i] @ weighed.gamma if rival.own else 0.0
        ways = [moved, moved + own] if rival.passes else [moved + own]
        found.append(min(length_95(way) for way in ways))
    return max(found, default=0.0)


def _size(gamma: Array, unit: str) -> str:
    """The size of a rival as people read it."""
    from bodyschema.units import read_as, significant

    scale, word = read_as(unit)
    value = scale * (float(gamma[0]) if len(gamma) == 1 else float(np.linalg.norm(gamma)))
    return f"{significant(value)} {word}".strip()
