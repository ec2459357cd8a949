"""How far the parts of a recording contradict each other: one factor on the stated covariance.

Noise alone explains little of what is wrong with an estimate from pictures: the mesh of a link is
wrong in every picture, and all of a picture is wrong together. So parts are left out. In units of
the prior and of LEAST_EFFECT, with H_c and u_c = J_c^T W e_c of the rows of part c,

    C = (sum_c H_c + 1)^-1,    delta_c = C^1/2 (1 - C^1/2 H_c C^1/2)^-a C^1/2 u_c

a = 1 is how the estimate moves when c is left out (the jackknife, CR3), a = 1/2 has the right mean
under independent parts (CR2, Bell and McCaffrey 2002). Against C, over the k directions that the
pictures tell of what is wanted,

    kappa_c = sum_c |C^-1/2 delta_c|^2 / k

pieces   CR3 (G - 1) / G: a mesh, or the place of a joint between two pieces, errs alike in all
         pictures; only the other pieces contradict it
moments  CR2 times (t / 1.96)^2, t of G - 1 degrees of freedom: a spread that few moments tell
doubts   mean square of what cameras and meshes were found to have wrong, in units of what was
         said of them: it contradicts what was said
halves   mean of d^T (C_a + C_b)^-1 d / k over disjoint halves of the moments, d their difference

    kappa = max(1, pieces + moments - 1, doubts, halves)

as pieces and moments both have the noise in them; times WITHOUT_MASKS where edges of images take
the place of masks. One scalar, as few parts leave most directions of a sandwich matrix empty.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from bodyschema.learners.images.rim_fit import RimModel, RimRows, gram
from bodyschema.learners.images.rim_information import LEAST_EFFECT

Array = NDArray[np.float64]

TOLD = 10.0
"""Information in units of the prior from which on a direction counts as told."""

DRAWS = 20
"""Ways to part the moments into halves."""

NORMAL = 1.96
"""Two-sided 95 % of a normal."""

FLOOR = 0.2
"""Share of the information that a part leaves to the others at the least: what they hardly tell
themselves cannot contradict it. Of 0.05, 0.1 and 0.2 the one whose factor is nearest to the errors
of simulated arms with meshes wrong by 0, 0.3 and 1 mm."""

WITHOUT_MASKS = 4.0
"""Light and shadow move the edges of a link alike in all pictures, so that nothing contradicts
them: before cluttered simulated rooms the errors are twice those with masks."""


@dataclass(frozen=True)
class Part:
    """Some of the rows, in units of the prior and of LEAST_EFFECT."""

    H: Array
    """(size, size)"""
    u: Array
    """(size,)"""


@dataclass(frozen=True)
class Disagreement:
    """Of a fit to the pictures of several moments."""

    moments: tuple[Part, ...]
    pieces: tuple[Part, ...]
    """Those that show."""
    names: tuple[str, ...]
    """Of the pieces that show."""
    known: Array
    """(size,) information of the prior: 1, or 0 where there is none."""
    z: Array
    """(size,) estimate in units of the prior."""
    wanted: int
    """How many of z are wanted."""
    masked: bool = True
    seed: int = 0
    """Of the halves."""

    @classmethod
    def of(
        cls, model: RimModel, rows: Sequence[RimRows], z: Array, masked: bool = True
    ) -> Disagreement:
        """Of weighted rows of all moments at an estimate."""
        live = np.flatnonzero(model.scale > 0)
        scale, n = model.scale[live], len(model.variables)
        known = np.ones(len(model.scale))
        known[:n] = np.isfinite(model.variables.prior_std)
        names, pieces = [], []
        for k, name in enumerate(model.surface.frames):
            mine = [r.group % len(model.surface.frames) == k for r in rows]
            if any(m.any() for m in mine):
                names.append(name)
                pieces.append(_part(zip(rows, mine, strict=True), live, scale))
        everything = [np.ones(len(r.left), dtype=bool) for r in rows]
        moments = [_part([pair], live, scale) for pair in zip(rows, everything, strict=True)]
        return cls(
            tuple(moments),
            tuple(pieces),
            tuple(names),
            known[live],
            z[live] / scale,
            len(model.wanted),
            masked,
        )

    @cached_property
    def kappa(self) -> float:
        """The factor."""
        return self.contradiction * (1.0 if self.masked else WITHOUT_MASKS)

    @cached_property
    def contradiction(self) -> float:
        """The factor without what light does."""
        return max(1.0, self.by_piece + self.by_moment - 1, self.by_doubt, self.by_half)

    @cached_property
    def by_piece(self) -> float:
        """kappa of the pieces; 1 if there is but one."""
        return float(self.piece_shares.sum()) if len(self.pieces) > 1 else 1.0

    @cached_property
    def piece_shares(self) -> Array:
        """(n_pieces,) what each piece adds to `by_piece`."""
        G = len(self.pieces)
        return np.array([self._square(part, 1.0) for part in self.pieces]) * (G - 1) / G

    @cached_property
    def by_moment(self) -> float:
        """kappa of the moments; 1 if there is but one."""
        G = len(self.moments)
        if G < 2:
            return 1.0
        few = (float(stdtrit(G - 1, 0.975)) / NORMAL) ** 2
        return few * sum(self._square(part, 0.5) for part in self.moments)

    @cached_property
    def by_doubt(self) -> float:
        """Of what lens, mounting and meshes were found to have wrong."""
        y, told = self.z[self.wanted :], 1 - np.diag(self._C)[self.wanted :]
        return float(y @ y / max(told.sum(), 1.0)) if len(y) else 1.0

    @cached_property
    def by_half(self) -> float:
        """Of disjoint halves; 1 if there are not two moments."""
        G, rng = len(self.moments), np.random.default_rng(self.seed)
        if G < 2:
            return 1.0
        return float(np.mean([self._halves(rng.permutation(G)) for _ in range(DRAWS)]))

    def without(self, k: int) -> Array:
        """(n,) z in units of the prior, if moment k had not been; to first order."""
        part = self.moments[k]
        return self.z - np.linalg.solve(self._precision - part.H, part.u)

    @cached_property
    def _precision(self) -> Array:
        return np.asarray(np.sum([part.H for part in self.moments], axis=0) + np.diag(self.known))

    @cached_property
    def _C(self) -> Array:
        return np.asarray(np.linalg.inv(self._precision))

    @cached_property
    def _root(self) -> Array:
        return np.asarray(np.linalg.cholesky(self._C))

    @cached_property
    def _white(self) -> Array:
        """(k, wanted) takes what is wanted to its told directions, of variance 1 by C."""
        values, vectors = np.linalg.eigh(self._C[: self.wanted, : self.wanted])
        told = values < 1 / (1 + TOLD)
        return np.asarray((vectors[:, told] / np.sqrt(values[told])).T)

    def _square(self, part: Part, a: float) -> float:
        """|C^-1/2 delta_c|^2 / k."""
        B = self._root.T @ part.H @ self._root
        values, vectors = np.linalg.eigh((B + B.T) / 2)
        left = np.maximum(1 - values, FLOOR) ** a
        delta = self._root @ (vectors @ (vectors.T @ (self._root.T @ part.u) / left))
        return self._mean_square(delta)

    def _mean_square(self, delta: Array) -> float:
        white = self._white @ delta[: self.wanted]
        return float(white @ white) / max(len(white), 1)

    def _halves(self, order: NDArray[np.int64]) -> float:
        """d^T (C_a + C_b)^-1 d / k of one way to part the moments."""
        moved, spread = [], []
        for half in np.array_split(order, 2):
            H = np.sum([self.moments[k].H for k in half], axis=0) + np.diag(self.known)
            u = np.sum([self.moments[k].u for k in half], axis=0) - self.known * self.z
            C = np.linalg.inv(H)
            moved.append(self._white @ (C @ u)[: self.wanted])
            spread.append(self._white @ C[: self.wanted, : self.wanted] @ self._white.T)
        d = moved[0] - moved[1]
        return float(d @ np.linalg.solve(sum(spread), d)) / max(len(d), 1) if len(d) else 1.0


def _part(
    rows: Iterable[tuple[RimRows, NDArray[np.bool_]]], live: NDArray[np.int64], scale: Array
) -> Part:
    """Of some of the rows of some moments."""
    H, u = np.zeros((len(live), len(live))), np.zeros(len(live))
    for r, mine in rows:
        J, pull = np.ascontiguousarray(r.J[mine][:, live] * scale), r.weight[mine]
        gram(J, pull, H)
        u += J.T @ (pull * r.left[mine])
    return Part(H / LEAST_EFFECT, u / LEAST_EFFECT)
