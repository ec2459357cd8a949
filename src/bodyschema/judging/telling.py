"""Do senses that see no positions tell where the robot's limbs are?

A height over a table, a distance or the direction of gravity can be explained better and better by
a body whose hand is farther off than before: held-out errors of such a sense vouch for what it
sees, not for the hand. What the correction moves is therefore compared with how far the estimate
itself says that it may be off, both at random postures and both up to a rigid motion of the frame
that looks, which nobody may care about:

    moved   rms |p' - (R p + t)|   p, p' places as modelled and as corrected, (R, t) their best fit
    stated  rms of J C J^T         J without the rigid motions, C the covariance, largest model

A correction that is not TELLING times as large as what is stated to be left tells nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.estimation.estimate import Estimate
from bodyschema.model.kinematics import relative_pose, relative_pose_derivatives
from bodyschema.seeds.closed_forms import align_points
from bodyschema.senses.sense import Sense
from bodyschema.trust.target import targets
from bodyschema.trust.weighing import Weighing
from bodyschema.units import shown

Array = NDArray[np.float64]

TELLING = 2.0
"""Corrections over what is stated to be left of the error, below which they tell nothing."""


@dataclass(frozen=True)
class Telling:
    """What a correction moves between two frames of the robot, and how well that is known."""

    seen_from: str
    seen: str
    moved: float
    """m, rms."""
    stated: float
    """m, rms: one standard deviation of what is left."""

    @property
    def tells(self) -> bool:
        """Whether the correction is larger than its own uncertainty."""
        return self.moved > TELLING * self.stated


def untold(fit: Estimate, fullest: Estimate, senses: Sequence[Sense], q: Array) -> Telling | None:
    """What the senses do not tell, though the fit may suit them better; None if they do.

    Args:
        fit: of a body to the senses; at x = 0 the robot is as modelled.
        fullest: of the largest model that was tried: what a smaller one holds for exact, only
            because it helped no sense, may be wrong all the same.
        senses: what was seen. Where one of them sees positions, its held-out error speaks.
        q: (n, n_joints) postures in which the robot is to be right.
    """
    if sees_positions(senses):
        return None
    found = [_telling(fit, fullest, a, b, q) for a, b in _robot_pairs(fit, senses)]
    if not found or any(telling.tells for telling in found):
        return None
    return max(found, key=lambda telling: telling.stated)


def unhelped(
    fit: Estimate, weighing: Weighing, senses: Sequence[Sense], wanted: Sequence[tuple[str, str]]
) -> str:
    """Why a correction does no good where the robot is wanted to be right; "" if it does.

    It moves what is wanted by no more than the result may be off there: whoever takes it may well
    be worse off, however much better it predicts what was seen.

    Args:
        fit: of a body to the senses; at x = 0 the robot is as modelled.
        weighing: of the fit, at what is wanted.
        senses: whose box of readings counts.
        wanted: frames (seen from, seen).
    """
    as_modelled = replace(fit, x=np.zeros_like(fit.x))
    moved = max(target.between(fit, as_modelled) for target in targets(senses, 0, wanted))
    if moved > weighing.total:
        return ""
    names = " and ".join(f"'{seen}' from '{looks}'" for looks, seen in wanted)
    return (
        f"But it moves {names} by {shown(moved, 'm')} (95 %) only, and may be off there by "
        f"{shown(weighing.total, 'm')}: what was seen does not tell what is wanted."
    )


def sees_positions(senses: Sequence[Sense]) -> bool:
    """Whether any sense sees a place in all its coordinates."""
    return any(unit == "m" and count == 3 for s in senses for _, unit, count in s.measures)


def wanted_pairs(fit: Estimate, senses: Sequence[Sense]) -> list[tuple[str, str]]:
    """Frames whose relative places the answer speaks of: what was seen, from what saw it.

    Where no sense sees positions, the robot's own frames that carry the ends of the senses.
    """
    seen = [pair for sense in senses for pair in sense.pairs]
    pairs = seen if sees_positions(senses) else _robot_pairs(fit, senses)
    return list(dict.fromkeys(pairs or seen))


def _robot_pairs(fit: Estimate, senses: Sequence[Sense]) -> list[tuple[str, str]]:
    """The robot's own frames that carry the ends of the senses, each pair once."""
    pairs = ((_carrier(fit, looks), _carrier(fit, seen)) for s in senses for looks, seen in s.pairs)
    return list(dict.fromkeys(pair for pair in pairs if pair[0] != pair[1]))


def _carrier(fit: Estimate, frame: str) -> str:
    """The frame itself, or what it hangs on if its own placement is free."""
    body = fit.reference
    while f"frame:{frame}" in fit.variables.groups:
        frame = body.frames[body.parent[body.frame_index(frame)]]
    return frame


def _telling(fit: Estimate, fullest: Estimate, a: str, b: str, q: Array) -> Telling:
    before, after = (relative_pose(body, q, a, b)[:, :3, 3] for body in (fit.reference, fit.body))
    T = align_points(after, before, np.ones(len(q)))
    moved = after @ T[:3, :3].T + T[:3, 3] - before
    D = relative_pose_derivatives(fullest.reference, fullest.variables, fullest.x, q, a, b)
    J = D.by_parameter[:, :3]
    rigid = np.concatenate([np.tile(np.eye(3), (len(q), 1, 1)), lie.skew(after)], axis=2)
    basis = np.linalg.qr(rigid.reshape(-1, 6))[0]
    flat = J.reshape(-1, J.shape[2])
    flat = flat - basis @ (basis.T @ flat)
    variance = np.einsum("ij,jk,ik->", flat, fullest.covariance, flat) / len(q)
    return Telling(
        a, b, float(np.sqrt(np.mean(np.sum(moved**2, axis=1)))), float(np.sqrt(max(variance, 0.0)))
    )
