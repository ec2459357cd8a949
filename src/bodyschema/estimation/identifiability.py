"""What the data cannot tell, in words.

With D the prior standard deviations, F = D J^T R^-1 J D measures every direction of parameter space
in units of the prior: along an eigenvector v with eigenvalue f the data shrink the variance to
1 / (1 + f) of the prior's. Where f < 1 the data say less than was believed before a single sample
came: that direction counts as not determined, or open.

An open direction is *inherent* when random postures over the joint ranges leave it open too: then
no motion can close it, only another sense or a measured frame. Otherwise other postures would.

A parameter is named in a direction by the effect that its part alone would have on what is seen,
|v_i| sqrt(F_ii): in an open direction these effects cancel. Inherent directions that are a plain
motion of the geometry (a joint slides along its axis) are named so, see `invisible`; for the rest a
sparse basis (column-pivoted reduction in effect units) names few parameters at a time. The roots of
a load are called by what they stand for: mass, centre of mass, moments of inertia. At rest the last
do nothing, so that only motion tells them, whatever the postures.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import qr, solve_triangular

from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.invisible import invisible_motions, take_out
from bodyschema.estimation.normal_equations import information, whiten
from bodyschema.model.kernels import PRISMATIC
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]

SAYS_LITTLE = 1.0
"""Information in units of the prior below which a direction is open."""

NAMED_SHARE = 0.1
"""A parameter is named in a direction when its effect is at least this share of the largest."""

RANDOM_POSTURES = 200

LISTED = 5
"""Names that a sentence spells out."""

MOMENTS = "moments of inertia"
SAID = {"alpha": "the mass", **dict.fromkeys(("t1", "t2", "t3"), "the centre of mass")}
"""What a root of a load stands for, see `model.inertia`; the other six are MOMENTS."""


@dataclass(frozen=True)
class OpenDirection:
    """A combination of parameters that the data do not determine."""

    members: tuple[str, ...]
    """Names of the parameters that go together; one alone has no effect at all."""
    inherent: bool
    """No motion can close it."""
    sentence: str


@dataclass(frozen=True)
class Identifiability:
    """The directions of parameter space that the data leave open."""

    rank: int
    """Number of directions that the data determine."""
    directions: tuple[OpenDirection, ...]
    """Those that other postures would close come first."""
    open_share: Array
    """(n_parameters,) share of each parameter's prior variance that lies in open directions."""

    @property
    def sentences(self) -> tuple[str, ...]:
        """What is open, each sentence once: all moments of inertia of a load share one."""
        return tuple(dict.fromkeys(direction.sentence for direction in self.directions))

    def partners(self, name: str) -> tuple[str, ...]:
        """Variables that one cannot be told apart from; empty when it is determined."""
        together = {m for d in self.directions if name in d.members for m in d.members}
        return tuple(sorted(together - {name}))


def identifiability(fit: Estimate, senses: Sequence[Sense], seed: int = 0) -> Identifiability:
    """Rank and named open directions of a fit.

    Args:
        fit: of a body to the senses.
        senses: what was seen.
        seed: of the random postures.
    """
    if not len(fit.variables):
        return Identifiability(0, (), np.zeros(0))
    return from_information(fit, _information_at_random(fit, senses, seed))


def from_information(
    estimate: Estimate, at_random: Array, least: float = SAYS_LITTLE
) -> Identifiability:
    """Rank and named open directions of an estimate, whatever the data were.

    Args:
        estimate: with the information of the data.
        at_random: (n_parameters, n_parameters) what as many data of random postures would bring.
        least: information in units of the prior below which a direction is open.
    """
    variables = estimate.variables
    D = variables.scale
    F = D[:, None] * estimate.data_information * D
    inherent_F = D[:, None] * at_random * D
    values, vectors = np.linalg.eigh(F)
    null = vectors[:, values < least].T
    always, effect = _open_space(inherent_F, least), np.sqrt(np.diag(inherent_F))
    practical = _sparse_basis(_remainder(null, always), effect)
    directions = [_direction(variables, row, False) for row in practical]
    shared = _intersection(null, always)
    directions += named_directions(estimate.reference, variables, shared, effect)
    share = np.sum(null**2, axis=0)
    return Identifiability(int(np.sum(values >= least)), tuple(directions), share)


def named_directions(
    body: Body, variables: Variables, space: Array, effect: Array
) -> list[OpenDirection]:
    """Words for a space of inherent directions.

    Args:
        body: whose parameters they are.
        variables: what the columns mean.
        space: (k, n_parameters) orthonormal rows, in units of the prior.
        effect: (n_parameters,) what each parameter alone does to what is seen.

    Returns:
        k directions: plain motions first.
    """
    motions, rest = take_out(space, invisible_motions(body, variables), variables.scale)
    plain = [
        OpenDirection(
            tuple(variables.names[i] for i in np.flatnonzero(motion.row)), True, motion.sentence
        )
        for motion in motions
    ]
    return plain + [_direction(variables, row, True) for row in _sparse_basis(rest, effect)]


