"""Joint offsets and mountings from pictures of the body in several postures; no markers.

    seeds     guesses from the prior, scored coarsely on a few postures (`image_seeds`)
    refine    the best of them by Gauss-Newton on contour correspondences (`rim_fit`), the radius
              of the search shrinking; that with the best score is kept
    fit       the same on all postures in full resolution, with a bias for each camera
              If too little of the contour fits, all again from twice as many other guesses.
    say       covariance, directions that are open, share of the contour that fits

Vicente, Jamone, Bernardino 2016 keep the guesses and let them wander; here they only find the basin
of attraction, and what a thousand rim points say of a posture adds up over postures without loss.

Without masks the same is done with edges at first. Then the colours of the body and of what is
around it are learned from the estimate, and their evidence takes the place of the mask; both in
turn, as the colours get better with the estimate.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.body.parameters import Parameters
from bodyschema.body.tree import Body
from bodyschema.errors import InputError
from bodyschema.imagination.colours import ColourModel
from bodyschema.imagination.contours import fit_contours, silhouette
from bodyschema.imagination.observed import ObservedMask
from bodyschema.imagination.poses import piece_poses
from bodyschema.imagination.surface import Surface
from bodyschema.learning.estimate import Estimate
from bodyschema.learning.identifiability import (
    RANDOM_POSTURES,
    Identifiability,
    from_information,
    random_postures,
)
from bodyschema.learning.images.image_seeds import coarse, scored, sobol_seeds, spread_out
from bodyschema.learning.images.rim_fit import RimModel, Sight, design_effect, without_bias
from bodyschema.senses.images import Images

Array = NDArray[np.float64]

COARSE_REACH = (40.0, 40.0, 30.0, 20.0, 15.0, 10.0, 8.0, 6.0)
"""pixels, step by step from a guess."""

FINE_REACH = (15.0, 10.0, 7.0, 5.0, 4.0, 4.0, 4.0, 4.0)
"""pixels, from the best guess in full resolution."""

LEAST_NOISE = 0.3
"""pixels, of a pixel of contour; more while the search is wide."""

CORRELATED = 3.0
"""pixels of contour that err together, at the least."""

LEAST_SAID = 10.0
"""Information in units of the prior below which a direction is open. A shape is never quite right:
a round flange seems to tell a little of its turn."""

LOST, LOST_WITHOUT_MASKS = 0.6, 0.5
"""Share of the contour that must fit."""

ATTEMPTS = 3
"""Sets of guesses, each twice as many as the one before, until the body is found."""


@dataclass(frozen=True)
class MarkerlessFit:
    """What pictures say of a body."""

    estimate: Estimate
    bias: Array
    """(n_cameras,) pixels that the seen outline lies outward of the body's."""
    matched: float
    """Share of the imagined contour that was found within 2 pixels."""
    residual: float
    """Median distance of the found contour, pixels, without the bias."""
    iou: float
    """Mean overlap with the masks; nan without masks."""
    identifiability: Identifiability

    @property
    def lost(self) -> bool:
        """Whether the body is not where the estimate says, or something is before it."""
        return is_lost(self.matched, not np.isnan(self.iou))


