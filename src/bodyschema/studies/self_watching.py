"""A body that watches its own markers in random postures: what the humanoid's studies share.

At sample i the joints stand anywhere in their ranges and all markers of one group are seen; the
groups take turns. A body is right about a marker when its error is below a share of the path, the
summed lengths of the links between the eye and the marker.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.identifiability import random_postures
from bodyschema.model.kinematics import path_between, relative_pose
from bodyschema.model.skeleton import Skeleton
from bodyschema.model.tree import Body
from bodyschema.senses.points import Points
from bodyschema.simulation.humanoid import BETWEEN, ENDS, EYE

Array = NDArray[np.float64]

FRESH = 60
"""Postures at which a body is tested."""

CASES = {"ends": (ENDS,), "alternating": (ENDS, BETWEEN)}
"""The paper's two experiments: hands and feet only, or in turn with the joints between."""


@dataclass(frozen=True)
class SelfWatching:
    """A robot, and the groups of markers that it sees in turn."""

    body: Body
    """How it is truly built."""
    groups: tuple[tuple[str, ...], ...]

    @property
    def markers(self) -> tuple[str, ...]:
        """All of them, in the order of the groups."""
        return tuple(marker for group in self.groups for marker in group)

    def path_length(self, marker: str) -> float:
        """Summed lengths of the links between the eye and a marker, m."""
        path, _ = path_between(self.body, EYE, marker)
        return float(np.linalg.norm(Skeleton.of(self.body).links[path], axis=1).sum())

    def senses(self, q: Array) -> list[Points]:
        """What is seen at postures q, (n, n_joints), one batch a marker."""
        parts, turns = [], np.arange(len(q))
        for g, group in enumerate(self.groups):
            rows = turns[turns % len(self.groups) == g]
            for marker in group:
                position = relative_pose(self.body, q[rows], EYE, marker)[:, :3, 3]
                time = rows.astype(np.float64)
                parts.append(Points.make(q[rows], position, EYE, marker, time=time, rows=rows))
        return parts

    def at(self, q: Array, i: int) -> list[Points]:
        """What is seen at the i-th of these postures."""
        return [
            sense for sense in (part.take(part.rows == i) for part in self.senses(q)) if len(sense)
        ]

    def looks(self) -> list[Points]:
        """Who looks at whom, without samples."""
        return self.senses(np.empty((0, len(self.body.joints))))

    def postures(self, n: int, rng: np.random.Generator) -> Array:
        """(n, n_joints) rad, anywhere in the joint ranges."""
        return random_postures(self.body, n, rng)

    def errors(self, believed: Body, q: Array, markers: Sequence[str] | None = None) -> Array:
        """Distance between believed and true markers at postures q, (n, n_markers) m."""
        found = []
        for marker in self.markers if markers is None else markers:
            true, thought = (
                relative_pose(body, q, EYE, marker)[:, :3, 3] for body in (self.body, believed)
            )
            found.append(np.linalg.norm(true - thought, axis=1))
        return np.stack(found, axis=1)

    def worst(self, believed: Body, q: Array) -> float:
        """Largest error over markers and postures, as a share of the marker's path."""
        lengths = [self.path_length(marker) for marker in self.markers]
        return float(np.max(self.errors(believed, q) / lengths))
