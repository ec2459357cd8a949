"""What is known of the load, the sensor's offset, its mounting and its gains, before a touch.

    R diag(1 + c) y + w = Y phi + b,       x = (z, b, phi, c),   R <- exp(z) R

y is what the sensor exerts, along its own axes; R turns it into the axes of the mount, in which the
load phi and the offset b are known; c corrects the six readings, each for a share of itself. w is
what else acts on the object, along the mount's axes. While nothing does, w is noise, and its slope

    J = dw/dx = ( [R y]x, 1, Y, -R diag(y) )        (6, 25), [R y]x for force and torque each

gives c along with a last correction of the rest by maximum likelihood,

    sum_i ( n/2 log sum w_i^2 - n log(1 + c_i) ) + prior,

(`with_gains`; the noise of each component is whatever w_i shows, and the second term is the density
of y, without which a small c would win by shrinking the noise). A sensor whose gains are off by a
per cent feels touches in all postures but the one where it was tared. The scale that is common to
all forces is not told apart from the mass, nor that of all torques from its first moment; both stay
as uncertain as they were believed to be.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.learners.payload.fit import Solution
from bodyschema.senses.wrench_means import WrenchMeans

Array = NDArray[np.float64]

TURN, BIAS, PHI, GAIN = slice(0, 3), slice(3, 9), slice(9, 19), slice(19, 25)
"""Where the parts of x stand."""

FIRST_MOMENT = slice(10, 13)

UNKNOWNS = 25

ROUNDS = 6
"""Of Gauss-Newton steps."""

LOOSE = 3.0
"""Times what they are known to that load and offset may move when the gains become free, and times
the gains' share of their own size: what was learned with wrong gains is wrong by such a share."""


