"""Neighbours: under which other declaration of a recording it would have fitted the robot.

What one sense saw, and the kinematics between the parents of its two frames, leave residuals that
no placement of the frames explains (`seeds.frame_fits`). Under every declaration h (`trials`)

    score(h) = sum of log(median residual / median spread) over positions and rotations

so that exp(score - score(h)) is by how much better h explains the recording. The best is named when
it is better by `FACTOR`, explains the recording at all, and wrong joint zeros do not explain it as
well; all that it does not beat by `ALIKE` are named with it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bodyschema.model.tree import Body
from bodyschema.seeds.open_chain import OpenChain, moved
from bodyschema.seeds.zero_search import search_zeros
from bodyschema.senses.sense import Sense
from bodyschema.trust.declarations import AS_DECLARED, Declaration, Recorded
from bodyschema.trust.trials import Trial, Trials

FACTOR = 2.0
"""By which a neighbour must explain the recording better to be named."""

LARGE = 3.0
"""The same where the recording is plausible as it is declared."""

ALIKE = 1.3
"""Neighbours that the best does not beat by this factor are named with it."""

EXPLAINS = 0.2
"""Median residual over median spread up to which a neighbour explains a recording at all."""

DOUBTFUL = 0.12
"""The same above which a recording is not plausible as it is declared."""

CLOSE, CLOSEST = 1.1, 3
"""Factor from which neighbours that are not named are worth a fit, and how many of them; a scale is
always, as joint zeros hide it best."""


@dataclass(frozen=True)
class Neighbour:
    """A declaration that explains a recording better than its own."""

    declaration: Declaration
    factor: float
    """By which it is better."""
    before: tuple[float, float]
    """m and rad: median residual as declared; 0 rad where the sense has no rotations."""
    after: tuple[float, float]
    """The same under this declaration."""

    @property
    def words(self) -> str:
        """As they follow "with"."""
        return self.declaration.words

    @property
    def entry(self) -> str:
        """To write in the run file; "" where it has no word for it."""
        return self.declaration.entry

    def senses(self, senses: Sequence[Sense]) -> tuple[Sense, ...]:
        """The senses as they would be."""
        return tuple(self.declaration.of(sense) for sense in senses)


@dataclass(frozen=True)
class Neighbourhood:
    """How well a recording fits as it is declared, and what would fit better."""

    share: float
    """Largest median residual over median spread, of any sense's positions and rotations."""
    neighbours: tuple[Neighbour, ...] = ()
    """Best first; none where nothing is to be named."""
    close: tuple[Declaration, ...] = ()
    """Others that fit a little better, which only fits of the joints can tell; see `refitted`."""


def neighbours(
    body: Body,
    senses: Sequence[Sense],
    declared: Mapping[str, Recorded] | None = None,
    robot: Recorded | None = None,
    joint_unit: str = "",
) -> tuple[Neighbour, ...]:
    """The declarations under which a recording would fit much better than as it is declared.

    Args:
        body: as described, all frames attached; or a free hand.
        senses: what was seen; points, poses and pictures of boards count.
        declared: how each sense is declared, by its label.
        robot: how the poses of a free hand are declared; None for a robot with joints.
        joint_unit: of the joints' columns, as declared.
    """
    return neighbourhood(body, senses, declared, robot, joint_unit).neighbours


def neighbourhood(
    body: Body,
    senses: Sequence[Sense],
    declared: Mapping[str, Recorded] | None = None,
    robot: Recorded | None = None,
    joint_unit: str = "",
) -> Neighbourhood:
    """See `neighbours`."""
    chains = OpenChain.all_of(body, senses)
    if not chains:
        return Neighbourhood(0.0)
    tried = Trials(body, chains, declared or {}, robot, joint_unit)
    own, *rest = tried.tried()
    rest = sorted(rest, key=lambda trial: trial.score)
    factor = float(np.exp(own.score - rest[0].score))
    least = FACTOR if own.share > DOUBTFUL else LARGE
    explained = factor >= least and rest[0].share <= EXPLAINS
    if explained and (robot is not None or not _zeros_explain(tried, senses, rest[0])):
        return Neighbourhood(own.share, named(own, rest, chains))
    close: dict[str, Declaration] = {}
    for trial in rest:
        better = trial.score < own.score - np.log(CLOSE) and len(close) < CLOSEST
        if better or trial.declaration.key == "scale":
            close.setdefault(trial.declaration.key, trial.declaration)
    return Neighbourhood(own.share, (), tuple(close.values()))


def named(
    own: Trial, trials: Sequence[Trial], chains: Sequence[OpenChain]
) -> tuple[Neighbour, ...]:
    """The best of some trials, and those that it does not beat; one of each key.

    Args:
        own: as declared.
        trials: best first.
        chains: of the senses.
    """
    found: dict[str, Neighbour] = {}
    for trial in trials:
        alike = trial.score < trials[0].score + np.log(ALIKE)
        if alike and trial.declaration.key not in found:
            better, c = float(np.exp(own.score - trial.score)), trial.about(chains)
            before, after = own.residual[c], trial.residual[c]
            found[trial.declaration.key] = Neighbour(trial.declaration, better, before, after)
    return tuple(found.values())


def _zeros_explain(tried: Trials, senses: Sequence[Sense], best: Trial) -> bool:
    """Whether joint zeros explain the recording about as well as a declaration."""
    joints = [tried.body.joints[j] for j in moved(tried.chains)]
    found = search_zeros(tried.body, senses, joints, restarts=0)
    if found is None or not found.found:
        return False
    there = replace(tried, offset=found.offset).of([AS_DECLARED])[0]
    return bool(there.score < best.score + np.log(FACTOR))
