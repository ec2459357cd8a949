"""First guesses from pictures: many bodies of the prior, scored coarsely; the best are kept.

The guesses x = sigma Phi^-1(u), u of a Sobol sequence, fill the prior more evenly than random ones
(Owen's scrambling by `seed`). Each is imagined at a few postures in pictures of at most WIDTH
columns and scored by `vision.scores`; the scores of all pictures add up, as log likelihoods
do. x = 0 is always among them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from bodyschema.errors import MissingExtraError
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.senses.images import Images
from bodyschema.vision.edge_image import ObservedEdges
from bodyschema.vision.observed import ObservedMask
from bodyschema.vision.poses import piece_poses
from bodyschema.vision.scores import OrientedChamfer, Overlap, Score
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]

WIDTH = 320
"""pixels; the pictures of coarse guesses have no more columns."""

NEAR = 0.25
"""Of the distance between two guesses drawn from the prior; nearer ones are one guess."""


def sobol_seeds(variables: Variables, n: int, seed: int) -> Array:
    """Guesses (n, n_parameters) from the prior; the first is zero.

    Args:
        variables: with priors; one without takes its scale.
        n: how many.
        seed: of the scrambling.
    """
    from scipy.stats import qmc  # here: it takes most of a second to import

    sobol = qmc.Sobol(len(variables), rng=np.random.default_rng(seed))
    u = sobol.random_base2(max(n - 1, 1).bit_length())[:n]  # whole powers of two are even
    x = variables.scale * ndtri(np.clip(u, 1e-6, 1 - 1e-6))
    x[0] = 0.0
    return np.asarray(np.clip(x, -variables.bound, variables.bound))


def coarse(seen: Images) -> Images:
    """The same moment in smaller pictures."""
    cv2 = _cv2()
    cameras, pictures = [], []
    for camera, picture in zip(seen.cameras, seen.pictures, strict=True):
        share = min(1.0, WIDTH / camera.width)
        size = round(share * camera.width), round(share * camera.height)
        values: NDArray[Any] = picture.astype(np.uint8) * 255 if seen.masked else picture
        small = cv2.resize(values, size, interpolation=cv2.INTER_AREA)
        cameras.append(camera.scaled(*size))
        pictures.append(np.asarray(small >= 128 if seen.masked else small))
    return replace(seen, cameras=tuple(cameras), pictures=tuple(pictures))


def coarse_score(surface: Surface, seen: Images) -> Score:
    """Overlap with masks, or distance to edges of the same direction."""
    if seen.masked:
        masks = [ObservedMask.of(picture) for picture in seen.pictures]
        return Overlap(surface, seen.cameras, masks)
    edges = [ObservedEdges.of(picture) for picture in seen.pictures]
    return OrientedChamfer(surface, seen.cameras, edges)


def scored(
    surface: Surface, bodies: Sequence[Body], frames: Sequence[Images], threads: int = 1
) -> Array:
    """Score of each guess over all pictures, (n,); the more the better.

    Args:
        surface: the visible body.
        bodies: the guesses.
        frames: pictures of some postures.
        threads: how many work.
    """
    total = np.zeros(len(bodies))
    for seen in frames:
        poses = [piece_poses(body, seen.q, seen.cameras, surface.frames) for body in bodies]
        score = coarse_score(surface, seen)
        total += score.score(np.concatenate(poses), threads).sum(axis=1)
    return total


def best_apart(x: Array, score: Array, n: int) -> list[int]:
    """Rows of the best guesses, none near a better one: they would be refined to the same.

    Args:
        x: (n_guesses, n_parameters) in units of the prior.
        score: (n_guesses,) the more the better.
        n: at most how many.
    """
    least, kept = NEAR * np.sqrt(2 * x.shape[1]), list[int]()
    for i in np.argsort(-score, kind="stable"):
        if len(kept) == n:
            break
        if not kept or np.linalg.norm(x[kept] - x[i], axis=1).min() >= least:
            kept.append(int(i))
    return kept


def spread_out(q: Array, n: int) -> list[int]:
    """Rows of n postures far from each other, in the order of their rows.

    Args:
        q: (n_postures, n_joints).
        n: how many, if there are as many.
    """
    chosen = [int(np.argmin(np.linalg.norm(q - q.mean(axis=0), axis=1)))]
    while len(chosen) < min(n, len(q)):
        away = np.linalg.norm(q[:, None] - q[chosen], axis=2).min(axis=1)
        away[chosen] = -1.0
        chosen.append(int(np.argmax(away)))
    return sorted(chosen)


def _cv2() -> Any:
    try:
        import cv2
    except ImportError:
        raise MissingExtraError("opencv-python-headless", "vision", "scaling pictures") from None
    return cv2