@dataclass(frozen=True)
class Markerless:
    """Settings."""

    surface: Surface
    """What shows of the body."""
    seeds: int = 1024
    """Guesses, rounded up to a power of two; 0 trusts the body as it is."""
    postures: int = 3
    """On which guesses are tried."""
    refined: int = 6
    """How many of them are refined."""
    seed: int = 0
    """The same seed gives the same answer."""
    threads: int = 1
    """How many compare pictures; the answer does not depend on it."""

    def fit(self, body: Body, parameters: Parameters, frames: Sequence[Images]) -> MarkerlessFit:
        """Fit to pictures of several postures.

        Args:
            body: as modelled; its frames carry the cameras and the surface's pieces.
            parameters: what may be wrong; their priors say by how much.
            frames: the same cameras in every posture.

        Raises:
            InputError: there is no picture, or the postures have different cameras.
        """
        _check(frames)
        model = RimModel(self.surface, body, parameters)
        answers: list[MarkerlessFit] = []
        while not answers or (answers[-1].lost and self.seeds and len(answers) < ATTEMPTS):
            again = 2 ** len(answers)
            more = replace(
                self,
                seeds=again * self.seeds,
                refined=again * self.refined,
                seed=self.seed + len(answers),
            )
            answers.append(more.fit_once(model, frames))
        return max(answers, key=lambda answer: answer.matched)

    def fit_once(self, model: RimModel, frames: Sequence[Images]) -> MarkerlessFit:
        """From one set of guesses."""
        z = self.start(model, frames) if self.seeds else np.zeros(_size(model, frames))
        sights = self._sights(model, z, frames)
        for reach in FINE_REACH:
            z = _refine(model, sights, z, (reach,))
            if not frames[0].masked:
                sights = self._sights(model, z, frames)
        return self._answer(model, sights, z, frames)

    def start(self, model: RimModel, frames: Sequence[Images]) -> Array:
        """The best refined guess, (n_parameters + n_cameras,)."""
        few = [
            coarse(frames[i]) for i in spread_out(np.array([f.q for f in frames]), self.postures)
        ]
        body, free = model.body, model.parameters
        x = sobol_seeds(free, self.seeds, self.seed)
        best = np.argsort(-scored(self.surface, body, free, x, few, self.threads))[: self.refined]
        refined = []
        for guess in x[best]:
            z = np.concatenate([guess, np.zeros(len(few[0].cameras))])
            for half in (COARSE_REACH[:4], COARSE_REACH[4:]):
                z = _refine(model, self._sights(model, z, few), z, half, 2)
            refined.append(z)
        final = np.array(refined)
        score = scored(self.surface, body, free, final[:, : len(free)], few, self.threads)
        return np.asarray(final[np.argmax(score)])

    def _sights(self, model: RimModel, z: Array, frames: Sequence[Images]) -> list[Sight]:
        """Pictures ready to be searched; without masks, by the colours that z explains."""
        if frames[0].masked:
            return [Sight.of(seen) for seen in frames]
        colours = learn_colours(model, z, frames)
        return [Sight.of(seen, colours) for seen in frames]

    def _answer(
        self, model: RimModel, sights: Sequence[Sight], z: Array, frames: Sequence[Images]
    ) -> MarkerlessFit:
        n = len(model.parameters)
        rows = [model.rows(sight, z, FINE_REACH[-1]) for sight in sights]
        f = design_effect(rows, z, n)
        H = np.sum([r.H for r in rows], axis=0) / f
        known = without_bias(H + np.diag(_bias_prior(model, len(z) - n)), n)
        estimate = Estimate(model.body, model.parameters, z[:n], known)
        left = np.concatenate([np.abs(r.d - r.J[:, n:] @ z[n:]) for r in rows])
        length = sum(r.length for r in rows)
        return MarkerlessFit(
            estimate,
            z[n:],
            sum(r.matched for r in rows) / max(length, 1.0),
            float(np.median(left)) if len(left) else np.inf,
            overlap(model, z, frames),
            from_information(
                estimate, self._at_random(model, sights[0], z, f, len(sights)), LEAST_SAID
            ),
        )

    def _at_random(self, model: RimModel, sight: Sight, z: Array, f: float, count: int) -> Array:
        """Information that as many pictures of random postures would bring."""
        n = len(model.parameters)
        body = model.body.with_parameters(model.parameters, z[:n])
        total = np.diag(_bias_prior(model, len(z) - n))
        for q in random_postures(body, RANDOM_POSTURES, np.random.default_rng(self.seed)):
            total += model.imagined(sight.cameras, q, z) * count / RANDOM_POSTURES / f
        return without_bias(total, n)


def learn_colours(model: RimModel, z: Array, frames: Sequence[Images]) -> list[ColourModel]:
    """Colours of the body and of the rest in each camera, if z is right."""
    body = model.body.with_parameters(model.parameters, z[: len(model.parameters)])
    learned = []
    for c, camera in enumerate(frames[0].cameras):
        T = [piece_poses(body, seen.q, [camera], model.surface.frames)[0, 0] for seen in frames]
        inside = np.concatenate([silhouette(model.surface, pose, camera) for pose in T])
        images = np.concatenate([seen.pictures[c] for seen in frames])
        learned.append(ColourModel.learn(images, inside))
    return learned


def overlap(model: RimModel, z: Array, frames: Sequence[Images]) -> float:
    """Mean Jaccard index over all pictures; nan without masks."""
    if not frames[0].masked:
        return float("nan")
    body = model.body.with_parameters(model.parameters, z[: len(model.parameters)])
    shares = []
    for seen in frames:
        T = piece_poses(body, seen.q, seen.cameras, model.surface.frames)
        masks = [ObservedMask.of(picture) for picture in seen.pictures]
        shares.append(fit_contours(model.surface, T, seen.cameras, masks, False).jaccard)
    return float(np.mean(shares))


def is_lost(matched: float, masked: bool) -> bool:
    """Whether so small a share of the contour tells that the body is not there."""
    return matched < (LOST if masked else LOST_WITHOUT_MASKS)


def noise_at(reach: float) -> float:
    """Pixels, of a pixel of contour that is looked for so far away."""
    return float(max(LEAST_NOISE, reach / 10) * np.sqrt(CORRELATED))


def _refine(
    model: RimModel, sights: Sequence[Sight], z: Array, reaches: Sequence[float], step: int = 1
) -> Array:
    """Gauss-Newton steps, one for each reach."""
    for reach in reaches:
        noise = noise_at(reach)
        parts = [model.normal(model.rows(sight, z, reach, step), z, noise) for sight in sights]
        z = model.solve(parts, len(z) - len(model.parameters))
    return z


def _bias_prior(model: RimModel, n_cameras: int) -> Array:
    """Information of the prior of the biases alone, (n_parameters + n_cameras,)."""
    prior = model.prior(n_cameras)
    prior[: len(model.parameters)] = 0.0
    return prior


def _size(model: RimModel, frames: Sequence[Images]) -> int:
    return len(model.parameters) + len(frames[0].cameras)


def _check(frames: Sequence[Images]) -> None:
    if not frames:
        raise InputError("there is no picture to learn from; give one posture or more.")
    names = [camera.name for camera in frames[0].cameras]
    for seen in frames:
        if [camera.name for camera in seen.cameras] != names or seen.masked != frames[0].masked:
            raise InputError(
                f"all postures need pictures of one kind from the cameras {', '.join(names)}."
            )
