"""Learns the load on a wrist from a stream: rotation and bias of the sensor, and the load itself.

A belief is the sums of all samples (`sums`), the most likely parameters (`fit`), and what was
believed before them. After each sample the fit goes on from where it was; nothing grows with time.
The belief certifies itself when the 99 % bounds of mass and centre of mass are within what was
asked for.

Round it, a `Monitor` notices that the load changed, forgets the load alone - rotation and bias of
the sensor stay, with their doubt, so the next load is known soon - and names the change when the
new load is known (`load_change`). Innovations are honest from the first sample on: noise that
remembers counts at its long-run size, and levels of few samples at more than they say.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.estimation.belief import (
    GaussianBelief,
    Slopes,
    WhiteInnovation,
    forget,
    inverse,
)
from bodyschema.estimation.certificate import Certificate, Tolerance
from bodyschema.estimation.loads import com_slope
from bodyschema.estimation.stream_noise import StreamNoise
from bodyschema.learners.learner import MonitoredLearner, Pace, in_turn
from bodyschema.learners.payload.chart import SHARED, USUAL, USUAL_STD, Guess, Prior, wide_prior
from bodyschema.learners.payload.fit import Solution, solve
from bodyschema.learners.payload.load_change import load_change
from bodyschema.learners.payload.noise_levels import Levels, Segment
from bodyschema.learners.payload.sums import Sums, unknowns
from bodyschema.model.inertia import Inertia
from bodyschema.senses.wrench_means import WrenchMeans

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

COLD = 12
"""Samples of a fresh belief that are solved without trust in the solution before."""

LOAD = np.arange(SHARED, SHARED + 10)
"""Places of the load's parameters phi behind rotation and bias."""

QUIET = StreamNoise(outliers=0.0)
"""Levels are measured by the learner, and hardly a mean is an outlier."""


@dataclass(frozen=True)
class LoadBelief:
    """State of the learner."""

    prior: Prior
    sums: Sums = field(default_factory=Sums.empty)
    solution: Solution | None = None
    """None before the first sample."""
    noise: Levels | None = None
    """Believed before the samples tell."""
    tool: Inertia | None = None
    """The lightest load that was forgotten, or the one that was declared."""

    @property
    def load(self) -> Inertia | None:
        """What hangs on the sensor, in the mount's frame."""
        return None if self.solution is None else self.solution.guess.load(0)


@dataclass(frozen=True)
class LoadLearner(MonitoredLearner[LoadBelief, WrenchMeans, tuple[Solution, ...]]):
    """Settings; watch it with a `Monitor`."""

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
    tool: Inertia | None = None
    """What hangs on the sensor when nothing is held, if it is known."""

    @property
    def blocks(self) -> Mapping[str, Ints]:
        """The load; the sensor is screwed on."""
        return {"load": LOAD}

    @property
    def pace(self) -> Pace:
        """Of some seven means a second, whose errors return with the posture."""
        return Pace(rate=7.5, wait=8, settle=4, look=1, ratios=False, early=True)

    def start(self) -> LoadBelief:
        """Nothing seen yet."""
        bias = np.repeat([self.force_bias_std, self.torque_bias_std], 3)
        prior = wide_prior(1, self.R_mount_sensor, min(self.turn_std, 10.0), bias)
        return LoadBelief(prior, tool=self.tool)

    def step(
        self, state: LoadBelief, moment: tuple[WrenchMeans, ...]
    ) -> tuple[LoadBelief, tuple[Solution, ...]]:
        """Learn from one sample, or from several in order of time."""
        return in_turn(self._learn, state, moment)

    def _learn(self, belief: LoadBelief, means: WrenchMeans) -> tuple[LoadBelief, Solution]:
        sums = belief.sums.add(means)
        noise = belief.noise or Levels(means.std**2, np.full(6, means.memory), means.faith)
        warm = belief.solution is not None and belief.sums.count >= COLD
        start = belief.solution.guess if warm and belief.solution is not None else None
        rounds = 1 if warm and len(means) == 1 else 6
        solution = solve([Segment(sums, (0,))], belief.prior, start, noise, rounds)
        return replace(belief, sums=sums, solution=solution, noise=noise), solution

    def innovation(self, state: LoadBelief, moment: tuple[WrenchMeans, ...]) -> WhiteInnovation:
        """Means against what the belief predicts; force and torque are sources of their own."""
        solution = _solved(state)
        guess, levels = solution.guess, solution.levels
        # Levels measured on few samples may be far too low.
        few = 1 + 4 * np.sqrt(2 / (3 * max(state.sums.count, 1)))
        root = np.sqrt((few + levels.tau - 1) * levels.variance)
        z = unknowns(guess.R, guess.phi[0], guess.bias)
        rows = np.concatenate([means.rows for means in moment])
        e = np.einsum("nip,ip->ni", rows, z) / root
        # Residuals vanish at the truth, so they fall with the variables.
        J = np.array([-_row_slope(guess, row) / root[:, None] for row in rows])
        source = np.repeat(np.arange(2 * len(rows)), 3)
        return WhiteInnovation(e.ravel(), J.reshape(-1, J.shape[2]), source)

    def belief(self, state: LoadBelief) -> GaussianBelief:
        """Of rotation, bias and phi."""
        if state.solution is None or state.load is None:
            return GaussianBelief(np.eye(SHARED + 10), begun=False)
        tolerance = Tolerance(
            {"mass": self.mass_share * state.load.mass, "centre of mass": self.com}
        )
        return GaussianBelief(state.solution.covariance, tolerance, QUIET)

    def certificate(self, state: LoadBelief) -> Certificate:
        """Whether mass and centre of mass are known well enough."""
        belief, load = self.belief(state), state.load
        if load is None:
            return belief.certificate({})
        J = np.zeros((1, 4, SHARED + 10))
        J[0, 0, SHARED] = 1.0
        J[0, 1:, SHARED : SHARED + 4] = com_slope(load)
        return belief.certificate(
            {"mass": Slopes(J[:, :1], "kg"), "centre of mass": Slopes(J[:, 1:], "m")}
        )

    def forget(self, state: LoadBelief, block: str) -> LoadBelief:
        """A fresh start that keeps what is known of the sensor and of its noise."""
        solution, load, tool = _solved(state), state.load, state.tool
        known, guess = inverse(solution.covariance), solution.guess
        if block:
            known, guess = forget(known, LOAD, USUAL_STD**-2), replace(guess, eta=USUAL[None])
        else:
            T = np.eye(SHARED + 10)
            T[SHARED:, SHARED:] = guess.loads_and_slopes()[1][0]
            known = T.T @ known @ T
        if self.tool is None and load is not None and (tool is None or load.mass < tool.mass):
            tool = load
        return LoadBelief(Prior(guess, known), noise=solution.levels, tool=tool)

    def difference(self, state: LoadBelief, earlier: LoadBelief) -> Array:
        """(19,) the step of rotation, bias and phi."""
        new, old = _solved(state).guess, _solved(earlier).guess
        turn = lie.log_so3(new.R @ old.R.T)
        return np.concatenate([turn, new.bias - old.bias, new.phi[0] - old.phi[0]])

    def change(self, before: LoadBelief, after: LoadBelief) -> str:
        """Grasp, release, swap, shift, or the same load."""
        return load_change(_solved(before), _solved(after), after.tool)


def _solved(state: LoadBelief) -> Solution:
    """The solution, once something was felt."""
    if state.solution is None:
        raise ValueError("a belief without a sample predicts nothing; take a step first.")
    return state.solution


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
