"""Joint offsets and mountings from pictures of the body in several postures; no markers.

    seeds     guesses from the prior, scored coarsely on a few postures (`image_seeds`)
    refine    the best of them by Gauss-Newton on contour correspondences (`rim_fit`), the radius
              of the search shrinking; that with the best score is kept
    fit       the same on all postures in full resolution, and what cameras and meshes may have
              wrong along with it (`doubts`)
              If too little of the contour fits, all again from twice as many other guesses.
              Near the end each picture and each piece has its own weight (`picture_weights`).
    say       covariance, widened by what pictures and pieces contradict each other
              (`disagreement`), directions that are open, share of the contour that fits

Vicente, Jamone, Bernardino 2016 keep the guesses and let them wander; here they only find the basin
of attraction, and what a thousand rim points say of a posture adds up over postures without loss.

Without masks the same is done with edges at first. Then the colours of the body and of what is
around it are learned from the estimate, and their evidence takes the place of the mask; both in
turn, as the colours get better with the estimate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import (
    RANDOM_POSTURES,
    from_information,
    random_postures,
)
from bodyschema.learners.images.disagreement import Disagreement
from bodyschema.learners.images.doubts import Doubts
from bodyschema.learners.images.markerless_fit import MarkerlessFit, overlap, wanted_of
from bodyschema.learners.images.picture_weights import PictureWeights
from bodyschema.learners.images.rim_fit import RimModel, noise_at
from bodyschema.learners.images.rim_information import LEAST_EFFECT, without
from bodyschema.learners.images.sight import Sight
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables
from bodyschema.seeds.image_seeds import (
    best_apart,
    coarse,
    scored,
    sobol_seeds,
    spread_out,
)
from bodyschema.senses.images import Images
from bodyschema.vision.colours import ColourModel
from bodyschema.vision.contours import silhouette
from bodyschema.vision.poses import piece_poses
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]

COARSE_REACH = (40.0, 40.0, 30.0, 20.0, 15.0, 10.0, 8.0, 6.0)
"""pixels, step by step from a guess."""

FINE_REACH = (15.0, 10.0, 7.0, 5.0, 4.0, 4.0, 4.0, 4.0)
"""pixels, from the best guess in full resolution."""

WEIGHED = 5.0
"""pixels: nearer than so, a picture in which little is found does not show the body there, and has
less weight; while the search is wide, it is the guess that is off."""

LEAST_SAID = 10.0
"""Information in units of the prior below which a direction is open. A shape is never quite right:
a round flange seems to tell a little of its turn."""

ATTEMPTS = 3
"""Sets of guesses, each twice as many as the one before, until the body is found."""


@dataclass(frozen=True)
class Markerless:
    """Settings."""

    surface: Surface
    """What shows of the body."""
    seeds: int = 1024
    """Guesses; 0 trusts the body as it is."""
    postures: int = 3
    """On which guesses are tried."""
    refined: int = 6
    """How many of them are refined."""
    seed: int = 0
    """The same seed gives the same answer."""
    doubts: Doubts = field(default_factory=Doubts)
    """What cameras and meshes may have wrong."""
    threads: int = 1
    """How many compare pictures; the answer does not depend on it."""

    def fit(self, body: Body, variables: Variables, frames: Sequence[Images]) -> MarkerlessFit:
        """Fit to pictures of several postures.

        Args:
            body: as modelled; its frames carry the cameras and the surface's pieces.
            variables: what may be wrong; their priors say by how much.
            frames: the same cameras in every posture.

        Raises:
            InputError: there is no picture, or the postures have different cameras.
        """
        _check(frames)
        model = RimModel.of(self.surface, body, variables, frames[0].cameras, self.doubts)
        answers: list[MarkerlessFit] = []
        while not answers or (not answers[-1].agreed and self.seeds and len(answers) < ATTEMPTS):
            again = 2 ** len(answers)
            more = replace(
                self,
                seeds=again * self.seeds,
                refined=again * self.refined,
                seed=self.seed + len(answers),
            )
            answers.append(more.fit_once(model, frames))
        return max(answers, key=lambda answer: answer.weights.total)

    def fit_once(self, model: RimModel, frames: Sequence[Images]) -> MarkerlessFit:
        """From one set of guesses."""
        z = self.start(model, frames) if self.seeds else np.zeros(len(model.scale))
        sights = self.sights(model, z, frames)
        for reach in FINE_REACH:
            z = refine(model, sights, z, (reach,), weighted=reach <= WEIGHED)
            if not frames[0].masked:
                sights = self.sights(model, z, frames)
        return self._answer(model, sights, z, frames)

    def start(self, model: RimModel, frames: Sequence[Images]) -> Array:
        """The refined guess with the best score, (size,)."""
        few = self._few(frames)
        z = np.array(self.guesses(model, frames))
        bodies = [model.posed(guess) for guess in z]
        return np.asarray(z[np.argmax(scored(self.surface, bodies, few, self.threads))])

    def guesses(self, model: RimModel, frames: Sequence[Images]) -> list[Array]:
        """The best of many guesses that differ, refined; each (size,)."""
        few, free = self._few(frames), model.variables
        x = sobol_seeds(free, self.seeds, self.seed)
        bodies = [model.body.with_variables(free, guess) for guess in x]
        score, n = scored(self.surface, bodies, few, self.threads), len(model.wanted)
        best = best_apart(x[:, :n] / free.scale[:n], score, self.refined)
        refined = []
        for guess in x[best]:
            z = np.concatenate([guess, np.zeros(len(model.scale) - len(guess))])
            for half in (COARSE_REACH[:4], COARSE_REACH[4:]):
                z = refine(model, self.sights(model, z, few), z, half, 2)
            refined.append(z)
        return refined

    def _few(self, frames: Sequence[Images]) -> list[Images]:
        """Small pictures of postures that are far from each other."""
        q = np.array([seen.q for seen in frames])
        return [coarse(frames[i]) for i in spread_out(q, self.postures)]

    def sights(self, model: RimModel, z: Array, frames: Sequence[Images]) -> list[Sight]:
        """Pictures ready to be searched; without masks, by the colours that z (size,) explains."""
        if frames[0].masked:
            return [Sight.of(seen) for seen in frames]
        colours = learn_colours(model, z, frames)
        return [Sight.of(seen, colours) for seen in frames]

    def _answer(
        self, model: RimModel, sights: Sequence[Sight], z: Array, frames: Sequence[Images]
    ) -> MarkerlessFit:
        n = len(model.variables)
        seen = [model.rows(sight, z, FINE_REACH[-1]) for sight in sights]
        weights = PictureWeights.of(seen)
        rows = weights.on(seen)
        apart = Disagreement.of(model, rows, z, frames[0].masked)
        H = np.sum([r.H for r in rows], axis=0) / LEAST_EFFECT
        said = without(H, model.scale, n) / apart.kappa
        whole = Estimate(model.body, model.variables, z[:n], said)
        at_random = self._at_random(model, sights[0], z, len(sights)) / apart.kappa
        left = np.concatenate([np.abs(r.left) for r in rows])
        return MarkerlessFit(
            model,
            z,
            whole,
            weights.matched(rows),
            float(np.median(left)) if len(left) else np.inf,
            overlap(model, z, frames),
            from_information(wanted_of(model, whole), at_random, LEAST_SAID),
            weights,
            apart,
        )

    def _at_random(self, model: RimModel, sight: Sight, z: Array, count: int) -> Array:
        """Information on what is wanted that as many pictures of random postures would bring."""
        rng, H = np.random.default_rng(self.seed), np.zeros((len(z), len(z)))
        for q in random_postures(model.posed(z), RANDOM_POSTURES, rng):
            H += model.imagined(sight.cameras, q, z) * count / RANDOM_POSTURES / LEAST_EFFECT
        return without(H, model.scale, len(model.wanted))


def learn_colours(model: RimModel, z: Array, frames: Sequence[Images]) -> list[ColourModel]:
    """Colours of the body and of the rest in each camera, if z is right.

    Returns:
        One for each camera; none if some camera would not see body and surroundings by z.
    """
    body = model.posed(z)
    learned = []
    for c, camera in enumerate(model.cameras(frames[0].cameras, z)):
        T = [piece_poses(body, seen.q, [camera], model.surface.frames)[0, 0] for seen in frames]
        inside = np.concatenate([silhouette(model.surface, pose, camera) for pose in T])
        images = np.concatenate([seen.pictures[c] for seen in frames])
        try:
            learned.append(ColourModel.learn(images, inside))
        except InputError:  # a guess, or an arm that is lost, may stand anywhere
            return []
    return learned


def refine(
    model: RimModel,
    sights: Sequence[Sight],
    z: Array,
    reaches: Sequence[float],
    step: int = 1,
    weighted: bool = False,
) -> Array:
    """Gauss-Newton steps from z (size,), one for each reach; pictures by their weights if asked."""
    for reach in reaches:
        rows = [model.rows(sight, z, reach, step) for sight in sights]
        rows = PictureWeights.of(rows).on(rows) if weighted else rows
        z = model.solve([model.normal(row, z, noise_at(reach)) for row in rows])
    return z


def _check(frames: Sequence[Images]) -> None:
    if not frames:
        raise InputError("there is no picture to learn from; give one posture or more.")
    names = [camera.name for camera in frames[0].cameras]
    for seen in frames:
        if [camera.name for camera in seen.cameras] != names or seen.masked != frames[0].masked:
            raise InputError(
                f"all postures need pictures of one kind from the cameras {', '.join(names)}."
            )
