"""The skeleton of a body: joint axes and link vectors, in the frame of the root at zero posture.

At zero posture all frames of a skeleton are parallel to the root. Node k lies at the link vector
l_k from its parent and turns about the unit axis a_k, so that a point p_k of node k is seen from
its parent, and a point of the parent from node k, as

    down    p_parent = l_k + R_k p_k                                 (Hersch et al. 2008, Eq. 1)
    up      p_k = R_k^T (p_parent - l_k)                             (Fig. 6)

A path between any two nodes goes up and then down; a chain that goes down only is Eq. 2,
x = l_1 + R_1 (l_2 + R_2 (... (l_n + R_n v))). With Rodrigues' formula (Eq. 6)

    R p = c p + s a x p + (1 - c) (a . p) a,          c = cos theta, s = sin theta

the derivative with respect to a (free in R^3, Eq. 7) applied from the left by g is

    D(p)^T g = s p x g + (1 - c) ((a . g) p + (a . p) g).

A body's own frames may be turned at zero posture: with R0_k the rotation of frame k in the root
then, a_k = R0_k (axis of the joint) and l_k = R0_parent (translation of the placement). A point in
frame k has the skeleton's coordinates R0_k p. A prismatic node is p_parent = l_k + theta a_k + p_k.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.model.kernels import PRISMATIC, REVOLUTE, kernel
from bodyschema.model.tree import Body

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Skeleton:
    """Axes and links of a tree, and nothing else; row k belongs to frame k of the body."""

    parent: Ints
    """(n_frames,) -1 for the root."""
    kind: Ints
    """(n_frames,) FIXED, REVOLUTE or PRISMATIC."""
    axes: Array
    """(n_frames, 3) unit a_k; of no meaning for fixed nodes."""
    links: Array
    """(n_frames, 3) l_k, m."""

    @classmethod
    def of(cls, body: Body) -> Skeleton:
        """The skeleton of a body."""
        R0 = zero_rotations(body)
        above = R0[np.maximum(body.parent, 0)]
        axes = np.einsum("kij,kj->ki", R0, body.axis)
        links = np.einsum("kij,kj->ki", above, body.placement[:, :3, 3])
        return cls(body.parent, body.kind, axes, links)

    def into(self, body: Body) -> Body:
        """The body with these axes and links, its frames turned at zero posture as they were."""
        R0 = zero_rotations(body)
        above = R0[np.maximum(body.parent, 0)]
        placement = body.placement.copy()
        placement[:, :3, 3] = np.einsum("kji,kj->ki", above, self.links)
        axis = np.einsum("kji,kj->ki", R0, self.axes)
        return replace(body, axis=axis, placement=placement)

    def predict(self, path: Ints, climbed: int, theta: ArrayLike, point: ArrayLike) -> Array:
        """A point of the last node of a path, seen from its first.

        Args:
            path: nodes from the frame that looks to the one that carries the point, and
            climbed: how many of them go up, both from `kinematics.path_between`.
            theta: (n, n_frames) joint values at the nodes.
            point: (n, 3) v, m, in the last frame, as the skeleton has it (R0 v).

        Returns:
            (n, 3) m.
        """
        angles = np.ascontiguousarray(theta, dtype=np.float64)
        v = np.ascontiguousarray(point, dtype=np.float64)
        out = np.empty((len(angles), 3))
        predict(path, climbed, self.kind, self.axes, self.links, angles, v, out)
        return out


def zero_rotations(body: Body) -> Array:
    """R0: rotation of every frame in the root when all joint values are zero, (n_frames, 3, 3)."""
    R0 = body.placement[:, :3, :3].copy()
    for k in range(1, len(R0)):
        R0[k] = R0[body.parent[k]] @ R0[k]
    return np.asarray(R0)


@kernel
def turn(a: Array, c: float, s: float, p: Array, out: Array) -> None:
    """out = R p, Rodrigues' formula (Eq. 6); -s turns back. `out` may be `p`."""
    x, y, z = p[0], p[1], p[2]
    along = (1.0 - c) * (a[0] * x + a[1] * y + a[2] * z)
    out[0] = c * x + s * (a[1] * z - a[2] * y) + along * a[0]
    out[1] = c * y + s * (a[2] * x - a[0] * z) + along * a[1]
    out[2] = c * z + s * (a[0] * y - a[1] * x) + along * a[2]


@kernel
def walk_in(
    path: Ints, climbed: int, kind: Ints, axes: Array, links: Array, theta: Array, v: Array,
    levers: Array, out: Array,
) -> None:  # fmt: skip
    """Carry point v of the last node to the first: fills levers (steps, 3), p_i on which the
    rotation of path node i acts, and out (3,), where the point is seen."""
    # Number by number: compiled slices cost more than the mathematics.
    out[0], out[1], out[2] = v[0], v[1], v[2]
    for i in range(path.shape[0] - 1, -1, -1):
        k = path[i]
        sign = -1.0 if i < climbed else 1.0
        if i < climbed:
            for j in range(3):
                out[j] -= links[k, j]
        levers[i, 0], levers[i, 1], levers[i, 2] = out[0], out[1], out[2]
        if kind[k] == REVOLUTE:
            turn(axes[k], np.cos(theta[k]), sign * np.sin(theta[k]), out, out)
        elif kind[k] == PRISMATIC:
            for j in range(3):
                out[j] += sign * theta[k] * axes[k, j]
        if i >= climbed:
            for j in range(3):
                out[j] += links[k, j]


@kernel
def pull_back(
    path: Ints, climbed: int, kind: Ints, axes: Array, links: Array, theta: Array, levers: Array,
    g: Array, by_axis: Array, by_link: Array,
) -> None:  # fmt: skip
    """Gradient of g . (point seen) by one pass from the first node to the last (Eq. 14, 15).

    Adds to by_axis and by_link (n_frames, 3); `levers` come from `walk_in`; g (3,) is overwritten.
    The axis counts as free in R^3: whoever takes a step renormalises it.
    """
    for i in range(path.shape[0]):
        k = path[i]
        a, p, t = axes[k], levers[i], theta[k]
        sign = -1.0 if i < climbed else 1.0
        if i >= climbed:
            for j in range(3):
                by_link[k, j] += g[j]
        if kind[k] == REVOLUTE:
            c, s = np.cos(t), sign * np.sin(t)
            u = 1.0 - c
            ag = a[0] * g[0] + a[1] * g[1] + a[2] * g[2]
            ap = a[0] * p[0] + a[1] * p[1] + a[2] * p[2]
            by_axis[k, 0] += s * (p[1] * g[2] - p[2] * g[1]) + u * (ag * p[0] + ap * g[0])
            by_axis[k, 1] += s * (p[2] * g[0] - p[0] * g[2]) + u * (ag * p[1] + ap * g[1])
            by_axis[k, 2] += s * (p[0] * g[1] - p[1] * g[0]) + u * (ag * p[2] + ap * g[2])
            turn(a, c, -s, g, g)
        elif kind[k] == PRISMATIC:
            for j in range(3):
                by_axis[k, j] += sign * t * g[j]
        if i < climbed:
            for j in range(3):
                by_link[k, j] -= g[j]


@kernel
def predict(
    path: Ints, climbed: int, kind: Ints, axes: Array, links: Array, theta: Array, point: Array,
    out: Array,
) -> None:  # fmt: skip
    """`Skeleton.predict` for n samples: theta (n, n_frames), point (n, 3) -> out (n, 3)."""
    levers = np.empty((path.shape[0], 3))
    for n in range(theta.shape[0]):
        walk_in(path, climbed, kind, axes, links, theta[n], point[n], levers, out[n])
