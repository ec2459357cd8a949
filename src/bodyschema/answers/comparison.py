"""Comparison: what differs between two results of one robot, by how much, and what it moves.

Which parts differ is found in `differing_parts`. What that means is said where the robot was wanted
right: the places of what was seen, over the joints' limits.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.answers.common_ground import CommonGround
from bodyschema.answers.comparable import LOADS, refuse_unlike
from bodyschema.answers.compared_loads import loads_compared
from bodyschema.answers.compared_part import ComparedPair, ComparedPart
from bodyschema.answers.differing_parts import Differing
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import random_postures
from bodyschema.judging.calibration import Calibration
from bodyschema.model.kinematics import relative_pose_derivatives
from bodyschema.trust.target import length_95

Array = NDArray[np.float64]

FALSE_ALARM = 0.01
"""Chance of calling two results of one robot different."""

POSTURES, DRAWS = 100, 200
"""Of the robot, over its joints' limits; and of a part's difference, for its 95 %."""


@dataclass(frozen=True)
class Comparison:
    """Two results of one robot, side by side."""

    p_value: float
    """Chance of so much difference if nothing has changed; the number of parts counted in."""
    parts: tuple[ComparedPart, ...]
    """Those that differ first, then the others, clearest first."""
    pairs: tuple[ComparedPair, ...]
    """What was seen in both results, and what the difference means there."""
    unexplained: bool = False
    """More differs than the named parts explain."""
    notes: tuple[str, ...] = field(default_factory=tuple)
    """What is not compared, and why; a sentence each."""

    @property
    def same(self) -> bool:
        """Whether nothing differs beyond chance."""
        return not self.unexplained and not any(part.differs for part in self.parts)


def compare(
    first: Calibration, second: Calibration, false_alarm: float = FALSE_ALARM
) -> Comparison:
    """Compare two answers of one robot.

    Args:
        first: an answer, such as that of Monday.
        second: a later one.
        false_alarm: chance of calling two results of one robot different.

    Raises:
        InputError: they are of two robots, or have nothing in common that could be compared.
    """
    refuse_unlike(first, second)
    if getattr(first, "verb", "") in LOADS:
        parts, p_value = loads_compared(first, second, false_alarm)
        return Comparison(p_value, parts, (), notes=_notes(first, second, None))
    ground = CommonGround.of(first.widened, second.widened)
    blamed = Differing.of(ground, false_alarm / 2)
    pairs = tuple(_pairs(first, second, ground, blamed.left))
    parts = tuple(_with_effect(part, first, ground, pairs) for part in blamed.parts)
    p_value = min(1.0, 2 * min([blamed.p_value, *(part.p_value for part in parts)]))
    notes = _notes(first, second, ground)
    return Comparison(p_value, parts, pairs, blamed.p_value_left < false_alarm / 2, notes)


def _pairs(
    first: Calibration, second: Calibration, ground: CommonGround, left: Array
) -> Iterator[ComparedPair]:
    """What was seen in both, and how far it lies apart."""
    one, other = first.widened, second.widened
    q = random_postures(one.body, POSTURES, np.random.default_rng(0))
    there = [other.body.joints.index(joint) for joint in one.body.joints]
    q_other = np.empty_like(q)
    q_other[:, there] = q
    nothing = np.zeros(len(ground.variables))
    for a, b in _shared_pairs(first, second):
        at = relative_pose_derivatives(one.reference, one.variables, one.x, q, a, b)
        by = relative_pose_derivatives(other.reference, other.variables, other.x, q_other, a, b)
        moved = by.pose[:, :3, 3] - at.pose[:, :3, 3]
        turned = np.swapaxes(at.pose[:, :3, :3], 1, 2) @ by.pose[:, :3, :3]
        angle = np.arccos(np.clip((np.trace(turned, axis1=1, axis2=2) - 1) / 2, -1, 1))
        chance, chance_turned = _by_chance((one, at.by_parameter), (other, by.by_parameter))
        D = relative_pose_derivatives(one.body, ground.variables, nothing, q, a, b)
        rest = D.by_parameter[:, :3] @ left
        yield ComparedPair(
            a, b, length_95(moved), float(np.quantile(angle, 0.95)), chance, chance_turned,
            length_95(rest), q,
        )  # fmt: skip


def _by_chance(*beliefs: tuple[Estimate, Array]) -> tuple[float, float]:
    """m and rad: what 95 % of postures lie apart stays below this with 95 %, if nothing changed.

    Args:
        beliefs: each with the derivatives of the pose by its variables, (n, 6, n_parameters).
    """
    rng, apart = np.random.default_rng(0), np.zeros(())
    for belief, J in beliefs:
        x = rng.multivariate_normal(np.zeros(len(belief.x)), belief.covariance, DRAWS)
        apart = apart + J @ x.T  # (n, 6, DRAWS), of one sign as good as of the other
    sizes = [np.linalg.norm(apart[:, part], axis=1) for part in (slice(0, 3), slice(3, 6))]
    at, turned = (float(np.quantile(np.quantile(s, 0.95, axis=0), 0.95)) for s in sizes)
    return at, turned


def _shared_pairs(first: Calibration, second: Calibration) -> list[tuple[str, str]]:
    own, other = (
        dict.fromkeys([*one.wanted, *((e.seen_from, e.seen) for e in one.predicted)])
        for one in (first, second)
    )
    return [pair for pair in own if pair in other and pair[0] != pair[1]]


def _with_effect(
    part: ComparedPart, first: Calibration, ground: CommonGround, pairs: Sequence[ComparedPair]
) -> ComparedPart:
    """A part with what its difference moves, at the pair where that is most, and its 95 %."""
    rows = [ground.variables.names.index(name) for name in part.names]
    variables, nothing = ground.variables.take(rows), np.zeros(len(rows))
    drawn = np.random.default_rng(0).multivariate_normal(
        part.change, part.covariance, DRAWS, check_valid="ignore"
    )
    found = [(0.0, 0.0, 0.0)]
    for pair in pairs:
        J = relative_pose_derivatives(
            first.body, variables, nothing, pair.q, pair.seen_from, pair.seen
        ).by_parameter[:, :3]
        sizes = np.quantile(np.linalg.norm(J @ drawn.T, axis=1), 0.95, axis=0)
        low, high = np.quantile(sizes, [0.025, 0.975])
        found.append((length_95(J @ part.change), float(low), float(high)))
    effect, low, high = max(found)
    return replace(part, effect=effect, effect_low=low, effect_high=high)


def _notes(first: Calibration, second: Calibration, ground: CommonGround | None) -> tuple[str, ...]:
    """What to know of the comparison, a sentence each."""
    said = [
        f"The {which} result is {one.trust.level}: {one.trust.reasons[0]}"
        for which, one in (("first", first), ("second", second))
        if one.trust.level != "good" and one.trust.reasons
    ]
    if ground is None:
        return tuple(said)
    for which, other, only in (
        ("first", "second", ground.first_only), ("second", "first", ground.second_only)
    ):  # fmt: skip
        if only:
            some = ", ".join(only[:6]) + (" ..." if len(only) > 6 else "")
            said.append(
                f"The {other} result holds numbers of {some} as described, which the {which} has "
                "free; what is compared there is its description."
            )
    return tuple(said)
