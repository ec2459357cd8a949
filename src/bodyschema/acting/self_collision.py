"""Self-collision as far as meshes tell: convex hulls of the links, pair by pair.

Links that do not move against each other are one rigid part. Not looked at are pairs of parts that
a joint connects, and pairs whose hulls meet although the links do not: those that meet at zero, in
most recorded postures, or in nearly all postures (a convex hull fills the hollow that another link
lies in). What a robot wears or stands beside is not in its description.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.acting.candidates import joint_ranges
from bodyschema.acting.shapes import Hull, hulls_of
from bodyschema.errors import MissingExtraError
from bodyschema.model.kinematics import frame_poses
from bodyschema.model.tree import Body, Visual

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

OFTEN = 0.5
"""Share of recorded postures in which a pair that meets is held to be a fault of its hulls."""

ALWAYS = 0.9
"""The same for postures drawn at random."""

PROBES = 200
"""Random postures for that."""


@dataclass(frozen=True)
class SelfCollision:
    """Tells which postures are free of self-collision."""

    body: Body
    hulls: tuple[Hull, ...]
    pairs: Ints
    """(n_pairs, 2) hulls that are tested against each other."""
    unread: tuple[str, ...]
    """Mesh files that could not be read."""

    @classmethod
    def of(
        cls,
        body: Body,
        visuals: Sequence[Visual],
        joints: Sequence[str],
        recorded: Array,
        rng: np.random.Generator,
    ) -> SelfCollision | None:
        """Choose the pairs to look at; None when no shape could be read.

        Args:
            body: the corrected body.
            visuals: shapes, whose frames the body has.
            joints: those that will move.
            recorded: (n, n_joints) postures that the robot has been in.
            rng: randomness of the probes.

        Raises:
            MissingExtraError: python-fcl or trimesh is not installed.
        """
        hulls, unread = hulls_of([v for v in visuals if v.frame in body.frames])
        if not hulls:
            return None
        every = cls(body, tuple(hulls), _pairs_to_look_at(body, hulls, joints), tuple(unread))
        low, high = joint_ranges(body, recorded)
        columns = [body.joint_index(joint) for joint in joints]
        rest = np.median(recorded, axis=0) if len(recorded) else np.clip(0.0, low, high)
        probes = np.tile(rest, (PROBES, 1))
        probes[:, columns] = rng.uniform(low, high, (PROBES, len(low)))[:, columns]
        tests = [(probes, ALWAYS), (np.clip(0.0, low, high)[None], OFTEN)]
        if len(recorded):
            step = max(1, len(recorded) // PROBES)
            tests.append((recorded[::step], OFTEN))
        meets = [every.meeting(q).mean(axis=0) > share for q, share in tests]
        kept = every.pairs[~np.any(meets, axis=0)]
        return cls(body, every.hulls, kept, every.unread)

    def free(self, q: Array) -> Flags:
        """Whether no pair meets at postures (n, n_joints), (n,)."""
        return np.asarray(~self.meeting(q).any(axis=1))

    def meeting(self, q: Array) -> Flags:
        """Which pairs meet, (n, n_pairs)."""
        rows = [self.body.frame_index(hull.frame) for hull in self.hulls]
        T = frame_poses(self.body, q)[:, rows]
        meets = self._balls_meet(T)
        fcl = _fcl()
        solids = [_solid(fcl, hull) for hull in self.hulls]
        request = fcl.CollisionRequest()
        for i in np.flatnonzero(meets.any(axis=1)):
            for pose, solid in zip(T[i], solids, strict=True):
                solid.setTransform(fcl.Transform(pose[:3, :3], pose[:3, 3]))
            for k in np.flatnonzero(meets[i]):
                a, b = (solids[h] for h in self.pairs[k])
                meets[i, k] = fcl.collide(a, b, request, fcl.CollisionResult()) > 0
        return meets

    def _balls_meet(self, T: Array) -> Flags:
        """Whether the balls round the hulls of each pair meet, (n, n_pairs)."""
        centres = np.stack([hull.centre for hull in self.hulls])
        radii = np.array([hull.radius for hull in self.hulls])
        place = np.einsum("nhij,hj->nhi", T[..., :3, :3], centres) + T[..., :3, 3]
        a, b = self.pairs.T
        apart = np.linalg.norm(place[:, a] - place[:, b], axis=2)
        return np.asarray(apart < radii[a] + radii[b])


def _pairs_to_look_at(body: Body, hulls: Sequence[Hull], joints: Sequence[str]) -> Ints:
    """Pairs of hulls on parts that move against each other and are not neighbours, (n, 2)."""
    part = _parts(body, joints)
    above = {(int(part[k]), int(part[body.parent[k]])) for k in range(1, len(part))}
    of_hull = [int(part[body.frame_index(hull.frame)]) for hull in hulls]
    pairs = [
        (a, b)
        for b in range(len(hulls))
        for a in range(b)
        if of_hull[a] != of_hull[b]
        and (of_hull[a], of_hull[b]) not in above
        and (of_hull[b], of_hull[a]) not in above
    ]
    return np.array(pairs, dtype=np.int64).reshape(-1, 2)


def _parts(body: Body, joints: Sequence[str]) -> Ints:
    """Number of the rigid part of each frame: frames that the given joints do not part."""
    moving = {body.joint_index(joint) for joint in joints}
    part = np.zeros(len(body.frames), dtype=np.int64)
    for k in range(1, len(part)):
        part[k] = k if int(body.driver[k]) in moving else part[body.parent[k]]
    return part


def _fcl() -> Any:
    try:
        import fcl
    except ImportError:
        raise MissingExtraError("python-fcl", "mesh", "checking for self-collision") from None
    return fcl


def _solid(fcl: Any, hull: Hull) -> Any:
    """A hull for the collision library; faces are written as (number of corners, corners)."""
    faces = np.column_stack([np.full(len(hull.triangles), 3), hull.triangles]).ravel()
    return fcl.CollisionObject(fcl.Convex(hull.points, len(hull.triangles), faces), fcl.Transform())
