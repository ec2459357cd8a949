"""Refitted: neighbours that only show once the joints' zeros are fitted too.

Zeros that are a few degrees off hide a board that is a tenth too large: its lengths explain little
more than they do. With the zeros fitted under each declaration, and the number of a scale or a gear
taken anew from what that leaves, the right one is left with noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.problem import Problem
from bodyschema.model.kernels import OFFSET
from bodyschema.seeds.open_chain import OpenChain
from bodyschema.seeds.spread import spread
from bodyschema.senses.sense import Sense
from bodyschema.trust.declarations import AS_DECLARED, Declaration
from bodyschema.trust.neighbours import DOUBTFUL, EXPLAINS, FACTOR, Neighbour, Neighbourhood, named
from bodyschema.trust.trials import Trial, Trials

Array = NDArray[np.float64]

MOST = 300
"""Moments of a sense that are fitted; of a longer recording rows are no neighbours any more."""

TURNS, LEAST_GAIN = 4, 0.05
"""Fits by turns of the zeros and of a number of the declaration, while the score gains so much."""


def refitted(problem: Problem, found: Neighbourhood) -> tuple[Neighbour, ...]:
    """Neighbours as they are with the zeros fitted under each; none where none is to be named.

    Args:
        problem: the recording as declared.
        found: its neighbours, or else declarations that explain it a little better.
    """
    chains = OpenChain.all_of(problem.body, problem.senses)
    problem = _told_by(problem, chains)
    close = tuple(n.declaration for n in found.neighbours) or found.close
    if max(len(chain.q) for chain in chains) > MOST:
        close = tuple(declaration for declaration in close if not declaration.shift)
    if not close:
        return found.neighbours
    tried = Trials(problem.body, OpenChain.all_of(problem.body, problem.senses))
    pairs = [_alone(problem, tried, declaration) for declaration in (AS_DECLARED, *close)]
    # A fit as declared may be local: the zeros of the others are tried for it too.
    own = min((own for own, _ in pairs), key=lambda trial: trial.score)
    trials = sorted((trial for _, trial in pairs[1:]), key=lambda trial: trial.score)
    better = float(np.exp(own.score - trials[0].score))
    if better < FACTOR or trials[0].share > EXPLAINS:
        # With its own zeros the recording fits as it is declared; or the fits are local.
        return () if own.share <= DOUBTFUL else found.neighbours
    return named(own, trials, tried.chains)


def _told_by(problem: Problem, chains: Sequence[OpenChain]) -> Problem:
    """The problem of the senses that have chains, and of their frames alone."""
    labels = [chain.label for chain in chains]
    senses = tuple(spread(sense, MOST) for sense in problem.senses if sense.label in labels)
    ends = {frame for sense in senses for pair in sense.pairs for frame in pair}
    frames = {frame: known for frame, known in problem.frames.items() if frame in ends}
    return replace(problem, senses=senses, frames=frames)


def _alone(problem: Problem, tried: Trials, declaration: Declaration) -> tuple[Trial, Trial]:
    """What is left as declared and under a declaration, with the zeros fitted under it."""
    best: tuple[Trial, Trial] | None = None
    for _ in range(TURNS):
        senses = tuple(declaration.of(sense) for sense in problem.senses)
        there = replace(tried, offset=_zeros(problem, senses))
        own, trial = there.of([AS_DECLARED, declaration])
        if best is not None and trial.score > best[1].score - LEAST_GAIN:
            break
        best = own, trial
        finer = there.finer(declaration)
        if finer is None:
            break
        declaration = finer
    assert best is not None
    return best


def _zeros(problem: Problem, senses: Sequence[Sense]) -> Array:
    """(n_joints,) offsets that fit the senses."""
    variables = problem.variables(("offsets",))
    found = problem.fit(variables, senses)
    offset = np.zeros(len(problem.body.joints))
    at = variables.code == OFFSET
    offset[variables.index[at]] = found.x[at]
    return offset
