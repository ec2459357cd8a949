"""Things to hold: a box, a rod and a cup, with their shapes and their inertia.

The box is that of the paper as far as it is printed: 0.594 kg and its centre of mass. The rod is
0.3 m long; the cup is hollow, so that a line of force may enter it twice. All are of even density.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError, did_you_mean
from bodyschema.model.inertia import Inertia
from bodyschema.model.solid import Solid

Array = NDArray[np.float64]

PRINTED_COM = (0.0161846, -0.0214352, 0.0923942)
"""m, of the wire-mesh box in the sensor's frame (section 4.4)."""

PRINTED_MASS = 0.594409
"""kg."""

BOX = (0.10, 0.12, 0.18)
"""m; the box's measures are not printed."""

CUP = np.array(
    [[0, 0], [34, 0], [37, 12], [40, 95], [37, 95], [34, 14], [28, 6], [0, 6]], dtype=np.float64
)
"""mm, radius and height round the outline of the cup."""

SIDES = 64


@dataclass(frozen=True)
class HeldObject:
    """Something in the hand, in the frame of the sensor's mount."""

    solid: Solid
    load: Inertia


def held_object(name: str) -> HeldObject:
    """A thing by name.

    Args:
        name: "box", "rod" or "mesh", which is the cup.

    Raises:
        InputError: no such thing.
    """
    if name == "box":
        solid = Solid.box(BOX, lie.transform(np.eye(3), PRINTED_COM))
        return HeldObject(solid, even_inertia(solid, PRINTED_MASS))
    if name == "rod":
        T = lie.transform(lie.exp_so3([0.3, -0.2, 0.0]), [0.01, 0.015, 0.13])
        solid = Solid.cylinder(0.006, 0.30, T)
        return HeldObject(solid, even_inertia(solid, 0.25))
    if name == "mesh":
        solid = cup(lie.transform(lie.exp_so3([0.0, 1.2, 0.0]), [-0.02, 0.01, 0.05]))
        return HeldObject(solid, even_inertia(solid, 0.35))
    raise InputError(f"no thing '{name}' to hold{did_you_mean(name, ('box', 'rod', 'mesh'))}")


def cup(T: Array) -> Solid:
    """A body of revolution about z, open at the top, at T (4, 4)."""
    turn = np.linspace(0, 2 * np.pi, SIDES, endpoint=False)
    rings = [1e-3 * np.array([r * np.cos(turn), r * np.sin(turn), 0 * turn + z]).T for r, z in CUP]
    faces = []
    for ring in range(len(CUP) - 1):
        for i in range(SIDES):
            a, b = ring * SIDES + i, ring * SIDES + (i + 1) % SIDES
            faces += [(a, b + SIDES, b), (a, a + SIDES, b + SIDES)]
    vertices = np.vstack(rings) @ T[:3, :3].T + T[:3, 3]
    whole = Solid(vertices, np.array(faces)[:, ::-1].copy())
    # On the axis half of the triangles are lines.
    return Solid(vertices, whole.faces[whole.normals.any(axis=1)])


def even_inertia(solid: Solid, mass: float) -> Inertia:
    """Of a solid of even density: the sum over the tetrahedra of its triangles and the centre.

    A tetrahedron with corners p_i about 0 has the second moment V/20 (sum p_i p_i^T + s s^T),
    s = sum p_i.

    Args:
        solid: closed, outward.
        mass: kg.
    """
    p = solid.corners - solid.centre
    volume = np.einsum("mi,mi->m", p[:, 0], np.cross(p[:, 1], p[:, 2])) / 6
    s = p.sum(axis=1)
    second = np.einsum("m,mki,mkj->ij", volume, p, p) + np.einsum("m,mi,mj->ij", volume, s, s)
    density = mass / volume.sum()
    com = density / mass * (volume @ s) / 4
    about = density * second / 20 - mass * np.outer(com, com)
    return Inertia(mass, solid.centre + com, np.trace(about) * np.eye(3) - about)
