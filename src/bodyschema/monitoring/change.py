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
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from bodyschema.estimation.discrepancy import Field
from bodyschema.estimation.estimate import Estimate
from bodyschema.model.kinematics import relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.monitoring.moved_part import (
    Suspect,
    blocks_of,
    cost_of,
    fitted_part,
    normal_equations,
    tested,
    weights_at,
)
from bodyschema.monitoring.parts import parts_of
from bodyschema.senses.sense import Sense
from bodyschema.threads import one_thread

Array = NDArray[np.float64]

CLOSE = 6.0
"""Difference of evidence (2 log likelihood ratio) up to which parts are suspected together."""

MOST = 0.9
"""Share of what all parts together explain from which one part is the cause."""


@dataclass(frozen=True)
class ChangeTest:
    """Whether a recording still agrees with a calibration."""

    changed: bool
    p_value: float
    """Smallest p-value of any part, times the number of parts."""
    suspects: tuple[Suspect, ...]
    """Parts that explain the change about equally well, best first; empty when unchanged."""
    position_rms: float
    """m: of the new samples under the calibrated body, outliers not counted; nan where no place
    was seen."""
    alone: bool = True
    """One part explains the change as well as all parts together do."""
    typical: Mapping[str, float] = field(default_factory=dict)
    """The same of all that was seen, by its unit: "m", "px", "N"."""


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
    blocks = blocks_of(estimate, variables, senses, fields or {})
    tests = {part: tested(part, rows, estimate, variables, blocks) for part, rows in parts.items()}
    p_value = min(1.0, len(tests) * min(test.suspect.p_value for test in tests.values()))
    best = max(tests.values(), key=lambda test: test.suspect.evidence)
    H, g = normal_equations(blocks, weights_at(blocks, best.fitted.moved))

    def told(rows: Sequence[int]) -> tuple[float, float]:
        """T_B and evidence of a part, all at the same weights."""
        fitted = fitted_part(rows, H, g, estimate.information)
        gain = fitted.squared / best.spread
        return gain, gain - cost_of(fitted.degrees, best.rest)

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
    typical = _typical(estimate.body, senses)
    return ChangeTest(changed, p_value, suspects, typical.get("m", float("nan")), alone, typical)


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


def _typical(body: Body, senses: Sequence[Sense]) -> dict[str, float]:
    """Root mean square residual by unit, from its median: outliers do not count.

    Of a sense with several measures the first: of poses the position.
    """
    lengths: dict[str, list[Array]] = {}
    for sense in senses:
        _, unit, rows = sense.components[0]
        r = sense.residual(body)[:, rows]
        d = r.shape[1]
        one = np.sqrt(d / chdtri(d, 0.5)) * np.linalg.norm(r, axis=1)
        lengths.setdefault(unit, []).append(one)
    return {unit: float(np.median(np.concatenate(all_))) for unit, all_ in lengths.items()}