def random_postures(body: Body, n: int, rng: np.random.Generator) -> Array:
    """Postures uniform over the joint ranges, (n, n_joints); +-pi or +-0.5 m where unlimited.

    A joint with one limit alone moves as far from there, at least.
    """
    shifts = np.isin(np.arange(len(body.joints)), body.driver[body.kind == PRISMATIC])
    reach = np.where(shifts, 0.5, np.pi)
    lower, upper = np.isfinite(body.lower), np.isfinite(body.upper)
    low = np.where(lower, body.lower, np.where(upper, np.fmin(-reach, body.upper - reach), -reach))
    high = np.where(upper, body.upper, np.where(lower, np.fmax(reach, body.lower + reach), reach))
    return np.asarray(rng.uniform(low, high, size=(n, len(body.joints))))


def _information_at_random(fit: Estimate, senses: Sequence[Sense], seed: int) -> Array:
    """Information of as many samples at random postures, (n_parameters, n_parameters)."""
    estimate = fit
    q = random_postures(estimate.body, RANDOM_POSTURES, np.random.default_rng(seed))
    total = np.zeros_like(estimate.data_information)
    for sense, level in zip(senses, fit.levels, strict=True):
        ideal = sense.imagined(estimate.body, q)
        part = whiten(ideal, estimate.reference, estimate.variables, estimate.x)
        H, _ = information([part], [level], [np.ones(len(ideal))])
        total += H * max(len(sense), 1) / max(len(ideal), 1)
    return total


def _open_space(F: Array, least: float) -> Array:
    values, vectors = np.linalg.eigh(F)
    return np.asarray(vectors[:, values < least].T)


def _intersection(null: Array, always: Array) -> Array:
    """Orthonormal rows that span what both row spaces share (principal angles near zero)."""
    U, cosines, _ = np.linalg.svd(null @ always.T)
    return np.asarray(U[:, : len(cosines)].T[cosines > 0.9] @ null)


def _remainder(null: Array, always: Array) -> Array:
    """Orthonormal rows of the first space that are not in the second."""
    U, cosines, _ = np.linalg.svd(null @ always.T)
    padded = np.zeros(len(null))
    padded[: len(cosines)] = cosines
    return np.asarray(U.T[padded <= 0.9] @ null)


def _sparse_basis(null: Array, effect: Array) -> Array:
    """Rows that span the same space as `null`, with one pivot column each, in effect units.

    Column-pivoted QR picks the columns that carry the space best; solving for them leaves a unit
    matrix there, so that every row names one pivot and what moves along with it.
    """
    if not len(null):
        return null
    # A parameter without any effect still has to be named, alone: give it a small one.
    weighted = null * np.maximum(effect, 1e-3)
    _, R, order = qr(weighted, pivoting=True, mode="economic")
    k = len(null)
    rows = np.zeros_like(null)
    rows[:, order[:k]] = np.eye(k)
    rows[:, order[k:]] = solve_triangular(R[:, :k], R[:, k:])
    return np.asarray(rows / np.abs(rows).max(axis=1, keepdims=True))


def _direction(variables: Variables, row: Array, inherent: bool) -> OpenDirection:
    members = [i for i in range(len(row)) if abs(row[i]) >= NAMED_SHARE]
    names = tuple(variables.names[i] for i in members)
    words = dict.fromkeys(_said(variables.names[i], variables.groups[i]) for i in members)
    return OpenDirection(names, inherent, _sentence(names, tuple(words), inherent))


def _said(name: str, group: str) -> str:
    if not group.startswith("load:"):
        return name
    load, _, root = name.rpartition(".")
    return f"{SAID.get(root, MOMENTS)} of {load}"


def _sentence(names: tuple[str, ...], words: tuple[str, ...], inherent: bool) -> str:
    shown = _listed(words)
    if len(words) == 1 and shown.startswith(MOMENTS):
        return (
            f"{shown} had too little effect: only turning shows them, and what carries the load "
            "hardly turned or stood still; swing it about all axes, with quick changes of speed."
        )
    if len(words) == 1 and inherent:
        return f"{shown} has no effect on what was seen; only another sense can tell it."
    joints = sorted({name.split(".")[0] for name in names if name.endswith((".offset", ".gear"))})
    if not inherent:
        movers = _listed(joints or sorted({name.split(".")[0] for name in names}))
        verb = "had too little effect" if len(words) == 1 else "could not be told apart"
        return f"{shown} {verb} in these postures; rotate {movers} further to determine them."
    frames = sorted({name.split(".")[0] for name in names if ".turn_" in name})
    remedy = f"measure how '{frames[0]}' is mounted" if frames else "fix one of them as modelled"
    return (
        f"{shown} cannot be told apart by any motion, only their combination is known; "
        f"{remedy} to separate them."
    )


def _listed(names: Sequence[str]) -> str:
    """ "a", "a and b", "a, b and c", or the first few and how many more."""
    if len(names) > LISTED + 1:
        return f"{', '.join(names[:LISTED])} and {len(names) - LISTED} more"
    return " and ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
