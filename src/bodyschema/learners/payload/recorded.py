"""The load of a whole recording: all samples at once, wild ones left out.

A recording has parts, each with the loads that hang on the sensor during it: the hand alone in one,
the hand and what it holds in another; rotation and bias of the sensor are common to all. After a
first fit, samples beyond the 1e-7 point of chi-square for the size that residuals have in the
median are left out (a touch, a spike), and the fit is repeated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.learners.payload.chart import SHARED, wide_prior
from bodyschema.learners.payload.fit import Solution, solve
from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.payload.noise_levels import Levels, Segment
from bodyschema.learners.payload.sums import Sums, unknowns
from bodyschema.learners.payload.untold import Untold, untold
from bodyschema.model.inertia import Inertia
from bodyschema.senses.wrench_means import WrenchMeans
from bodyschema.threads import one_thread

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

ROUNDS = 3
WILD = 43.0
"""Squared residual of six components that chance exceeds once in ten million."""

LEVER = 0.02
"""m: least lever of a torque that shares are taken of."""

TARED = 1.0
"""N: an offset that is known better does not hide a weight."""

NEGATIVE, CONVINCING = 3.0, 0.9
"""Standard deviations below zero at which a mass means a wrong sign, and the share of the force's
variance that it must explain; less means a wrong frame rather."""


@dataclass(frozen=True)
class Part:
    """A stretch of a recording and the loads in it."""

    means: WrenchMeans
    loads: tuple[str, ...]


@dataclass(frozen=True)
class PayloadFit:
    """What a recording says."""

    solution: Solution
    names: tuple[str, ...]
    """Of the loads, in the solution's order."""
    parts: tuple[Part, ...]
    kept: tuple[Flags, ...]
    """Of each part's samples, those that were not wild."""
    tared: bool = False
    """Whether the sensor's offset was known beforehand."""
    whole: Array | None = None
    """(9 + 10 K, 9 + 10 K) covariance of w, b, phi_1 .. phi_K with all that is known to err in
    common; None: of noise alone."""

    @property
    def loads(self) -> Mapping[str, Inertia]:
        """In the mount's frame."""
        return {name: self.solution.guess.load(k) for k, name in enumerate(self.names)}

    def covariance(self, name: str) -> Array:
        """(10, 10) of a load's phi: `whole` where it is known, else that of noise."""
        k = self.names.index(name)
        if self.whole is None:
            return self.solution.phi_covariance(k)
        at = slice(SHARED + 10 * k, SHARED + 10 * (k + 1))
        return self.whole[at, at]

    def untold(self, name: str) -> tuple[Untold, ...]:
        """What the recording leaves open of a load, and why."""
        load, noise = self.loads[name], self.solution.phi_covariance(self.names.index(name))
        turned = np.inf if self.tared else self.span
        return untold(load, self.covariance(name), noise, turned)

    @property
    def span(self) -> float:
        """Spread of gravity less acceleration along the sensor's axes, as a share of itself."""
        parts = zip(self.parts, self.kept, strict=True)
        g = np.concatenate([part.means.Y[kept][:, :3, 0] for part, kept in parts])
        size = float(np.median(np.linalg.norm(g, axis=1)))
        return float(np.sqrt(np.sum(np.var(g, axis=0)))) / max(size, 1e-9)

    def residuals(self, part: int) -> Array:
        """(n, 6) N and Nm, along the mount's axes: the wrench that nothing explains."""
        guess, names = self.solution.guess, self.parts[part].loads
        phi = guess.phi[[self.names.index(name) for name in names]].sum(axis=0)
        z = unknowns(guess.R, phi, guess.bias)
        return np.asarray(np.einsum("nip,ip->ni", self.parts[part].means.rows, z))

    @property
    def unexplained(self) -> Array:
        """(2,) shares of force and of torque, bias removed, that are left over, rms.

        A load close to the sensor has next to no torque, which counts as that of a lever of
        `LEVER` then.
        """
        bias, R = self.solution.guess.bias, self.R
        left, whole = np.zeros(2), np.zeros(2)
        for k, part in enumerate(self.parts):
            y = np.hstack([part.means.y[:, :3] @ R.T, part.means.y[:, 3:] @ R.T]) - bias
            for values, sums in ((self.residuals(k), left), (y, whole)):
                sums += np.sum(values[self.kept[k]].reshape(-1, 2, 3) ** 2, axis=(0, 2))
        whole[1] = max(whole[1], LEVER**2 * whole[0])
        return np.asarray(np.sqrt(left / np.maximum(whole, 1e-300)))

    @property
    def R(self) -> Array:
        """(3, 3) from the sensor's axes to the mount's."""
        return self.solution.guess.R


