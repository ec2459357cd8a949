"""The robot's shapes for a page: a mesh a link, few enough triangles for any browser."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError, MissingExtraError
from bodyschema.model.meshes import triangles_of
from bodyschema.model.tree import Visual
from bodyschema.units import listed
from bodyschema.vision.decimation import decimated

BUDGET = 20_000
"""Triangles of the whole robot: drawn without a graphics card at 15 frames a second, and half a
megabyte of page."""
FEWEST = 24
"""Triangles that a link keeps however small its share is."""
MOST_NAMED = 4
"""Links that a note names; the others are counted."""


@dataclass(frozen=True)
class Shape:
    """What is seen of one link."""

    frame: str
    vertices: NDArray[np.float32]
    """(n, 3) m, in the link's frame."""
    faces: NDArray[np.uint32]
    """(m, 3) rows of the vertices."""


def shapes_of(
    visuals: Sequence[Visual], budget: int = BUDGET
) -> tuple[tuple[Shape, ...], tuple[str, ...]]:
    """A shape for every link whose meshes can be read, and sentences on the others.

    Args:
        visuals: of the robot description.
        budget: triangles of all links together.
    """
    by_link: dict[str, list[Visual]] = {}
    for visual in visuals:
        by_link.setdefault(visual.frame, []).append(visual)
    sizes, failed = {}, {}
    for link, own in by_link.items():
        try:
            sizes[link] = sum(len(triangles_of(visual)[1]) for visual in own)
        except MissingExtraError as error:
            return (), (f"{error} Until then links are drawn as sticks.",)
        except InputError as error:
            failed[link] = str(error)
    shapes = []
    for link, share in shares(sizes, budget).items():
        try:
            vertices, faces = decimated(by_link[link], [np.eye(4)] * len(by_link[link]), share)
        except MissingExtraError as error:
            return (), (f"{error} Until then links are drawn as sticks.",)
        shapes.append(Shape(link, vertices.astype(np.float32), faces.astype(np.uint32)))
    return tuple(shapes), _told(failed)


def shares(sizes: Mapping[str, int], budget: int) -> dict[str, int]:
    """Triangles that each link may keep: small links whole, the others one same number.

    Args:
        sizes: triangles that each has.
        budget: of all.

    Returns:
        For `decimated`: 0 keeps a link whole.
    """
    left, waiting = budget, dict(sorted(sizes.items(), key=lambda item: item[1]))
    kept = {}
    for link in list(waiting):
        most = left // len(waiting)
        size = waiting.pop(link)
        kept[link] = 0 if size <= most else max(most, FEWEST)
        left -= min(size, most)
    return {link: kept[link] for link in sizes}


def _told(failed: Mapping[str, str]) -> tuple[str, ...]:
    if not failed:
        return ()
    reason = next(iter(failed.values()))
    many = "1 link is" if len(failed) == 1 else f"{len(failed)} links are"
    return (f"{many} drawn as sticks ({listed(list(failed), MOST_NAMED)}): {reason}",)
