"""Halves: do two parts of a recording, each fitted alone, say the same?

Each half takes one step from the common fit, x_h = -(A_h^T A_h + P)^-1 A_h^T z_h (P x is balanced
by both together and left out), with sampling variance V_h = C_h A_h^T A_h C_h. Their difference d
is weighed in the directions that both know, chi^2 = d^T (V_1 + V_2)^+ d, and shown where the robot
is to be right.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc

from bodyschema.trust.inflation import blocks_of_time, corners
from bodyschema.trust.scores import Scores

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

SAME_RANK = 1.0
"""Directions that halves of the postures may differ by in what they determine."""

TOLD = 0.5
"""Share of a direction's prior variance that must be gone for a half to know it."""


@dataclass(frozen=True)
class Halves:
    """Two parts of a recording."""

    words: str
    """How it was cut."""
    p_value: float
    """Chance of such a difference, were both of one robot."""
    difference: Array
    """(P,) between the variables of the two, in units of the prior."""


def halves(scores: Scores) -> list[Halves]:
    """First half against second, and either side of the widest joint's median."""
    time, posture = blocks_of_time(scores, 2) == 0, corners(scores, 1) == 0
    found = [compared(scores, time, "the first half of the recording and the second")]
    found.append(compared(scores, posture, "two halves of the workspace"))
    return [half for half in found if half is not None]


def compared(scores: Scores, one: Mask, words: str) -> Halves | None:
    """Two parts compared; None where they do not determine the same directions.

    Args:
        scores: of the fit to both.
        one: (n_samples,) the first part.
        words: how it was cut.
    """
    mine = one[scores.sample]
    if not len(scores.precision) or mine.all() or not mine.any():
        return None
    (x1, V1, known1), (x2, V2, known2) = (_alone(scores, part) for part in (mine, ~mine))
    if abs(known1 - known2) > SAME_RANK:
        return None
    d, V = x1 - x2, V1 + V2
    values, vectors = np.linalg.eigh(V)
    counts = values > max(values.max(initial=0.0), 1e-300) * 1e-9
    k = int(counts.sum())
    if not k:
        return None
    chi2 = float(np.sum((vectors[:, counts].T @ d) ** 2 / values[counts]))
    # The noise level was learnt from as many numbers as the fit had to spare.
    return Halves(words, float(fdtrc(k, scores.freedom, chi2 / k)), d)


def _alone(scores: Scores, part: Mask) -> tuple[Array, Array, float]:
    """Step, its sampling variance, and how many directions a part knows."""
    A = scores.A[part]
    S = A.T @ A
    C = np.linalg.pinv(S + np.diag(np.maximum(scores.precision, 1e-12)), hermitian=True)
    values = np.linalg.eigvalsh(S)
    known = float(np.sum(values / (values + 1) > TOLD))
    return -C @ (A.T @ scores.z[part]), C @ S @ C, known