@dataclass(frozen=True)
class KnownLoad:
    """Load, offset, mounting and gains, with how well they are known."""

    phi: Array
    """(10,) inertial parameters, mount's frame."""
    bias: Array = field(default_factory=lambda: np.zeros(6))
    """(6,) N and Nm along the mount's axes: R times what the sensor reads without a load."""
    R_mount_sensor: Array = field(default_factory=lambda: np.eye(3))
    """(3, 3)."""
    gain: Array = field(default_factory=lambda: np.zeros(6))
    """(6,) c."""
    covariance: Array = field(default_factory=lambda: np.zeros((UNKNOWNS, UNKNOWNS)))
    """(25, 25) of z (3, rad, about the mount's axes), b, phi and c."""

    def __post_init__(self) -> None:
        shapes = {
            "phi": (10,), "bias": (6,), "R_mount_sensor": (3, 3), "gain": (6,),
            "covariance": (UNKNOWNS, UNKNOWNS),
        }  # fmt: skip
        for name, shape in shapes.items():
            array = getattr(self, name)
            if np.shape(array) != shape or not np.isfinite(array).all():
                raise InputError(
                    f"{name} of a known load needs {shape} finite numbers, got {np.shape(array)}."
                )

    @classmethod
    def of(cls, solution: Solution, load: int = 0, whole: Array | None = None) -> KnownLoad:
        """What the learner of payloads found; gains are taken for exact.

        Args:
            solution: of `LoadLearner` or `solve`.
            load: which of its loads hangs on the sensor.
            whole: covariance like that of the solution, with what errs in common; see
                `PayloadFit.whole`.
        """
        guess = solution.guess
        at = [*range(PHI.start), *range(PHI.start + 10 * load, PHI.start + 10 * (load + 1))]
        P = np.zeros((UNKNOWNS, UNKNOWNS))
        C = solution.covariance if whole is None else whole
        P[: GAIN.start, : GAIN.start] = C[np.ix_(at, at)]
        return cls(guess.phi[load], guess.bias, guess.R, covariance=P)

    def unexplained(self, means: WrenchMeans) -> tuple[Array, Array]:
        """w (n, 6) and J (n, 6, 25) of the module's text."""
        R, turned = self.R_mount_sensor, np.zeros((6, 6))
        turned[:3, :3] = turned[3:, 3:] = R
        read = means.y * (1 + self.gain)
        y = read @ turned.T
        J = np.zeros((len(means), 6, UNKNOWNS))
        J[:, :3, TURN], J[:, 3:, TURN] = lie.skew(y[:, :3]), lie.skew(y[:, 3:])
        J[:, :, BIAS], J[:, :, PHI] = np.eye(6), means.Y
        J[:, :, GAIN] = -turned * means.y[:, None, :]
        return means.Y @ self.phi + self.bias - y, J

    def with_gains(self, quiet: WrenchMeans, gain_std: float) -> KnownLoad:
        """With the gains of the six readings corrected too.

        Args:
            quiet: means of a stretch of time in which nothing touches, as long and as varied as
                what the load was learned from.
            gain_std: share of itself by which each reading is believed to be off, such as 0.01.

        Raises:
            InputError: gain_std is not above 0 and below 1.
        """
        if not 0 < gain_std < 1:
            raise InputError(f"gain_std is a share of the reading above 0; got {gain_std:g}.")
        prior = LOOSE**2 * (self.covariance + np.diag((gain_std * self._size()) ** 2))
        prior[GAIN, GAIN] = gain_std**2 * np.eye(6)
        load, root = self, root_of(prior)
        for _ in range(ROUNDS):
            w, J = load.unexplained(quiet)
            # Force tells the first moment by angular accelerations alone, which are known too badly
            # to judge a per cent: torque and moment keep one scale, as force and mass do.
            swung = J[:, :3, FIRST_MOMENT] @ load.phi[1:4]
            J[:, :3, FIRST_MOMENT] = 0.0
            J[:, :3, GAIN.start : GAIN.start + 3] += (
                load.R_mount_sensor * (swung @ load.R_mount_sensor)[:, None]
            )
            H, g, excess = _likelihood(w, J)
            H = root.T @ H @ root + np.eye(root.shape[1])
            # From where x is now the prior pulls back to where it began.
            begun = np.linalg.lstsq(root, self._minus(load), rcond=None)[0]
            load = load._moved(root @ np.linalg.solve(H, begun - root.T @ g))
        values, axes = np.linalg.eigh(H - root.T @ excess @ root)
        # Never flatter than the prior.
        spread = root @ axes / np.sqrt(np.maximum(values, 1.0))
        return replace(load, covariance=spread @ spread.T)

    def _size(self) -> Array:
        """(25,) of x, the gains left at 0."""
        m, arm = abs(self.phi[0]), np.linalg.norm(self.phi[1:4]) / max(abs(self.phi[0]), 1e-9)
        weight = 9.81 * np.repeat([m, m * arm], 3)
        return np.concatenate(
            [np.ones(3), weight, [m], np.full(3, m * arm), np.full(6, m * arm**2), np.zeros(6)]
        )

    def _moved(self, delta: Array) -> KnownLoad:
        return replace(
            self,
            R_mount_sensor=lie.exp_so3(delta[TURN]) @ self.R_mount_sensor,
            bias=self.bias + delta[BIAS],
            phi=self.phi + delta[PHI],
            gain=self.gain + delta[GAIN],
        )

    def _minus(self, other: KnownLoad) -> Array:
        """x of this one seen from the other, (25,)."""
        turn = lie.log_so3(self.R_mount_sensor @ other.R_mount_sensor.T)
        rest = (self.bias - other.bias, self.phi - other.phi, self.gain - other.gain)
        return np.concatenate([turn, *rest])


def root_of(P: Array) -> Array:
    """(n, k) with root root^T = P (n, n), without the columns that are nothing."""
    scale = np.sqrt(np.maximum(np.diag(P), 1e-300))
    values, axes = np.linalg.eigh((P + P.T) / 2 / np.outer(scale, scale))
    seen = values > 1e-12
    return np.asarray(scale[:, None] * axes[:, seen] * np.sqrt(values[seen]))


def _likelihood(w: Array, J: Array) -> tuple[Array, Array, Array]:
    """Of the module's likelihood: curvature (25, 25) that is safe to step with, slope (25,), and
    by how much the true curvature is smaller, which counts at the end."""
    n, v = len(w), np.mean(w**2, axis=0) + 1e-18
    pulls = np.einsum("nik,ni->ik", J, w / v)
    slope, excess = pulls.sum(axis=0), 2 / n * pulls.T @ pulls
    slope[GAIN] -= n
    excess[GAIN, GAIN] -= n * np.eye(6)
    return np.einsum("nik,i,nil->kl", J, 1 / v, J), slope, excess
