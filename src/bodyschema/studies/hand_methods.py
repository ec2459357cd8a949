"""What may learn the offsets in the studies of Vicente et al. 2016, behind one face.

A method is built for a surface and a scene. It starts with what the robot believes and the joints
that may be off; every frame brings the next state and an info. A method joins by one line in
`METHODS` and its name in the `method` of the studies. Of the filter, the edges that are imagined
before a cluttered background are a setting: those of the whole hand, as published, or its outline.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.learners.images.contour_tracker import ContourTracker
from bodyschema.learners.images.doubts import Doubts
from bodyschema.learners.published.image_likelihood import (
    EDGES,
    EdgeLikelihood,
    Edges,
    SilhouetteLikelihood,
)
from bodyschema.learners.published.particle_filter import ParticleFilter
from bodyschema.model.tree import Body
from bodyschema.senses.images import Images
from bodyschema.simulation.seeing_icub import Scene
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]


class OffsetInfo(Protocol):
    """What a study reads of one frame."""

    @property
    def offsets(self) -> Array:
        """(7,) estimate, rad."""
        ...

    @property
    def covariance(self) -> Array:
        """(7, 7) rad^2."""
        ...

    @property
    def effective_size(self) -> float:
        """How many equally weighted hypotheses those of this frame are worth."""
        ...


class OffsetLearner(Protocol):
    """A learner of joint offsets from images."""

    def start(self, body: Body, joints: Sequence[str]) -> Any:
        """The state before the first frame."""

    def step(self, state: Any, moment: tuple[Images, ...]) -> tuple[Any, tuple[OffsetInfo, ...]]:
        """The state after one frame."""


@dataclass(frozen=True)
class Method:
    """A way to learn, and whether the arm should heed how sure it is."""

    build: Callable[[Surface, Scene, int, int, Doubts], OffsetLearner]
    """(surface, scene, particles, seed, doubts) -> learner."""
    gated: bool
    """Servoing slows when the covariance is large; the paper's does not."""


def _particle_filter(
    edges: Edges, surface: Surface, scene: Scene, particles: int, seed: int, doubts: Doubts
) -> OffsetLearner:
    """As published: silhouettes before a plain background, edges before a cluttered one."""
    likelihood = SilhouetteLikelihood() if scene == "plain" else EdgeLikelihood(edges=edges)
    return ParticleFilter(surface, particles=particles, seed=seed, likelihood=likelihood)


def _tracker(
    surface: Surface, scene: Scene, particles: int, seed: int, doubts: Doubts
) -> OffsetLearner:
    """Outlines in information form; as many first guesses as the filter has particles."""
    return ContourTracker(surface, seeds=particles, doubts=doubts, seed=seed)


METHODS: dict[str, Callable[[Edges], Method]] = {
    "particle-filter": lambda edges: Method(partial(_particle_filter, edges), gated=False),
    "track": lambda edges: Method(_tracker, gated=True),
}
"""The methods by name, from the edges that the filter imagines."""

SCENES = {
    "plain": "masks before a plain background, as in section 5.1 of the paper",
    "cluttered": "edges before a cluttered background, the likelihood of section 5.2 of the paper",
}
"""What is compared in each scene."""

PREMISES = {
    "identical": "within the premises: model and robot differ in the offsets alone",
    "mismatched": "outside the premises: eyes and meshes of the model are a little wrong too",
}
"""What each model asks of a method; the paper's simulation has the first alone."""


def premises(scene: Scene, edges: Edges) -> dict[str, str]:
    """How a study stands to what the paper presumes, in words, for its table and its JSON."""
    said = f"{SCENES[scene]}, {EDGES[edges]}" if scene == "cluttered" else SCENES[scene]
    return {"scene": said, **PREMISES}


def check_particles(particles: int) -> None:
    """Refuse a study with nothing to learn with.

    Raises:
        InputError: fewer than two hypotheses.
    """
    if particles < 2:
        raise InputError(f"--particles is {particles}; give 2 or more.")
