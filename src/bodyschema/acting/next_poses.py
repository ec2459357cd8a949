"""The next poses: those that most reduce the error of the tool, or open a null direction.

Candidates come from `candidates`, their worth from `information_gain`; they are taken greedily, so
that the first n poses of a longer plan are the plan of n. Predicted errors use the covariance that
the belief would have after each pose, by `prediction.length_quantile`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.acting.candidates import Candidates, find_candidates
from bodyschema.acting.information_gain import (
    Criterion,
    Pair,
    believed_information,
    covariance_of,
    expected_jacobians,
    greedy,
    tool_jacobians,
)
from bodyschema.errors import InputError
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import SAYS_LITTLE
from bodyschema.estimation.prediction import length_quantile
from bodyschema.senses.sense import Sense
from bodyschema.threads import one_thread

Array = NDArray[np.float64]

CANDIDATES = 4000
DRAWS = 10
"""Random plans that the plan is compared with."""

PROBABILITY = 0.95

SAME_POSTURE = 1e-3
"""rad or m: postures nearer than that are one; a robot's own repeatability is about that."""

TOLD_APART = 0.1
"""Share of a parameter's prior variance that a plan must take out of open directions to tell it."""


@dataclass(frozen=True)
class Plan:
    """Poses to take next, the most telling first."""

    q: Array
    """(n, n_joints) rad and m, in the order of `body.joints`."""
    joints: tuple[str, ...]
    """The joints that differ; all others stay where they are."""
    pairs: tuple[Pair, ...]
    """(seen_from, seen): where the tool error counts."""
    error: Array
    """(n + 1,) m: 95 % of the tool errors should stay below this, before and after each pose."""
    random_error: Array
    """(n + 1,) m: the same for candidates taken at random, mean over a few draws."""
    rank: tuple[int, ...]
    """(n + 1,) number of directions that are determined, before and after each pose."""
    most: int
    """The rank that all candidates together would reach."""
    n_parameters: int
    told: tuple[str, ...]
    """Variables that the plan takes out of open directions, the most changed first."""
    n_candidates: int


@one_thread
def plan_poses(
    estimate: Estimate,
    senses: Sequence[Sense],
    n: int = 10,
    *,
    candidates: Candidates | None = None,
    pairs: Sequence[Pair] = (),
    criterion: Criterion = "tool",
    seed: int = 0,
) -> Plan:
    """Choose the next poses.

    Args:
        estimate: what is believed now, with noise levels.
        senses: what was seen; their postures bound the view, their number the confidence. Senses
            without samples do for both.
        n: number of poses.
        candidates: postures to choose from; drawn within limits and the recorded view when None.
        pairs: (seen_from, seen) of the tool; those of the senses when empty.
        criterion: "tool" for the least tool error, "all" for all parameters alike.
        seed: of the candidates and the random comparison.

    Raises:
        InputError: nothing to plan, or no posture to choose from.
    """
    if n < 1:
        raise InputError(f"a plan of {n} poses was asked for; ask for at least 1.")
    if not len(estimate.variables):
        raise InputError("the estimate has no free parameters; there is nothing to learn.")
    rng = np.random.default_rng(seed)
    if candidates is None:
        candidates = find_candidates(estimate.body, senses, CANDIDATES, rng)
    candidates = _distinct(candidates)
    if len(candidates.q) < n:
        raise InputError(
            f"only {len(candidates.q)} postures can be taken and seen; ask for fewer than {n}, "
            "or look beyond the recorded view with --anywhere."
        )
    ends = tuple(pairs) or tuple(dict.fromkeys(p for s in senses for p in s.pairs))
    J = expected_jacobians(estimate, senses, candidates.q, candidates.visible)
    E = tool_jacobians(estimate, ends, candidates.work)
    F = believed_information(estimate)
    numbers = float(sum(len(sense) * len(sense.covariance) for sense in senses)) or np.inf
    W = np.einsum("kai,kaj->ij", E, E) / len(E) if criterion == "tool" else None
    chosen = greedy(F, J, W, n)
    told, rank = _told(F, J[chosen], estimate.variables.names)
    draws = [rng.choice(len(J), n, replace=False) for _ in range(DRAWS)]
    return Plan(
        q=candidates.q[chosen],
        joints=candidates.joints,
        pairs=ends,
        error=_errors(F, J[chosen], E, numbers),
        random_error=np.mean([_errors(F, J[draw], E, numbers) for draw in draws], axis=0),
        rank=rank,
        most=_rank(F + np.einsum("kai,kaj->ij", J, J)),
        n_parameters=len(estimate.variables),
        told=told,
        n_candidates=len(candidates.q),
    )


def _distinct(candidates: Candidates) -> Candidates:
    """Each posture once, in the same order: to take one again tells nothing new of the body."""
    cells = np.round(candidates.q / SAME_POSTURE).astype(np.int64)
    first = np.sort(np.unique(cells, axis=0, return_index=True)[1])
    return replace(candidates, q=candidates.q[first], visible=candidates.visible[first])


def _errors(F: Array, J: Array, E: Array, numbers: float) -> Array:
    """Predicted 95 % tool error before and after each of the postures J, (n + 1,) m.

    Args:
        F: (N, N) information of the belief.
        J: (n, d, N) whitened Jacobians of the postures, in order.
        E: (k, 3, N) tool Jacobians over the work.
        numbers: that the noise level was learned from; inf when it is known.
    """
    found = []
    for i in range(len(J) + 1):
        now = F + np.einsum("kai,kaj->ij", J[:i], J[:i])
        freedom = max(numbers + J[:i].size / J.shape[2] - _rank(now), 1.0)
        covariances = E @ covariance_of(now) @ np.swapaxes(E, 1, 2)
        found.append(length_quantile(list(covariances), freedom, PROBABILITY))
    return np.array(found)


def _rank(F: Array) -> int:
    """Directions in which the data, F less the prior's 1, say more than the prior did."""
    return int(np.sum(np.linalg.eigvalsh(F) >= 1 + SAYS_LITTLE))


def _told(F: Array, J: Array, names: Sequence[str]) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """Variables that leave open directions, and the rank before and after each pose."""
    steps = [F, *(F + np.cumsum(np.swapaxes(J, 1, 2) @ J, axis=0))]
    less = _open_share(steps[0]) - _open_share(steps[-1])
    order = [i for i in np.argsort(-less, kind="stable") if less[i] >= TOLD_APART]
    return tuple(names[i] for i in order), tuple(_rank(step) for step in steps)


def _open_share(F: Array) -> Array:
    """Share of each parameter's prior variance that lies in open directions, (N,)."""
    values, vectors = np.linalg.eigh(F)
    return np.asarray(np.sum(vectors[:, values < 1 + SAYS_LITTLE] ** 2, axis=1))
