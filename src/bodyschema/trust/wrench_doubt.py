"""What is really known of a load: noise, what errs in common, and what else explains the wrench.

    core     covariance of the fit with the repairs free beside it, inflated by what means of one
             stretch of time or one posture have in common (`wrench_inflation`)
    left     the rivals (`wrench_rivals`) that still explain some of what is left, not freed
    whole    core, and by how much the worst of them, if true, has moved the load

A repair is believed if it explains stretches of time that it was not fitted to (`foretold`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.payload.chart import SHARED
from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.payload.recorded import PayloadFit
from bodyschema.trust.wrench_gravity import Lean, lean
from bodyschema.trust.wrench_inflation import inflations
from bodyschema.trust.wrench_rivals import (
    MASS,
    WeighedRival,
    WrenchRival,
    as_free,
    beside,
    freed,
    moved,
    noise_beside,
    weighed,
    weighed_anew,
    wrench_rivals,
)
from bodyschema.trust.wrench_rows import WrenchRows, blocks, slopes

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

SURE = 1e-4
"""Chance below which what a rival explains is no chance."""

WORTH = 0.05
"""Chance of the likeliest cause below which the load is fitted under a tilt: seen from the fit as
declared, a large one is less sure than it is."""

CLEARLY = 6.0
"""Gain by which a cause beats its rivals: odds of twenty."""

LIKELY = 0.5
"""Share of the best gain from which a rival may be the cause as well."""

CONFIRMED = 2.0
"""Standard errors by which a repair must foretell other stretches of time better."""

STEEPEST = 1.75
"""Slope of a base (60 degrees) up to which it is taken for one that leans; beyond, gravity is
declared along another axis, and that is for the user to say."""

ASKED = ("mass", "centre", "moments")


@dataclass(frozen=True)
class WrenchDoubt:
    """What a fit leaves in doubt."""

    core: Array
    """(P, P) of theta = (w, b, phi_1 .. phi_K)."""
    whole: Array
    """(P, P)."""
    bare: Array
    """(P, P) of noise alone, nothing free beside the load."""
    inflation: tuple[dict[str, float], ...]
    """kappa of each load's mass, centre and moments."""
    left: tuple[WeighedRival, ...]
    """Rivals that are no chance, the likeliest first."""
    span: float
    """See `WrenchRows.span`."""
    freedom: float
    """Numbers seen less those that were fitted."""


def doubt(
    fit: PayloadFit,
    learner: LoadLearner,
    R_world: Array | None,
    mended: Sequence[WeighedRival] = (),
) -> WrenchDoubt:
    """Weigh all that may be wrong with a fit.

    Args:
        fit: of a recording, repairs done.
        learner: with the priors of the sensor.
        R_world: (n, 3, 3) of all means, see `wrench_rivals`.
        mended: what was repaired, which is free beside the load.
    """
    rows, found, here, _, _, _ = _looked_at(fit, learner, R_world)
    again = {one.family for one in mended}
    left = tuple(one for one in found if one.p_value < SURE and one.family not in again)
    kappas = tuple(_kappas(rows, fit, k) for k in range(len(fit.names)))
    bare = rows.root @ rows.root.T
    core = _stretched(bare, fit, kappas)
    for one in {one.family: one for one in mended}.values():
        size = max(other.size for other in mended if other.family == one.family)
        spread = moved(rows, as_free(replace(one, rival=_same(one.rival, here), size=size), rows))[
            1
        ]
        core = core + spread @ spread.T
    likely = [one for one in left if one.gain > LIKELY * left[0].gain]
    ways = [_moved(rows, one) for one in likely]
    worst = max(ways, key=lambda way: _size(way, fit), default=np.zeros_like(core))
    return WrenchDoubt(core, core + worst, bare, kappas, left, rows.span, rows.freedom)


def repair(
    fit: PayloadFit, learner: LoadLearner, R_world: Array | None, wanted: Sequence[str]
) -> tuple[WeighedRival, Array] | None:
    """What explains a fit's residuals best, if it is of a family that can be mended.

    Args:
        fit: of a recording.
        learner: with the priors of the sensor.
        R_world: see `wrench_rivals`.
        wanted: families.

    Returns:
        the rival, and (n, 6) N and Nm that it does to all means, along the mount's axes; None if
        there is none that is sure, foretells, and leaves its rivals behind.
    """
    rows, found, _, whole, noise, leant = _looked_at(fit, learner, R_world)
    rows = rows.told_in(noise)
    if not found or found[0].p_value > SURE or found[0].family not in wanted:
        return None
    one = found[0]
    if one.family == "tilt" and np.linalg.norm(one.gamma) > STEEPEST:
        return None
    under = leant if leant is not None and one.family == "tilt" else beside(rows, one)
    # Stretches weigh alike: one that is far off says no more than that it is.
    better = np.log(foretold(rows) / foretold(under))
    se = float(np.std(better, ddof=1) * np.sqrt(len(better)))
    if float(better.sum()) < CONFIRMED * se:
        return None
    return one, np.asarray(_same(one.rival, whole).Z @ one.gamma)


