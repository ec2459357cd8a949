"""Masses and inertias of the links of a URDF, each in its link's frame."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.inertia import Inertia
from bodyschema.model.urdf_xml import xml_root

Array = NDArray[np.float64]


def urdf_inertials(source: bytes) -> dict[str, Inertia]:
    """Link -> what its <inertial> says; links without one, or without a mass, are left out.

    Args:
        source: a URDF that `parse_urdf` has read.
    """
    found = {}
    for link in xml_root(source).findall("link"):
        inertial = link.find("inertial")
        made = None if inertial is None else _inertia(inertial)
        if made is not None:
            found[link.get("name", "")] = made
    return found


def _inertia(element: ET.Element) -> Inertia | None:
    """None for numbers that are none, and for no mass at all."""
    origin, mass = element.find("origin"), element.find("mass")
    given = element.find("inertia")
    try:
        m = float("" if mass is None else mass.get("value", ""))
        xyz, rpy = (
            [float(v) for v in ("0 0 0" if origin is None else origin.get(key, "0 0 0")).split()]
            for key in ("xyz", "rpy")
        )
        xx, xy, xz, yy, yz, zz = (
            float("0" if given is None else given.get(f"i{key}", "0"))
            for key in ("xx", "xy", "xz", "yy", "yz", "zz")
        )
    except ValueError:
        return None
    numbers = np.array([m, *xyz, *rpy, xx, xy, xz, yy, yz, zz])
    if len(numbers) != 13 or not np.isfinite(numbers).all() or m <= 0:
        return None
    R: Array = lie.rotation_from_rpy(rpy)
    own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return Inertia(m, np.array(xyz), R @ own @ R.T)
