"""What an MJCF would become: <replicate>, <composite> and <flexcomp> make many things of one line.

MuJoCo makes them before anybody can ask how many there are, and a million bodies take it hours.
"""

from __future__ import annotations

import math
from pathlib import Path
from xml.etree.ElementTree import Element
from xml.parsers.expat import ExpatError

from bodyschema.documents import MOST_BYTES, file_bytes
from bodyschema.errors import InputError
from bodyschema.model.urdf_xml import xml_root

COPYING = ("replicate", "composite", "flexcomp")
"""Elements with a count, or one along each axis."""

MOST_COPIES = 10_000
"""Copies of anything: robots are made of hundreds of bodies, and MuJoCo takes 1 s for these."""


def refuse_copies(path: Path) -> None:
    """Refuse a file, or one that it includes, which makes too many copies.

    What is no XML is passed over: MuJoCo says more about it.

    Raises:
        InputError: more than `MOST_COPIES` of one element.
    """
    files = [path]
    for file in files:  # grows by what is included, each once
        others = [path.parent / name for name in _included(file)]
        files += [other for other in dict.fromkeys(others) if other not in files]


def _included(path: Path) -> list[str]:
    """The files that one includes. Raises InputError where it makes too many copies."""
    try:
        root = xml_root(file_bytes(path, "", MOST_BYTES))
    except (InputError, ExpatError, LookupError, ValueError):
        return []
    waiting: list[tuple[Element, float]] = [(root, 1.0)]
    included = []
    while waiting:
        element, copies = waiting.pop()
        if element.tag in COPYING:
            copies *= _count(element.get("count", "1"))
        if copies > MOST_COPIES:
            raise InputError(
                f"'{path.name}' makes {copies:.3g} copies by <{element.tag}>, and at most "
                f"{MOST_COPIES} are read; write count smaller, or leave it out."
            )
        if element.tag == "include":
            included.append(element.get("file", ""))
        waiting += [(child, copies) for child in element]
    return included


def _count(words: str) -> float:
    """The product of the numbers of a count; 1 for what is none."""
    try:
        return math.prod(max(1.0, float(word)) for word in words.split())
    except ValueError:
        return 1.0
