"""Trials: what a recording leaves unexplained under each of many declarations of it.

One sense at a time, with the kinematics between the parents of its frames (`open_chain`); all
declarations that are about it are fitted at once (`frame_fits`). A declaration about another sense
leaves it as it is. Scales, axes and gears are taken from the recording itself.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.tree import Body
from bodyschema.seeds.frame_fits import Batch, FrameFits
from bodyschema.seeds.open_chain import OpenChain, moved
from bodyschema.trust import declarations as others
from bodyschema.trust.declarations import AS_DECLARED, Declaration, Recorded

Array = NDArray[np.float64]

MOST = 96
"""Samples of a sense that are looked at."""

FEW = 15
"""Samples below which a scale that is no unit, a gear, and rows that are apart (which leave fewer)
are not told from noise."""

AXES = 0.35
"""Largest deviation from a signed permutation up to which axes count as swapped or mirrored."""

SCALED, LEAST_GEAR = 0.03, 0.01
"""Relative deviations of a scale and of a gear from 1 that are worth a name."""

REVERSED = 0.2
"""A factor of a joint that is so near to -1 is a sign: zeros that are off spoil it by so much."""

FINER = (0.1, 0.02, 0.004)
"""Steps of a gear, relative, in the search for the best one."""


@dataclass(frozen=True)
class Trial:
    """One declaration and what it leaves."""

    declaration: Declaration
    score: float
    """Of all senses."""
    share: float
    """The worst of the senses that it is about."""
    residual: tuple[tuple[float, float], ...]
    """m and rad of each sense."""

    def about(self, chains: Sequence[OpenChain]) -> int:
        """The sense that is told of: that of the declaration, else the first."""
        labels = [chain.label for chain in chains]
        return labels.index(self.declaration.sense) if self.declaration.sense else 0


@dataclass(frozen=True)
class Trials:
    """All declarations of a recording."""

    body: Body
    chains: Sequence[OpenChain]
    declared: Mapping[str, Recorded] = field(default_factory=dict)
    robot: Recorded | None = None
    joint_unit: str = ""
    offset: Array | None = None
    """(n_joints,) added to all readings, after what a declaration makes of them."""

    def tried(self) -> list[Trial]:
        """As declared, then all others; those that need a number are tried with the best one."""
        first = [AS_DECLARED, *self._of_readings()]
        for chain in self.chains:
            recorded, whose = self._recorded(chain)
            posed, n = chain.Q is not None, len(chain.q)
            turns = posed and not chain.pictured
            seen = others.seen_otherwise(chain.label, posed, turns, recorded, whose)
            first += [d for d in seen if not d.shift or n - abs(d.shift) >= FEW]
        trials = self.of(first)
        return trials + self.of(list(self._with_numbers(trials)))

    def _of_readings(self) -> Iterator[Declaration]:
        if self.robot is not None:
            yield from others.hand_otherwise(self.robot)
            return
        few = max(len(chain.q) for chain in self.chains) < FEW
        for d in others.joints_otherwise(self.body, moved(self.chains), self.joint_unit):
            if not few or d.joint < 0 or d.factor == -1:
                yield d

    def _recorded(self, chain: OpenChain) -> tuple[Recorded, str]:
        return self.declared.get(chain.label, Recorded()), f"of the {chain.label}"

    def of(self, tried: Sequence[Declaration]) -> list[Trial]:
        """What declarations leave; the first stands in for those that are about another sense."""
        n = len(tried)
        score, share = np.zeros(n), np.zeros(n)
        residual = np.zeros((n, len(self.chains), 2))
        for c, chain in enumerate(self.chains):
            about = [k for k, d in enumerate(tried) if d.sense in ("", chain.label)]
            fits = self._fitted(chain, [tried[k] for k in about])
            score += fits.score[0]
            score[about] += fits.score - fits.score[0]
            share[about] = np.maximum(share[about], fits.worst)
            residual[:, c] = fits.metres[0], fits.radians[0]
            residual[about, c] = np.stack([fits.metres, fits.radians], axis=1)
        return [
            Trial(d, float(score[k]), float(share[k]), tuple((m, r) for m, r in residual[k]))
            for k, d in enumerate(tried)
        ]

    def _with_numbers(self, trials: Sequence[Trial]) -> Iterator[Declaration]:
        """As declared, and scales, axes and gears as the recording itself says them."""
        yield AS_DECLARED
        for chain in self.chains:
            recorded, whose = self._recorded(chain)
            scaled = Declaration("", "scale", sense=chain.label, scaled=True)
            fits = self._fitted(chain, [AS_DECLARED, scaled])
            s = float(fits.scale[1])
            told = others.resized(s, recorded, chain.label, whose)
            if abs(s - 1) > SCALED and (told.key == "unit" or len(chain.q) >= FEW):
                yield told
            hand = None if self.robot is None else others.hand_resized(1 / s, self.robot)
            if hand is not None:
                yield hand
            P = _signed_permutation(fits.axes[0])
            if P is not None and not chain.pictured:
                yield others.other_axes(P, chain.label, chain.Q is not None, whose)
        if any(trial.declaration.joint >= 0 and trial.declaration.factor > 0 for trial in trials):
            yield from self._gear(trials)

    def _gear(self, trials: Sequence[Trial]) -> Iterator[Declaration]:
        """The joint whose gear explains most, with the factor that explains most."""
        geared = [trial for trial in trials if trial.declaration.joint >= 0]
        best = self._factor(min(geared, key=lambda trial: trial.score).declaration)
        if abs(best.factor - 1) > LEAST_GEAR and abs(best.factor + 1) > REVERSED:
            yield best

    def finer(self, declaration: Declaration) -> Declaration | None:
        """A declaration with its number taken anew; None if it has none."""
        if declaration.key == "scale":
            chain = next(c for c in self.chains if c.label == declaration.sense)
            s = float(self._fitted(chain, [replace(declaration, scaled=True)]).scale[0])
            recorded, whose = self._recorded(chain)
            return others.resized(s * declaration.size, recorded, chain.label, whose)
        # A joint that counts the other way round has no number.
        if declaration.joint >= 0 and abs(declaration.factor + 1) > REVERSED:
            return self._factor(declaration)
        return None

    def _factor(self, best: Declaration) -> Declaration:
        """The factor of a joint that explains most, near that of a declaration."""
        for width in FINER:
            near = [1 + width * k for k in range(-5, 6)]
            finer = [others.geared(self.body, best.joint, best.factor * f) for f in near]
            best = min(self.of(finer), key=lambda trial: trial.score).declaration
        return best

    def _fitted(self, chain: OpenChain, tried: Sequence[Declaration]) -> FrameFits:
        """The frames of one sense under each of some declarations."""
        n = len(chain.q)
        rows = np.linspace(0, n - 1, min(n, MOST)).astype(int)
        q, p, Q, use = [], [], [], []
        for d in tried:
            from_row = rows - d.shift
            use.append((from_row >= 0) & (from_row < n))
            there = chain.q if d.readings is None else d.readings(chain.q)
            there = there if self.offset is None else there + self.offset
            q.append(there[np.clip(from_row, 0, n - 1)])
            seen = chain.p, chain.Q
            positions, turns = seen if d.seen is None else d.seen(*seen)
            p.append(d.size * positions[rows])
            Q.append(None if turns is None else turns[rows])
        K = chain.kinematics(np.stack(q))
        swapped = np.array([d.swapped for d in tried])
        K[swapped] = lie.inverse(K[swapped])
        turned = None if chain.Q is None else np.stack([R for R in Q if R is not None])
        scaled = np.array([d.scaled for d in tried])
        free = scaled if scaled.any() else None
        return FrameFits.of(Batch(K, np.stack(p), turned, np.stack(use), free))


def _signed_permutation(axes: Array) -> Array | None:
    """The signed permutation (3, 3) that axes are near; None for others and for none at all."""
    size = np.cbrt(abs(np.linalg.det(axes)))
    if size <= 0:
        return None
    P = np.round(axes / size)
    once = all((np.abs(P).sum(axis=a) == 1).all() for a in (0, 1))
    near = np.abs(axes / size - P).max() < AXES
    return P if once and near and not np.array_equal(P, np.eye(3)) else None
