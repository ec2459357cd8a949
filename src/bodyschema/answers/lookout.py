"""Lookout: whether a recording is what it is declared to be, before and after it is fitted.

Before: is there another declaration under which it would fit far better (`trust.neighbours`,
`trust.refitted`)? If not, and no placement of the frames explains it, joint zeros may be wrong by
up to half a turn: a search says where the fit begins. After: is what is left small against what
was seen (`trust.plausibility`), and may the fit be local?
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from bodyschema.estimation.problem import Problem
from bodyschema.judging.calibration import Calibration
from bodyschema.model.tree import Body
from bodyschema.seeds.zero_search import EXPLAINED, search_zeros
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.points import Points
from bodyschema.senses.poses import Poses
from bodyschema.senses.sense import Sense
from bodyschema.trust.declarations import Recorded
from bodyschema.trust.neighbours import DOUBTFUL, Neighbour, neighbourhood
from bodyschema.trust.plausibility import left_share, misdeclared, plausible, refuse_beyond
from bodyschema.trust.refitted import refitted
from bodyschema.trust.trust import Trust

FAR = 0.17
"""rad; zeros that a search moves by less are a fit's to find."""

TOLD = np.deg2rad(20)
"""Zeros further from the description are told of."""


@dataclass(frozen=True)
class Lookout:
    """What was seen of a recording before it was fitted."""

    body: Body
    share: float
    """Largest median residual over median spread with the joints as described."""
    named: tuple[Neighbour, ...] = ()
    """Declarations under which it would fit far better."""

    @classmethod
    def at(cls, problem: Problem, run: Mapping[str, Any], fits: bool) -> Self:
        """Look at a recording.

        Args:
            problem: as declared.
            run: what was asked, which says how; see `run_file`.
            fits: whether joints may be fitted to find out.

        Raises:
            InputError: what was seen spreads over many times what the robot can reach.
        """
        unit = run.get("joints", {}).get("unit", "")
        declared = recorded(run, problem.senses)
        found = neighbourhood(problem.body, problem.senses, declared, joint_unit=unit)
        named = found.neighbours
        refuse_beyond(problem.body, problem.senses, named)
        geometric = all(isinstance(s, Points | Poses | Pixels) for s in problem.senses)
        if fits and geometric and (named or found.close):
            named = refitted(problem, found)
        if named and "gears" in (run.get("free", {}).get("groups") or ()):
            first = named[0].declaration
            named = () if first.joint >= 0 and first.factor > 0 else named  # the fit finds gears
        return cls(problem.body, found.share, named)

    @property
    def far_off(self) -> bool:
        """Whether neither the description nor another declaration explains the recording."""
        return self.share > DOUBTFUL and not self.named

    def trust(self, found: Calibration, senses: Sequence[Sense]) -> Trust:
        """How far an answer may be believed."""
        if self.named:
            return misdeclared(self.named)
        trust = plausible(self.body, senses, found.residuals)
        left = left_share(self.body, senses, found.residuals)
        if self.far_off and left > EXPLAINED:
            local = (
                f"This fit may be local: as described the robot leaves {100 * self.share:.0f} % of "
                f"what was seen unexplained and after the fit still {100 * left:.0f} %; give rough "
                "joint zeros, or record more postures."
            )
            trust = trust.also(Trust("limited", (local,)))
        return trust


def recorded(run: Mapping[str, Any], senses: Sequence[Sense]) -> dict[str, Recorded]:
    """How a run file declares each sense, by its label."""
    entries = {
        (e["kind"], e["seen_from"], e["seen"]): Recorded(
            e["layout"] if e["kind"] == "poses" else "", e["unit"] or "m", e["angle_unit"] or "rad"
        )
        for e in run.get("senses", ())
    }
    named = ((s.label, (type(s).__name__.lower(), s.seen_from, s.seen)) for s in senses)
    return {label: entries[key] for label, key in named if key in entries}


def with_zeros(problem: Problem, models: Sequence[tuple[str, ...]], seed: int) -> Problem:
    """The problem with joints that begin at zeros which a search has found, if it has.

    Args:
        problem: whose zeros may be far off.
        models: that will be fitted; without offsets there are no zeros to find.
        seed: of the search.
    """
    if not any("offsets" in model for model in models):
        return problem
    found = search_zeros(problem.body, problem.senses, problem.joints, seed)
    if found is None or not found.found or np.abs(found.offset).max() < FAR:
        return problem
    joints = zip(problem.body.joints, found.offset, strict=True)
    return replace(problem, zeros={joint: float(zero) for joint, zero in joints if zero})


def far_zeros(found: Calibration) -> tuple[str, ...]:
    """A sentence about joint zeros that are far from the description; none if none is."""
    values = zip(found.fit.variables.names, found.fit.variables.units, found.fit.x, strict=True)
    far = [
        f"{name.removesuffix('.offset')} {np.rad2deg(x):+.1f} deg"
        for name, unit, x in values
        if name.endswith(".offset") and unit == "rad" and abs(x) > TOLD
    ]
    if not far:
        return ()
    return (
        f"Joint zeros are far from the description: {', '.join(far)}. Look whether the zeros are "
        "those of the robot's controller, and whether the description is of this robot.",
    )
