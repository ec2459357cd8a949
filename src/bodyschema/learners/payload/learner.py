"""Learns the load on a wrist from a stream: rotation and bias of the sensor, and the load itself.

A belief is the sums of all samples (`sums`), the most likely parameters (`fit`), and what was
believed before them. After each sample the fit goes on from where it was; nothing grows with time.
The belief certifies itself when the 99 % bounds of mass and centre of mass are within what was
asked for, and the residuals look like what the noise explains.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.certificate import REACH
from bodyschema.estimation.loads import com_covariance
from bodyschema.learners.payload.chart import SHARED, USUAL, USUAL_STD, Guess, Prior, wide_prior
from bodyschema.learners.payload.fit import Solution, solve
from bodyschema.learners.payload.noise_levels import Levels, Segment
from bodyschema.learners.payload.sums import Sums, unknowns
from bodyschema.model.inertia import Inertia
from bodyschema.senses.wrench_means import WrenchMeans

Array = NDArray[np.float64]

COLD = 12
"""Samples of a fresh belief that are solved without trust in the solution before."""

MASS_REACH = 2.58
"""Of a normal number's standard deviation: 99 % lie within."""


@dataclass(frozen=True)
class LoadBelief:
    """State of the learner."""

    prior: Prior
    sums: Sums = field(default_factory=Sums.empty)
    solution: Solution | None = None
    """None before the first sample."""
    noise: Levels | None = None
    """Believed before the samples tell."""

    @property
    def load(self) -> Inertia | None:
        """What hangs on the sensor, in the mount's frame."""
        return None if self.solution is None else self.solution.guess.load(0)


@dataclass(frozen=True)
class LoadCertificate:
    """Whether the load is known as well as was asked for."""

    holds: bool
    mass_bound: float
    """kg, two standard deviations."""
    com_bound: float
    """m, 99 % in the worst direction."""
    missing: tuple[str, ...]
    """One sentence for each thing that is missing."""


@dataclass(frozen=True)
class LoadLearner:
    """Settings."""

    turn_std: float = float(np.radians(5))
    """rad: how wrong the sensor's mounting may be about each axis; inf if nobody knows it."""
    force_bias_std: float = 50.0
    """N; tiny for a sensor that was tared without any load."""
    torque_bias_std: float = 5.0
    """Nm."""
    mass_share: float = 0.01
    """Of the mass: the wanted 99 % bound."""
    com: float = 1e-3
    """m: the wanted 99 % bound."""
    R_mount_sensor: Array = field(default_factory=lambda: np.eye(3))
    """(3, 3), as believed."""

    def start(self) -> LoadBelief:
        """Nothing seen yet."""
        bias = np.repeat([self.force_bias_std, self.torque_bias_std], 3)
        return LoadBelief(wide_prior(1, self.R_mount_sensor, min(self.turn_std, 10.0), bias))

    def step(self, belief: LoadBelief, means: WrenchMeans) -> LoadBelief:
        """The belief after one sample, or after several in order of time."""
        sums = belief.sums.add(means)
        noise = belief.noise or Levels(means.std**2, np.full(6, means.memory), means.faith)
        warm = belief.solution is not None and belief.sums.count >= COLD
        start = belief.solution.guess if warm and belief.solution is not None else None
        rounds = 1 if warm and len(means) == 1 else 6
        solution = solve([Segment(sums, (0,))], belief.prior, start, noise, rounds)
        return replace(belief, sums=sums, solution=solution, noise=noise)

    def innovation(self, belief: LoadBelief, mean: WrenchMeans) -> tuple[Array, Array]:
        """Seen less predicted (6,) of one sample, and its covariance (6, 6).

        Raises:
            ValueError: the belief has seen nothing.
        """
        if belief.solution is None:
            raise ValueError("a belief without a sample predicts nothing; take a step first.")
        guess, row = belief.solution.guess, mean.rows[0]
        e = np.einsum("ip,ip->i", row, unknowns(guess.R, guess.phi[0], guess.bias))
        J = _row_slope(guess, row)
        # Levels measured on few samples may be far too low.
        few = 1 + 4 * np.sqrt(2 / (3 * max(belief.sums.count, 1)))
        noise = np.diag(few * belief.solution.levels.variance)
        return e, J @ belief.solution.covariance @ J.T + noise

    def forget_load(self, belief: LoadBelief) -> LoadBelief:
        """A fresh start that keeps what is known of the sensor and of its noise."""
        if belief.solution is None:
            return self.start()
        guess = replace(belief.solution.guess, eta=USUAL[None])
        known = belief.solution.covariance[:SHARED, :SHARED]
        information = np.zeros((SHARED + 10, SHARED + 10))
        information[:SHARED, :SHARED] = np.linalg.inv(known)
        information[SHARED:, SHARED:] = np.diag(1 / USUAL_STD**2)
        return LoadBelief(Prior(guess, information), noise=belief.solution.levels)

    def certificate(self, belief: LoadBelief) -> LoadCertificate:
        """Compare the belief with what was asked for."""
        if belief.solution is None or belief.load is None:
            return LoadCertificate(False, np.inf, np.inf, ("nothing was felt yet.",))
        load, P = belief.load, belief.solution.phi_covariance(0)
        mass = MASS_REACH * float(np.sqrt(P[0, 0]))
        com = float(REACH * np.sqrt(np.linalg.eigvalsh(com_covariance(load, P))[-1]))
        missing = []
        if mass > self.mass_share * load.mass:
            missing.append(
                f"mass is known to {100 * mass / load.mass:.2g} %, wanted "
                f"{100 * self.mass_share:.2g} %."
            )
        if com > self.com:
            missing.append(
                f"the centre of mass is known to {1e3 * com:.2g} mm, wanted "
                f"{1e3 * self.com:.2g} mm."
            )
        return LoadCertificate(not missing, mass, com, tuple(missing))


def _row_slope(guess: Guess, row: Array) -> Array:
    """d e / d (w, b, phi), (6, 19), of a sample's rows (6, 14)."""
    J = np.zeros((6, SHARED + 10))
    # d (R_i y) / dw for exp(w) R: e_i . (w x R y) = w . (R y x e_i).
    for part in (slice(0, 3), slice(3, 6)):
        x, y, z = guess.R @ row[part][0, :3]
        J[part, :3] = [[0, z, -y], [-z, 0, x], [y, -x, 0]]
    J[:, 3:9] = np.diag(row[:, 13])
    J[:, 9:] = row[:, 3:13]
    return J
