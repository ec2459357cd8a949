"""Has the body changed since it was calibrated? A test with a stated rate of false alarms.

The calibrated body (mean x, information L) predicts new samples with residuals

    r = J e + J_B d + f(q) + noise,   e ~ N(0, L^-1) what the calibration left uncertain,
                                      d the change of one part B: a joint's zero, a camera, a tool,
                                      f the residual field that no geometry explains (discrepancy).

Per axis the covariance of field and noise is K = A^2 k(q, q') + N^2 diag(1/w), with Student-t
weights w; H = J^T K^-1 J and g = -J^T K^-1 r. Eliminating e leaves the score and information of the
change alone (generalised least squares):

    M = (H_AA + L)^-1,   S = H_BB - H_BA M H_AB,   u = g_B - H_BA M g_A,   T_B = u^T S^-1 u

T_B over its spread (the variance that the scores really have over what H says) is rank(S) times an
F of rank(S) and the remaining degrees of freedom if nothing has changed. Each part is tested; the
smallest p-value times the number of parts is compared with the allowed rate of false alarms
(Bonferroni). The weights are found anew for each part with its own change put in, so that a large
change is not taken for a recording full of outliers; then parts are compared by T_B at the weights
and the spread of the best one, for their own differ by a few per cent, which of a large T is much.
A part is suspect when its evidence comes close to the best one's: what the data cannot tell apart
is blamed together. Its rival is that all parts have moved: where that is better by as much, no
single part is the cause; the share of that T which a part explains is said.

A model that is not quite true errs alike in like postures, so that the samples of a calibration
are worth less than their number: L is that of an estimate as wide as its own samples made it
(`trust.weighing`). And a change is only called one if it moves what is seen by as much as matters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.special import fdtrc

from bodyschema.estimation.discrepancy import Field, matern
from bodyschema.estimation.estimate import Estimate
from bodyschema.model.kinematics import relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.monitoring.parts import parts_of
from bodyschema.senses.sense import Sense
from bodyschema.threads import one_thread

Array = NDArray[np.float64]

FREEDOM = 4.0
"""nu of the Student-t noise, as in `estimation.solver`."""

CLOSE = 6.0
"""Difference of evidence (2 log likelihood ratio) up to which parts are suspected together."""

MOST = 0.9
"""Share of what all parts together explain from which one part is the cause."""

ROUNDS = 5

LEAST = 0.1
"""Of the noise level: how much of it must be noise beside a residual field."""


@dataclass(frozen=True)
class Suspect:
    """One part that may have changed."""

    part: str
    """Name of a joint or of a frame."""
    p_value: float
    """Chance of so much evidence without a change of this part; not corrected for many parts."""
    evidence: float
    """T_B less what its number of parameters would gain by chance."""
    change: Array
    """(k,) estimated change, rad and m."""
    names: tuple[str, ...]
    """(k,) of the parameters that changed."""
    effect: float = float("nan")
    """m: 95 % of how far the change moves what was seen, in the postures of the new samples."""
    share: float = float("nan")
    """T_B over that of all parts together."""


@dataclass(frozen=True)
class ChangeTest:
    """Whether a recording still agrees with a calibration."""

    changed: bool
    p_value: float
    """Smallest p-value of any part, times the number of parts."""
    suspects: tuple[Suspect, ...]
    """Parts that explain the change about equally well, best first; empty when unchanged."""
    position_rms: float
    """m: of the new samples under the calibrated body, outliers not counted."""
    alone: bool = True
    """One part explains the change as well as all parts together do."""


@dataclass(frozen=True)
class _Block:
    """One component of one sense: rows of every sample, with its noise and residual field."""

    residual: Array
    """(n, axes)."""
    jacobian: Array
    """(n, axes, n_parameters)."""
    correlation: Array
    """(n, n) of the field; zero without one."""
    amplitude: float
    noise: float
    first: int
    """Number of the block's first sample among all samples."""

    @property
    def samples(self) -> slice:
        """Its samples among all."""
        return slice(self.first, self.first + len(self.residual))


@dataclass(frozen=True)
class _Fitted:
    """The change of one part that explains the new samples best at given weights."""

    change: Array
    """(k,)."""
    moved: Array
    """(n_parameters,) that and e."""
    squared: float
    """u^T S^-1 u."""
    degrees: int
    """rank(S)."""


