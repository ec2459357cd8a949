"""MJCF of a body: what MuJoCo loads, with the same poses at the same readings.

A body of MJCF for every frame, with the joint that carries it at its origin; joint offsets are
inside the placements. Mimics are equalities, which MuJoCo's solver holds when it steps. Masses and
inertias are those of the URDF where there is one, else MuJoCo's smallest; shapes are for looking at
and collide with nothing. Meshes in other forms than OBJ and binary STL are left out.
"""

from __future__ import annotations

import struct
import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.documents import is_file
from bodyschema.export.joint_edit import clean
from bodyschema.export.urdf_edits import baked_placements
from bodyschema.export.urdf_writer import UNLIMITED
from bodyschema.model.inertia import Inertia
from bodyschema.model.kernels import FIXED, PRISMATIC
from bodyschema.model.tree import Body, Visual

Array = NDArray[np.float64]

WORLD = "world"
"""The body that every MJCF has; a root of that name is it."""

COMPILER = {
    "angle": "radian",
    "autolimits": "true",
    "balanceinertia": "true",
    "boundmass": "1e-6",
    "boundinertia": "1e-9",
}
"""Links without a mass, or with moments that no mass has, are loaded all the same."""

LOOKED_AT = {"contype": "0", "conaffinity": "0", "group": "2", "mass": "0"}
"""Of shapes: they collide with nothing, are drawn, and weigh nothing."""


def write_mjcf(body: Body, inertials: Mapping[str, Inertia] | None = None) -> bytes:
    """The body as an MJCF file.

    Args:
        body: gear errors are left out, see `urdf_edits.unwritable`.
        inertials: of links by name, each in its link's frame; see `urdf_inertials`.
    """
    root = ET.Element("mujoco", model=body.name)
    ET.SubElement(root, "compiler", COMPILER)
    assets = _Assets(ET.SubElement(root, "asset"))
    world = ET.SubElement(root, "worldbody")
    placements, elements = baked_placements(body), []
    for k, frame in enumerate(body.frames):
        if not k and frame == WORLD:
            elements.append(world)
            continue
        above = world if not k else elements[body.parent[k]]
        element = ET.SubElement(above, "body", {"name": frame, **_place(placements[k])})
        elements.append(element)
        if frame in (inertials or {}):
            _add_inertial(element, (inertials or {})[frame])
        if body.kind[k] != FIXED:
            ET.SubElement(element, "joint", _joint(body, k))
    for visual in body.visuals:
        shape = assets.shape(visual)
        if shape:
            place = _place(visual.placement)
            element = elements[body.frame_index(visual.frame)]
            ET.SubElement(element, "geom", {**shape, **place, **LOOKED_AT})
    _add_mimics(root, body)
    ET.indent(root)
    return bytes(ET.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def _joint(body: Body, k: int) -> dict[str, str]:
    kind = "slide" if body.kind[k] == PRISMATIC else "hinge"
    attributes = {"name": body.carriers[k], "type": kind, "axis": _text(body.axis[k])}
    j = body.driver[k]
    if body.joints[j] == body.carriers[k] and np.isfinite([body.lower[j], body.upper[j]]).any():
        ends = max(body.lower[j], -UNLIMITED), min(body.upper[j], UNLIMITED)
        # MuJoCo refuses ranges of no width; they mean that nobody knows.
        attributes |= {"range": _text(ends)} if ends[0] < ends[1] else {}
    return attributes


def _add_mimics(root: ET.Element, body: Body) -> None:
    following = [
        k for k in np.flatnonzero(body.driver >= 0)
        if body.joints[body.driver[k]] != body.carriers[k]
    ]  # fmt: skip
    equality = ET.SubElement(root, "equality") if following else None
    for k in following:
        assert equality is not None
        line = _text([body.shift[k], body.rate[k], 0, 0, 0])
        ends = {"joint1": body.carriers[k], "joint2": body.joints[body.driver[k]]}
        ET.SubElement(equality, "joint", {**ends, "polycoef": line})


def _add_inertial(element: ET.Element, load: Inertia) -> None:
    moments, axes = load.principal()
    place = _place(lie.transform(axes, load.com))
    main = _text(np.maximum(moments, 0.0))
    ET.SubElement(element, "inertial", {**place, "mass": _text([load.mass]), "diaginertia": main})


class _Assets:
    """Meshes of a file, each once."""

    def __init__(self, element: ET.Element) -> None:
        self.element = element
        self.names: dict[tuple[str, tuple[float, ...]], str] = {}

    def shape(self, visual: Visual) -> dict[str, str]:
        """The attributes of a geom; none for a mesh that MuJoCo does not read."""
        size = visual.size
        if visual.shape == "mesh":
            return {"type": "mesh", "mesh": self._mesh(visual)} if _readable(visual.mesh) else {}
        sizes = {
            "box": [0.5 * v for v in size],
            "cylinder": [size[0], 0.5 * size[-1]],
            "sphere": [size[0]],
        }[visual.shape]
        return {"type": visual.shape, "size": _text(sizes)} if min(sizes) > 0 else {}

    def _mesh(self, visual: Visual) -> str:
        key = visual.mesh, visual.size
        if key not in self.names:
            self.names[key] = f"mesh_{len(self.names) + 1}"
            made = {"name": self.names[key], "file": visual.mesh, "scale": _text(visual.size)}
            # Of open and flat meshes a shell has an inertia and a solid has none.
            ET.SubElement(self.element, "mesh", {**made, "inertia": "shell"})
        return self.names[key]


def _readable(mesh: str) -> bool:
    path = Path(mesh)
    if not is_file(path) or path.suffix.lower() not in (".stl", ".obj"):
        return False
    if path.suffix.lower() == ".obj":
        return True
    with path.open("rb") as file:
        head = file.read(84)
    count = struct.unpack("<I", head[80:])[0] if len(head) == 84 else 0
    return 0 < count <= 200_000 and path.stat().st_size == 84 + 50 * count


def _place(T: Array) -> dict[str, str]:
    x, y, z, w = lie.quaternion_xyzw(T[:3, :3])
    return {"pos": _text(T[:3, 3]), "quat": _text([w, x, y, z])}


def _text(numbers: Iterable[float]) -> str:
    return " ".join(repr(clean(float(number))) for number in numbers)
