"""Did a named part of the body change a moment ago? A running test on what surprised the learner.

A change of candidate c by d, in its own parameters, shifts the whitened residual of every sample
from then on by J_c d. Over the w newest samples, with clipped innovations v,

    score         s_c = sum J_c^T v,         v = u min(1, k / |u|)
    information   F_c = sum J_c^T J_c + Q_c^-1,     Q_c the covariance of likely changes
    statistic     T_c = s_c^T F_c^-1 s_c,    about chi-square, a degree for each parameter of c

For a link, J_c is a rotation over the noise and T_c = |sum R^T u|^2 / w: a change of the link is a
constant in the link's own frame (Hersch, Sauser and Billard 2008, Eq. 14), however the robot moves,
and outliers are not. The clip keeps a few of them from looking like a change. The largest T_c over
all windows of 2 to 31 samples is compared with the chi-square quantile of a stated chance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from bodyschema.errors import InputError, did_you_mean
from bodyschema.learners.smoother import Foresight
from bodyschema.model.variables import Variables

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

CLIP = 3.0
"""k: length beyond which an innovation counts no more, in standard deviations."""

SHORTEST, LONGEST = 2, 31
"""Samples in the windows."""


@dataclass(frozen=True)
class Candidate:
    """A part of the body that may change as one."""

    name: str
    members: tuple[str, ...]
    """Names of its parameters, which must be among those that are learnt."""
    spread: float
    """Standard deviation of a likely change of each parameter, in its unit (m, rad)."""
    odds: float = 1.0
    """How often this part changes, relative to the others: tools more often than upper arms."""

    def rows(self, variables: Variables) -> list[int]:
        """Rows of the members among the parameters.

        Raises:
            InputError: a member is not among them.
        """
        for member in self.members:
            if member not in variables.names:
                raise InputError(
                    f"candidate '{self.name}' has the parameter '{member}', which is not learnt"
                    f"{did_you_mean(member, variables.names)}"
                )
        return [variables.names.index(member) for member in self.members]


@dataclass(frozen=True)
class Sums:
    """State of the test: sums over the newest 1, 2, ... LONGEST samples, in units of the spread."""

    scores: Array
    """(n_windows, n_candidates, k) with k the most parameters of any candidate; zeros fill up."""
    information: Array
    """(n_windows, n_candidates, k, k)."""


@dataclass(frozen=True)
class Finding:
    """The most unlikely window of any candidate."""

    ratio: float
    """Its statistic over the alarm level; 1 or more is an alarm."""
    candidate: int
    window: int
    """Number of samples since the change."""


@dataclass(frozen=True)
class InnovationTest:
    """A running test for changes of candidates, with a stated chance."""

    rows: Ints
    """(n_candidates, k) of their parameters; -1 fills up."""
    spread: Array
    """(n_candidates, k); zero fills up."""
    level: Array
    """(n_candidates,) statistic at which the alarm goes off."""

    @classmethod
    def of(
        cls, candidates: Sequence[Candidate], variables: Variables, chance: float
    ) -> InnovationTest:
        """Build from candidates.

        Args:
            candidates: what may change.
            variables: what is learnt.
            chance: of a statistic above the level, in one window, with normal noise and no change;
                the candidates share it by their odds, so that what changes often is noticed soon.
        """
        members = [candidate.rows(variables) for candidate in candidates]
        width = max(map(len, members))
        rows = [[*group, *[-1] * (width - len(group))] for group in members]
        spread = np.array([[c.spread] * width for c in candidates]) * (np.array(rows) >= 0)
        total = sum(candidate.odds for candidate in candidates)
        level = [
            float(chi2.isf(chance * candidate.odds / total, len(group)))
            for candidate, group in zip(candidates, members, strict=True)
        ]
        return cls(np.array(rows, dtype=np.int64), spread, np.array(level))

    def start(self) -> Sums:
        """Before the first sample."""
        m, k = self.rows.shape
        return Sums(np.zeros((0, m, k)), np.zeros((0, m, k, k)))

    def step(self, state: Sums, seen: Foresight) -> tuple[Sums, Finding]:
        """The sums with one more sample, and the most unlikely window."""
        u = seen.innovation
        v = u * min(1.0, CLIP / max(float(np.linalg.norm(u)), CLIP))
        J = seen.jacobian[:, self.rows] * self.spread
        score = np.einsum("dck,d->ck", J, v)
        told = np.einsum("dck,dcl->ckl", J, J)
        none = np.zeros_like
        scores = np.concatenate([none(score)[None], state.scores[: LONGEST - 1]]) + score
        information = np.concatenate([none(told)[None], state.information[: LONGEST - 1]]) + told
        after = Sums(scores, information)
        return after, self._finding(after)

    def _finding(self, state: Sums) -> Finding:
        scores, information = state.scores[SHORTEST - 1 :], state.information[SHORTEST - 1 :]
        if not len(scores):
            return Finding(0.0, 0, 0)
        F = information + np.eye(self.rows.shape[1])
        solved = np.linalg.solve(F, scores[..., None])[..., 0]
        ratio = np.sum(scores * solved, axis=2) / self.level
        window, candidate = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
        return Finding(float(ratio.max()), int(candidate), int(window) + SHORTEST)