@dataclass(frozen=True)
class _Tested:
    """One part, tested with weights and a spread of its own."""

    suspect: Suspect
    fitted: _Fitted
    spread: float
    rest: float
    """Degrees of freedom behind the spread."""


@one_thread
def detect_change(
    estimate: Estimate,
    senses: Sequence[Sense],
    fields: Mapping[str, Field] | None = None,
    false_alarm: float = 0.01,
    least: float = 0.0,
) -> ChangeTest:
    """Test new samples against a calibration.

    Args:
        estimate: of the calibration, with its noise levels.
        senses: the new samples; their frames must be in the estimate's reference body.
        fields: residual fields by label of the sense; none when absent.
        false_alarm: chance of calling an unchanged body changed.
        least: m; a change that moves what is seen by less is none.
    """
    variables, parts = parts_of(estimate, senses)
    blocks = _blocks(estimate, variables, senses, fields or {})
    tests = {
        part: _test_part(part, rows, estimate, variables, blocks) for part, rows in parts.items()
    }
    p_value = min(1.0, len(tests) * min(test.suspect.p_value for test in tests.values()))
    best = max(tests.values(), key=lambda test: test.suspect.evidence)
    H, g = _normal(blocks, _weights(blocks, best.fitted.moved))

    def told(rows: Sequence[int]) -> tuple[float, float]:
        """T_B and evidence of a part, all at the same weights."""
        fitted = _fit(rows, H, g, estimate.information)
        gain = fitted.squared / best.spread
        return gain, gain - _cost(fitted.degrees, best.rest)

    found = {part: told(rows) for part, rows in parts.items()}
    all_gain, all_evidence = told(sorted({row for rows in parts.values() for row in rows}))
    ranked = sorted(found, key=lambda part: -found[part][1])
    strongest = found[ranked[0]][1]
    close = []
    for part in ranked:
        gain, evidence = found[part]
        if strongest - evidence < CLOSE:
            suspect, share = tests[part].suspect, gain / max(all_gain, gain)
            effect = _effect(estimate, variables, suspect, senses)
            close.append(replace(suspect, evidence=evidence, share=share, effect=effect))
    matters = not all(suspect.effect < least for suspect in close)
    changed = p_value < false_alarm and matters
    alone = close[0].share > MOST or all_evidence - strongest < CLOSE
    suspects = tuple(close) if changed else ()
    return ChangeTest(changed, p_value, suspects, _typical(estimate.body, senses), alone)


def _blocks(
    estimate: Estimate,
    variables: Variables,
    senses: Sequence[Sense],
    fields: Mapping[str, Field],
) -> list[_Block]:
    x = np.concatenate([estimate.x, np.zeros(len(variables) - len(estimate.x))])
    blocks, first = [], 0
    for sense in senses:
        linear = sense.linearize(estimate.reference, variables, x)
        field = fields.get(sense.label)
        for i, (name, unit, part) in enumerate(sense.components):
            noise = (estimate.noise or {})[f"{sense.label}: {name} ({unit})"]
            amplitude, correlation = 0.0, np.zeros((len(sense), len(sense)))
            if field is not None:
                amplitude, noise = field.amplitude[i], max(field.noise[i], LEAST * noise)
                correlation = matern(sense.q, sense.q, field.length)
            residual, J = linear.residual[:, part], linear.by_parameter[:, part]
            blocks.append(_Block(residual, J, correlation, amplitude, noise, first))
        first += len(sense)
    return blocks


def _test_part(
    part: str,
    rows: Sequence[int],
    estimate: Estimate,
    variables: Variables,
    blocks: Sequence[_Block],
) -> _Tested:
    """Fit the change of one part, with weights of its own, and test it against none."""
    moved = np.zeros(len(variables))
    for _ in range(ROUNDS):
        H, g = _normal(blocks, _weights(blocks, moved))
        fitted = _fit(rows, H, g, estimate.information)
        moved = fitted.moved
    spread, rest = _spread(blocks, moved, fitted.degrees)
    T = fitted.squared / spread
    p_value = float(fdtrc(fitted.degrees, rest, T / fitted.degrees))
    names = tuple(variables.names[i] for i in rows)
    evidence = T - _cost(fitted.degrees, rest)
    suspect = Suspect(part, p_value, evidence, fitted.change, names)
    return _Tested(suspect, fitted, spread, rest)