class _Look(NamedTuple):
    """What a fit leaves over, and what might explain it."""

    rows: WrenchRows
    """That count, in the fit's noise."""
    found: list[WeighedRival]
    here: list[WrenchRival]
    """On these rows."""
    whole: list[WrenchRival]
    """On all means."""
    noise: Array
    """(6,) beside all rivals."""
    leant: WrenchRows | None
    """These rows under the tilt among `found`, and it free, where it is no small one."""


def _looked_at(fit: PayloadFit, learner: LoadLearner, R_world: Array | None) -> _Look:
    everything = WrenchRows.of(fit, learner)
    rivals = wrench_rivals(everything, R_world)
    rows = everything.take(everything.counts)
    here = [rival.take(everything.counts) for rival in rivals]
    noise = noise_beside(here, rows)
    look = _Look(rows, weighed(here, rows.told_in(noise)), here, rivals, noise, None)
    if R_world is None or min((one.p_value for one in look.found), default=1.0) > WORTH:
        return look
    leant = lean(fit, learner, R_world)
    return look if leant is None else _leaning(look, leant, learner, everything.counts)


def _leaning(look: _Look, leant: Lean, learner: LoadLearner, counts: Flags) -> _Look:
    """The same with the tilt that a load fitted under it speaks for."""
    # On few means the levels of a fit without a tilt take it for noise.
    noise = np.minimum(look.noise, np.sqrt(leant.fit.solution.levels.variance))
    rows = look.rows.told_in(noise)
    everything, rival = leant.rows(learner)
    there = everything.take(counts).told_in(noise)
    one = weighed_anew(rival.take(counts), leant.gamma, there, rows)
    if one is None:
        return look
    others = (other for other in weighed(look.here, rows) if other.family != "tilt")
    found = sorted([one, *others], key=lambda one: -one.gain)
    return look._replace(found=found, noise=noise, leant=freed(there, one))


def foretold(rows: WrenchRows) -> Array:
    """(clusters,) squared residuals of each stretch of time by a fit to all others."""
    label = next(rows.clusters())
    found = []
    for some in blocks(label):
        B = rows.B[some].reshape(-1, rows.B.shape[2])
        H = np.eye(len(B)) - B @ B.T
        e = np.linalg.lstsq(H, rows.z[some].ravel(), rcond=1e-9)[0]
        found.append(max(float(e @ e), 1e-300))
    return np.array(found)


def _same(one: WrenchRival, among: Sequence[WrenchRival]) -> WrenchRival:
    """The candidate of the same family, nearest in time, with its effect on other rows."""
    family = [r for r in among if r.family == one.family]
    return family[int(np.argmin([abs(r.when - one.when) for r in family]))]


def _kappas(rows: WrenchRows, fit: PayloadFit, k: int) -> dict[str, float]:
    """Inflation of each thing that is asked of load k; never below what the levels' memory says."""
    asked = slopes(fit, k)
    found = inflations(rows, asked)
    for name, J in asked.items():
        stated = float(np.sum((J @ fit.solution.covariance) * J))
        here = float(np.sum((J @ rows.root) ** 2))
        found[name] = max(found[name], stated / max(here, 1e-300))
    return found


def _stretched(C: Array, fit: PayloadFit, kappas: Sequence[dict[str, float]]) -> Array:
    """(P, P) with mass, centre and moments of each load inflated, and the sensor by the most."""
    T = np.eye(len(C))
    D = np.full(len(C), max(max(kappa[n] for n in ASKED[:2]) for kappa in kappas))
    for k, kappa in enumerate(kappas):
        at = SHARED + 10 * k
        T[at : at + 10] = np.vstack(list(slopes(fit, k).values()))
        D[at : at + 10] = np.repeat([kappa[name] for name in ASKED], [1, 3, 6])
    F = np.linalg.solve(T, np.sqrt(D)[:, None] * T)
    out = F @ C @ F.T
    return np.asarray((out + out.T) / 2)


def _moved(rows: WrenchRows, one: WeighedRival) -> Array:
    """(P, P) by how much a rival, if true, has moved theta, and leaves it less sure."""
    step, spread = moved(rows, one)
    out = spread @ spread.T + np.outer(step, step)
    if one.family in ("loss", "change"):
        # The load itself is another one at the end: by this much beyond the mean.
        own = np.zeros(len(step))
        own[SHARED : SHARED + 4] = MASS * one.gamma
        out += np.outer(own, own)
    return np.asarray(out)


def _size(covariance: Array, fit: PayloadFit) -> float:
    """How far masses and centres are moved, shares of a load and of 10 cm."""
    total = 0.0
    for k, name in enumerate(fit.names):
        J = slopes(fit, k)
        total += float((J["mass"] @ covariance @ J["mass"].T)[0, 0]) / fit.loads[name].mass ** 2
        total += float(np.trace(J["centre"] @ covariance @ J["centre"].T)) / 0.1**2
    return total
