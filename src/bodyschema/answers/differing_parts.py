"""Which parts explain the difference of two beliefs, taken in one after the other.

With d the difference of two beliefs on common ground, C its covariance if nothing has changed and
G_S the response of the second belief to a change of the parts S (`common_ground`),

    gain(S) = d^T C^-1 G_S (G_S^T C^-1 G_S)^-1 G_S^T C^-1 d

grows by a chi-square of rank(S) when nothing but S has changed. Parts are taken into S one after
the other, that with the smallest chance first, while that chance times the number of parts left is
below the allowed rate (Bonferroni, Holm), and out again where later ones explain as much. Parts
that explain as much as one that was taken (within CLOSE, what their numbers gain by chance aside)
cannot be told from it, and are named beside it. What is left of d is a chi-square, too.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc

from bodyschema.answers.common_ground import CommonGround
from bodyschema.answers.compared_part import ComparedPart

Array = NDArray[np.float64]

CLOSE = 6.0
"""Difference of gains up to which two parts cannot be told apart; as in `monitoring.change`."""

SEEN = 1.0
"""Information of a change, in units of its prior, below which the data say little of it."""


@dataclass(frozen=True)
class Differing:
    """Which parts explain a difference."""

    parts: tuple[ComparedPart, ...]
    left: Array
    """(n,) of d, that those which differ leave."""
    p_value: float
    """Of the whole difference."""
    p_value_left: float
    """Of what is left."""

    @classmethod
    def of(cls, ground: CommonGround, rate: float) -> Differing:
        """Take parts in and out; see the module's text."""
        d, rows = ground.difference, ground.parts
        n = len(d)
        if not n:
            return cls((), d, 1.0, 1.0)
        whitened = _Whitened.of(ground)
        whole = float(chdtrc(n, float(whitened.d @ whitened.d)))
        chosen = _pruned(whitened, rows, _taken_in(whitened, rows, rate), rate)
        parts = []
        for part, own in rows.items():
            others = [name for name in chosen if name != part]
            fit = whitened.more(own, _rows(rows, others))
            if not fit.degrees:
                continue
            p_value = min(1.0, fit.p_value * (len(rows) - len(others)))
            alike = _alike(whitened, rows, part, others, fit) if part in chosen else ()
            parts.append(_part(ground, part, own, fit, p_value, part in chosen, alike))
        left = whitened.without(_rows(rows, chosen))
        rest = float(chdtrc(max(n - len(_rows(rows, chosen)), 1), float(left @ left)))
        ranked = sorted(parts, key=lambda one: (not one.differs, one.p_value, -one.deviations))
        return cls(tuple(ranked), whitened.factor @ left, whole, rest)


Rows = Mapping[str, Sequence[int]]


def _taken_in(whitened: _Whitened, rows: Rows, rate: float) -> list[str]:
    """Parts that explain the difference, one after the other."""
    chosen: list[str] = []
    while len(chosen) < len(rows):
        taken = _rows(rows, chosen)
        tried = {p: whitened.more(own, taken) for p, own in rows.items() if p not in chosen}
        best = min(tried, key=lambda part: (tried[part].p_value, -tried[part].gain))
        if tried[best].p_value * len(tried) >= rate:
            break
        chosen.append(best)
    return chosen


def _pruned(whitened: _Whitened, rows: Rows, chosen: list[str], rate: float) -> list[str]:
    """Without those that are not needed any more beside the ones that came later."""
    while chosen:
        others = [_rows(rows, [name for name in chosen if name != part]) for part in chosen]
        p_values = [
            whitened.more(rows[part], taken).p_value
            for part, taken in zip(chosen, others, strict=True)
        ]
        worst = int(np.argmax(p_values))
        if p_values[worst] * (len(rows) - len(chosen) + 1) < rate:
            break
        chosen = chosen[:worst] + chosen[worst + 1 :]
    return chosen


def _alike(
    whitened: _Whitened, rows: Rows, part: str, others: Sequence[str], fit: _Fit
) -> tuple[str, ...]:
    """Parts that would explain as much in its place, beside the others."""
    taken, found = _rows(rows, others), []
    for name, own in rows.items():
        if name != part and name not in others:
            rival = whitened.more(own, taken)
            if fit.gain - fit.degrees - (rival.gain - rival.degrees) < CLOSE:
                found.append(name)
    return tuple(found)


def _rows(rows: Rows, parts: Sequence[str]) -> list[int]:
    return [i for part in parts for i in rows[part]]


@dataclass(frozen=True)
class _Fit:
    """A change of one part beside those that were taken in."""

    change: Array
    covariance: Array
    gain: float
    degrees: int
    p_value: float


@dataclass(frozen=True)
class _Whitened:
    """d and G with C = factor factor^T divided out."""

    factor: Array
    d: Array
    G: Array
    scale: Array
    """(n,) priors: what numbers of a part are compared by."""

    @classmethod
    def of(cls, ground: CommonGround) -> _Whitened:
        scale = ground.variables.scale
        # In units of the priors, since rad, m and px lie far apart.
        C = ground.covariance / np.outer(scale, scale)
        L = np.linalg.cholesky((C + C.T) / 2)
        d = np.linalg.solve(L, ground.difference / scale)
        G = np.linalg.solve(L, ground.response / scale[:, None])
        return cls(scale[:, None] * L, d, G, scale)

    def more(self, rows: Sequence[int], taken: Sequence[int]) -> _Fit:
        """What a part explains beyond those taken in."""
        d, G = self.without(taken), self._beside(self.G[:, rows], taken) * self.scale[list(rows)]
        values, vectors = np.linalg.eigh(G.T @ G)
        seen = values > SEEN
        along = (vectors[:, seen].T @ (G.T @ d)) / values[seen]
        gain, degrees = float(np.sum(along**2 * values[seen])), int(np.sum(seen))
        own = vectors[:, seen] * self.scale[list(rows)][:, None]
        p_value = float(chdtrc(degrees, gain)) if degrees else 1.0
        return _Fit(own @ along, (own / values[seen]) @ own.T, gain, degrees, p_value)

    def without(self, taken: Sequence[int]) -> Array:
        """d less what the parts taken in explain, (n,)."""
        return self._beside(self.d[:, None], taken)[:, 0]

    def _beside(self, columns: Array, taken: Sequence[int]) -> Array:
        if not len(taken):
            return columns
        known = self.G[:, list(taken)] * self.scale[list(taken)]
        return np.asarray(columns - known @ np.linalg.lstsq(known, columns, rcond=1e-9)[0])


def _part(
    ground: CommonGround,
    part: str,
    rows: Sequence[int],
    fit: _Fit,
    p_value: float,
    differs: bool = False,
    alike: Sequence[str] = (),
) -> ComparedPart:
    names = tuple(ground.variables.names[i] for i in rows)
    units = tuple(ground.variables.units[i] for i in rows)
    std = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0))
    return ComparedPart(
        part, names, units, fit.change, std, fit.covariance, float(np.sqrt(fit.gain)), p_value,
        differs, tuple(alike),
    )  # fmt: skip