def _fit(rows: Sequence[int], H: Array, g: Array, information: Array) -> _Fitted:
    """The change of the parameters in `rows`, e eliminated."""
    known, B = len(information), list(rows)
    prior = H[:known, :known] + information
    M = np.linalg.solve(prior, np.column_stack([H[:known][:, B], g[:known]]))
    S = H[np.ix_(B, B)] - H[B][:, :known] @ M[:, :-1]
    u = g[B] - H[B][:, :known] @ M[:, -1]
    values, vectors = np.linalg.eigh((S + S.T) / 2)
    seen = values > 1e-9 * max(values[-1], 1e-300)
    along = vectors[:, seen].T @ u
    change = vectors[:, seen] @ (along / values[seen])
    moved = np.zeros(len(g))
    moved[:known] = M[:, -1] - M[:, :-1] @ change
    moved[B] += change
    return _Fitted(change, moved, float(np.sum(along**2 / values[seen])), int(np.sum(seen)))


def _cost(degrees: int, rest: float) -> float:
    """What so many parameters gain by chance (Schwarz 1978)."""
    return float(degrees * np.log(max(rest, 2.0)))


def _effect(
    estimate: Estimate, variables: Variables, suspect: Suspect, senses: Sequence[Sense]
) -> float:
    """m: how far a part's change moves what was seen; the largest over all pairs of frames."""
    free = variables.take([variables.names.index(name) for name in suspect.names])
    nothing, found = np.zeros(len(free)), []
    for sense in senses:
        for a, b in sense.pairs:
            D = relative_pose_derivatives(estimate.body, free, nothing, sense.q, a, b)
            moved = np.linalg.norm(D.by_parameter[:, :3] @ suspect.change, axis=1)
            found.append(float(np.quantile(moved, 0.95)))
    return max(found)


def _normal(blocks: Sequence[_Block], weights: Array) -> tuple[Array, Array]:
    """H and g of the module's text."""
    n = blocks[0].jacobian.shape[2]
    H, g = np.zeros((n, n)), np.zeros(n)
    for block in blocks:
        w = weights[block.samples]
        K = block.amplitude**2 * block.correlation + np.diag(block.noise**2 / w)
        factor = cho_factor(K)
        for axis in range(block.residual.shape[1]):
            J = block.jacobian[:, axis]
            KJ = cho_solve(factor, J)
            H += J.T @ KJ
            g -= KJ.T @ block.residual[:, axis]
    return H, g


def _squared(blocks: Sequence[_Block], x: Array) -> tuple[Array, Array]:
    """Squared residual of each sample in units of field and noise, and its number of rows."""
    n = max(block.samples.stop for block in blocks)
    squared, d = np.zeros(n), np.zeros(n)
    for block in blocks:
        left = block.residual + block.jacobian @ x
        size = block.amplitude**2 + block.noise**2
        squared[block.samples] += np.sum(left**2, axis=1) / size
        d[block.samples] += left.shape[1]
    return squared, d


def _weights(blocks: Sequence[_Block], x: Array) -> Array:
    """Student-t weight of each sample when the parameters have moved by x."""
    squared, d = _squared(blocks, x)
    return np.asarray((FREEDOM + d) / (FREEDOM + squared))


def _spread(blocks: Sequence[_Block], x: Array, degrees: int) -> tuple[float, float]:
    """Variance of the estimated change over S^-1, and the degrees of freedom behind it.

    The sandwich of an M-estimate (Huber 1967): with psi = w r it is
    mean(psi^2) mean(w) / mean(psi')^2, where psi' averaged over directions is
    w (1 - 2 |r|^2 / (d (nu + |r|^2))).
    """
    squared, d = _squared(blocks, x)
    w = (FREEDOM + d) / (FREEDOM + squared)
    slope = w * (1 - 2 * squared / (d * (FREEDOM + squared)))
    rest = max(float(np.sum(d)) - degrees, 1.0)
    variance = np.sum(w**2 * squared) * np.sum(d) / rest
    return float(variance * np.sum(w * d) / np.sum(slope * d) ** 2), rest


def _typical(body: Body, senses: Sequence[Sense]) -> float:
    """Root mean square position residual in m, from its median: outliers do not count."""
    lengths = [np.linalg.norm(sense.residual(body)[:, :3], axis=1) for sense in senses]
    return float(np.median(np.concatenate(lengths)) * np.sqrt(3) / 1.538)
