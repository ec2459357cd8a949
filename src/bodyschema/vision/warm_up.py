"""Compiling before time matters."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bodyschema.model.camera import Camera
from bodyschema.vision.contours import fit_contours, silhouette_spans
from bodyschema.vision.correspondences import find_rim
from bodyschema.vision.edge_image import ObservedEdges
from bodyschema.vision.normal_search import search_masks
from bodyschema.vision.observed import ObservedMask
from bodyschema.vision.oriented import oriented_distances
from bodyschema.vision.region import sums_inside
from bodyschema.vision.surface import Surface


def warm_up(progress: Callable[[int, int, str], None] | None = None) -> None:
    """Compile the kernels of this package, or load them from the cache.

    Args:
        progress: called with the steps done, the number of steps and the name of the next one.

    Raises:
        MissingExtraError: OpenCV is not installed.
    """
    surface = Surface.build({"": (np.eye(4)[:, :3], [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])})
    camera = Camera.from_fov("", "", 16, 16, 1.0)
    T = np.eye(4)[None]
    T[0, 2, 3] = 4.0
    views, mask = T[None, None], np.ones((16, 16), dtype=bool)
    seen, edges = ObservedMask.of(mask), ObservedEdges.of(mask)
    steps: dict[str, Callable[[], object]] = {
        "silhouettes": lambda: silhouette_spans(surface, T, camera),
        "fit to masks": lambda: fit_contours(surface, views, [camera], [seen]),
        "fit to edges": lambda: oriented_distances(surface, views, [camera], [edges]),
        "fit to colours": lambda: sums_inside(surface, views, [camera], [seen.row_sums]),
        "correspondences": lambda: search_masks(find_rim(surface, T[None], [camera]), [mask]),
    }
    for i, (name, step) in enumerate(steps.items()):
        if progress:
            progress(i, len(steps), name)
        step()
    if progress:
        progress(len(steps), len(steps), "ready")
