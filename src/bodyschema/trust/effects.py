"""Effects: what joints and frames that are not as believed would do to everything that was seen.

Every rival (`rivals`) is one of these, switched on and off, slowly turned up, or made to follow the
posture: a slip is a joint's effect from a row on, a lag all joints' effects times their speeds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.model.kinematics import frame_jacobian, relative_pose_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, join
from bodyschema.trust.scores import Scores
from bodyschema.trust.target import Target

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Effects:
    """By joints and by frames, on the rows of a fit and on the targets."""

    scores: Scores
    frames: tuple[str, ...]
    """That could move: the ends of the senses that hang on a fixed joint."""
    free: Variables
    """The placements of these frames."""
    by_joint: Array
    """(N, n_joints)."""
    by_frame: Array
    """(N, len(free))."""
    targets: tuple[Target, ...]

    @classmethod
    def of(cls, scores: Scores, targets: Sequence[Target]) -> Effects:
        """Linearise by what the fit may not have freed.

        Args:
            scores: of a fit.
            targets: where the robot is to be right.
        """
        body = scores.estimate.body
        frames, free = _movable(body, scores)
        joints, places = [], []
        for sense in scores.senses:
            linear = replace(sense, clock="").linearize(body, free, np.zeros(len(free)))
            joints.append(linear.by_joint)
            places.append(linear.by_parameter)
        return cls(
            scores,
            frames,
            free,
            scores.whitened(joints),
            scores.whitened(places),
            tuple(targets),
        )

    def columns(self, frame: str) -> NDArray[np.int64]:
        """Which columns of `by_frame` move a frame."""
        group = f"frame:{frame}"
        return np.array([i for i, g in enumerate(self.free.groups) if g == group], dtype=np.int64)

    def of_sense(self, i: int, part: slice, effect: Array) -> Array:
        """An effect (n, d, k) on one component of one sense, as whitened rows (N, k)."""
        effects = [
            np.zeros((len(sense), len(sense.covariance), effect.shape[2]))
            for sense in self.scores.senses
        ]
        effects[i][:, part] = effect
        return self.scores.whitened(effects)

    @cached_property
    def at_targets(self) -> tuple[tuple[Array, Array], ...]:
        """What joints (n, 3, n_joints) and frames (n, 3, len(free)) do to each target's place."""
        body, found = self.scores.estimate.body, []
        for target in self.targets:
            D = relative_pose_derivatives(
                body, self.free, np.zeros(len(self.free)), target.q, *target.pair
            )
            found.append((D.by_joint[:, :3], D.by_parameter[:, :3]))
        return tuple(found)

    @cached_property
    def rate(self) -> Array:
        """(n_samples, n_joints) dq/dt, from the neighbours in time where no sense brings it."""
        return np.concatenate([_rate(s.time, s.q, s.rows, s.rate) for s in self.scores.senses])

    def burden(self, q: Array) -> Array:
        """(n, n_joints, 3) torque at each joint of a unit force on what was first seen.

        Along x, y and z of the root: the lever of a weight whose direction nobody stated.
        """
        body = self.scores.estimate.body
        levers = frame_jacobian(body, q, body.frames[0], self.targets[0].seen)[:, :3]
        return np.asarray(np.swapaxes(levers, 1, 2))


def _movable(body: Body, scores: Scores) -> tuple[tuple[str, ...], Variables]:
    """Frames at the ends of the senses that can be freed, and those numbers that show."""
    shown: dict[str, set[str]] = {}
    for sense in scores.senses:
        for pair in sense.pairs:
            for frame, names in zip(pair, sense.shows, strict=True):
                shown.setdefault(frame, set()).update(names)
    frames, parts = [], []
    for frame, some in shown.items():
        try:
            parts.append(free_frame(body, frame, only=some))
        except InputError:  # The root, or a link that a joint moves: it has no placement to free.
            continue
        frames.append(frame)
    return tuple(frames), join(free_joints(body, ()), *parts)


def _rate(time: Array, q: Array, rows: NDArray[np.int64], rate: Array | None) -> Array:
    if rate is not None:
        return rate
    _, first, back = np.unique(rows, return_index=True, return_inverse=True)
    if len(first) < 2:
        return np.zeros_like(q)
    t = time[first]
    if np.any(np.diff(t) <= 0):
        t = np.arange(len(first), dtype=np.float64)
    return np.asarray(np.gradient(q[first], t, axis=0)[back.ravel()])