@one_thread
def fit_payload(parts: Sequence[Part], learner: LoadLearner) -> PayloadFit:
    """Fit all loads of a recording.

    Args:
        parts: at least one; each sample of one part feels the same loads.
        learner: what is believed of the sensor.

    Raises:
        InputError: there are too few samples to tell anything, or the mass is negative.
    """
    names = tuple(dict.fromkeys(name for part in parts for name in part.loads))
    total = sum(len(part.means) for part in parts)
    if total < 2:
        raise InputError(
            f"only {total} usable sample was found; a load needs several orientations of the "
            "sensor, or motion."
        )
    bias = np.repeat([learner.force_bias_std, learner.torque_bias_std], 3)
    turn = min(learner.turn_std, 10.0)
    prior = wide_prior(len(names), learner.R_mount_sensor, turn, bias)
    first = parts[0].means
    noise = Levels(first.std**2, np.full(6, first.memory), first.faith)
    kept = [np.ones(len(part.means), dtype=bool) for part in parts]
    refuse_negative(parts, learner)
    start = None
    for _ in range(ROUNDS):
        segments = [
            Segment(
                Sums.empty().add(part.means.take(keep)),
                tuple(names.index(name) for name in part.loads),
            )
            for part, keep in zip(parts, kept, strict=True)
        ]
        solution = solve(segments, prior, start, noise)
        fit = PayloadFit(solution, names, tuple(parts), tuple(kept), learner.force_bias_std < TARED)
        tame = [_tame(fit.residuals(k), solution.levels.variance) for k in range(len(parts))]
        if all(np.array_equal(a, b) for a, b in zip(tame, kept, strict=True)):
            break
        kept, start = tame, solution.guess
    return fit


def _tame(e: Array, variance: Array) -> Flags:
    """Samples that are not wild, by the median size of residuals or the fitted one, the smaller."""
    usual = (np.median(np.abs(e), axis=0) / 0.6745) ** 2
    size = np.minimum(np.maximum(usual, 1e-2 * variance), variance)
    return np.asarray(np.sum(e**2 / size, axis=1) < WILD)


def refuse_negative(parts: Sequence[Part], learner: LoadLearner) -> None:
    """Say so if gravity is felt with the wrong sign.

    The force alone is regressed on mass, first moments and bias at the believed rotation, without
    asking that a body could have them.

    Raises:
        InputError: the mass is clearly negative.
    """
    if learner.turn_std > 1.0:
        return
    y = np.concatenate([part.means.y[:, :3] for part in parts]) @ learner.R_mount_sensor.T
    Y = np.concatenate([part.means.Y[:, :3, :4] for part in parts])
    A = np.concatenate([Y, np.tile(np.eye(3), (len(Y), 1, 1))], axis=2).reshape(-1, 7)
    prior = np.diag([1e-4, 1.0, 1.0, 1.0, *[learner.force_bias_std**-2] * 3])
    H = A.T @ A
    for _ in range(2):
        found = np.linalg.solve(H + prior, A.T @ y.reshape(-1))
        left = y.reshape(-1) - A @ found
        variance = max(float(left @ left) / max(left.size - 7, 1), 1e-12)
        std = np.sqrt(variance * np.linalg.inv(H + variance * prior)[0, 0])
    whole = y - y.mean(axis=0)
    explained = 1 - float(left @ left) / max(float(np.sum(whole**2)), 1e-300)
    if found[0] < -NEGATIVE * std and explained > CONVINCING:
        raise InputError(
            f"the mass comes out as {found[0]:.3f} ± {std:.3f} kg: the wrench is recorded with the "
            'other sign; set sign = "on_sensor" for a sensor that reads the load\'s pull, '
            '"on_object" for one that reads its own push. If the base hangs upside down, down is '
            "[0.0, 0.0, 9.81] under [motion]."
        )
