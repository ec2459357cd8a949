"""The particle filter of Vicente, Jamone, Bernardino 2016: joint offsets from images of the hand.

beta are constant but treated as a state that wanders (Eq. 5-15), so that a bootstrap filter can
follow them; the pose of the hand is a function of beta. In frame t, with sigma in radians:

    predict    beta_m <- beta_m + w,  w ~ N(0, sigma(t)^2 1)                         Eq. 10, 14
               sigma(t) = max(0.8^t sigma(0), floor)                                 Eq. 41
    update     w_m = p(y_t | theta_t, beta_m)                                        Eq. 18
    choose     beta^ = beta_i of the largest  w_i + alpha/M sum_m w_m K(beta_i, beta_m)   Eq. 23
    resample   M equal particles in place of the weighted ones, in every frame

    K = exp(-|beta_i - beta_j|^2 / (2 h^2)) / sqrt(2 pi |h^2 1|)                     Eq. 24-25

K is a density and so depends on the unit. The parameters of the paper are in degrees: there own
weight and smoothed weight are of one size, in radians the former would not count. The choice is
made before the particles are resampled, as after it all weights are equal. The printed factor is
not that of a density in seven dimensions; it only scales alpha and is kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.learner import in_turn
from bodyschema.learners.published.body_errors import BodyError, JointOffsets
from bodyschema.learners.published.image_likelihood import Likelihood, SilhouetteLikelihood
from bodyschema.learners.published.resampling import Resampler, effective_size, systematic
from bodyschema.model.kernels import kernel
from bodyschema.model.tree import Body
from bodyschema.senses.images import Images
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]

NEGLIGIBLE = 40.0
"""Exponent beyond which a neighbour adds less than the rounding of the sum."""


@dataclass(frozen=True)
class ParticleState:
    """The particles between two frames."""

    body: Body
    """What is believed without the offsets."""
    error: BodyError
    """What beta means."""
    beta: Array
    """(M, n) rad, equally weighted."""
    frame: int
    """t, frames seen."""


@dataclass(frozen=True)
class ParticleInfo:
    """What one frame brought."""

    offsets: Array
    """(n,) beta^, rad."""
    covariance: Array
    """(n, n) of the weighted particles, rad^2."""
    effective_size: float
    """1 / sum w^2; M when the images told nothing."""
    likelihood: float
    """Of the chosen particle, up to the likelihood's own factor."""
    noise: float
    """sigma(t), rad."""


@dataclass(frozen=True)
class ParticleFilter:
    """Settings; the defaults are the paper's."""

    surface: Surface
    """What shows of the body."""
    particles: int = 200
    """M, section 4.5."""
    prior: float = float(np.deg2rad(5))
    """rad, standard deviation of beta_0, Eq. 12."""
    noise: float = float(np.deg2rad(4))
    """sigma(0), rad, Eq. 41."""
    decay: float = 0.8
    """Of the noise, a frame, Eq. 41."""
    floor: float = float(np.deg2rad(0.08))
    """rad, section 4.5."""
    alpha: float = 500.0
    """Weight of the neighbours, Eq. 23."""
    width: float = float(np.deg2rad(1))
    """h, rad, Eq. 25."""
    likelihood: Likelihood = field(default_factory=SilhouetteLikelihood)
    """Eq. 20 or 21."""
    resample: Resampler = systematic
    """Section 3.3.1."""
    seed: int = 0
    """The same seed gives the same particles."""
    threads: int = 1
    """How many compare images; the answer does not depend on it."""

    def start(self, body: Body, joints: Sequence[str]) -> ParticleState:
        """Particles from the prior over the offsets of some joints (Eq. 3).

        Args:
            body: what is believed; its frames carry the cameras and the surface's pieces.
            joints: whose offsets are unknown.

        Raises:
            InputError: no such joint.
        """
        for name in joints:
            body.joint_index(name)
        return self.start_from(body, JointOffsets(tuple(joints)))

    def start_from(self, body: Body, error: BodyError) -> ParticleState:
        """Particles from the prior over what is wrong in other terms, such as Eq. 4."""
        rng = np.random.default_rng([self.seed, 0])
        beta = self.prior * rng.normal(size=(self.particles, error.size))
        return ParticleState(body, error, beta, 0)

    def step(
        self, state: ParticleState, moment: tuple[Images, ...]
    ) -> tuple[ParticleState, tuple[ParticleInfo, ...]]:
        """The particles after the images of one moment, and the estimate."""
        return in_turn(self._learn, state, moment)

    def _learn(self, state: ParticleState, seen: Images) -> tuple[ParticleState, ParticleInfo]:
        """The particles after one more frame, and the estimate."""
        rng = np.random.default_rng([self.seed, 1 + state.frame])
        sigma = max(self.noise * self.decay**state.frame, self.floor)
        beta = state.beta + sigma * rng.normal(size=state.beta.shape)
        T = state.error.piece_poses(state.body, seen.q, beta, seen.cameras, self.surface.frames)
        likelihood = self.likelihood(self.surface, T, seen, self.threads)
        # A hand that no particle shows where it is seen tells none of them apart.
        p = likelihood if likelihood.any() else np.ones(len(beta))
        w = p / p.sum()
        chosen = int(np.argmax(self._smoothed(w, beta)))
        info = ParticleInfo(
            offsets=beta[chosen],
            covariance=np.cov(beta.T, aweights=w),
            effective_size=effective_size(w),
            likelihood=float(likelihood[chosen]),
            noise=sigma,
        )
        kept = beta[self.resample(w, self.particles, rng)]
        return ParticleState(state.body, state.error, kept, state.frame + 1), info

    def _smoothed(self, w: Array, beta: Array) -> Array:
        """w' (M,), Eq. 23-25, in degrees."""
        h = np.rad2deg(self.width)
        factor = self.alpha / len(w) / np.sqrt(2 * np.pi * h ** (2 * beta.shape[1]))
        near = np.zeros(len(w))
        neighbours(np.ascontiguousarray(np.rad2deg(beta)), w, h, near)
        return np.asarray(w + factor * near)


@kernel
def neighbours(beta: Array, w: Array, h: float, out: Array) -> None:
    """out_i = sum_m w_m exp(-|beta_i - beta_m|^2 / (2 h^2)); beta (M, n) in the unit of h."""
    n = beta.shape[1]
    for i in range(beta.shape[0]):
        out[i] += w[i]
        for j in range(i):
            exponent = 0.0
            for k in range(n):
                exponent += (beta[i, k] - beta[j, k]) ** 2
            exponent /= 2 * h * h
            if exponent < NEGLIGIBLE:
                K = np.exp(-exponent)
                out[i] += w[j] * K
                out[j] += w[i] * K
