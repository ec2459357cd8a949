"""A guess of rotation, loads and bias, and the 9 + 10 K numbers by which it may be wrong.

    R <- exp(w) R,   b <- b + db,   eta_k <- eta_k + deta_k        in the order w, b, eta_1 .. eta_K

eta is the root of the load's pseudo-inertia (`model.inertia`), so that each step ends at a load
that can exist. A segment of a recording carries the sum of some of the loads: the hand alone, then
the hand and what it holds.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.inertia import Inertia, phi_of_log_cholesky

Array = NDArray[np.float64]

SHARED = 9
"""Variables that all segments share: rotation and bias."""

LONGEST_TURN, LONGEST_ROOT = 0.7, 2.0
"""rad, and units of eta, that one step may take."""


@dataclass(frozen=True)
class Guess:
    """A place in the chart."""

    R: Array
    """(3, 3) from the sensor's axes to the mount's."""
    bias: Array
    """(6,) N and Nm along the mount's axes, what the sensor reads without a load."""
    eta: Array
    """(K, 10) roots of the loads, in the mount's frame."""

    def moved(self, delta: Array) -> Guess:
        """After a step (9 + 10 K,), shortened to what one step may take."""
        turn, root = delta[:3], delta[SHARED:].reshape(-1, 10)
        longest = max(
            float(np.linalg.norm(turn)) / LONGEST_TURN,
            float(np.abs(root[:, :4]).max(initial=0.0)) / LONGEST_ROOT,
            1.0,
        )
        return replace(
            self,
            R=lie.exp_so3(turn / longest) @ self.R,
            bias=self.bias + delta[3:SHARED] / longest,
            eta=self.eta + root / longest,
        )

    @property
    def phi(self) -> Array:
        """(K, 10) inertial parameters of the loads."""
        return self.loads_and_slopes()[0]

    def loads_and_slopes(self) -> tuple[Array, Array]:
        """phi (K, 10) and d phi / d eta (K, 10, 10)."""
        pairs = [phi_of_log_cholesky(eta) for eta in self.eta]
        return np.array([phi for phi, _ in pairs]), np.array([slope for _, slope in pairs])

    def load(self, k: int) -> Inertia:
        """Load k."""
        return Inertia.from_phi(phi_of_log_cholesky(self.eta[k])[0])


@dataclass(frozen=True)
class Prior:
    """What is believed before the first sample: a Gaussian in the chart."""

    guess: Guess
    information: Array
    """(9 + 10 K, 9 + 10 K) inverse covariance."""

    def pull(self, guess: Guess) -> Array:
        """(9 + 10 K,) how far a guess is from the middle, to first order in the turn."""
        turn = lie.log_so3(guess.R @ self.guess.R.T)
        return np.concatenate(
            [turn, guess.bias - self.guess.bias, (guess.eta - self.guess.eta).ravel()]
        )


USUAL = np.array([0.5 * np.log(0.5), *[np.log(0.05)] * 3, *[0.0] * 6])
"""eta of half a kilogram spread over 5 cm: the middle of what robots hold."""

USUAL_STD = np.array([2.5, *[1.2] * 3, *[0.1] * 3, *[0.5] * 3])
"""So wide that it only matters where the motion says nothing: mass within a factor 150, extent
within a factor 3, centre within 0.5 m."""


EXTENT = 0.15
"""m: radius of gyration up to which moments that the motion does not show are left open."""


def open_information(phi: Array) -> Array:
    """(10,) inverse variances of phi that stand for knowing next to nothing of a load.

    Stated uncertainty comes from the linear parameters, not from their roots: where the best load
    sits on the edge of what can exist, the roots make it look far too certain.
    """
    m = max(float(phi[0]), 1e-3)
    std = np.array([100.0, *[100.0] * 3, *[m * EXTENT**2] * 6])
    return np.asarray(1 / std**2)


def wide_prior(loads: int, R: Array, turn_std: float, bias_std: Array) -> Prior:
    """Before anything is known of the loads.

    Args:
        loads: K.
        R: (3, 3) the rotation that is believed.
        turn_std: rad, how wrong it may be about each axis.
        bias_std: (6,) N and Nm.
    """
    guess = Guess(R, np.zeros(6), np.tile(USUAL, (loads, 1)))
    std = np.concatenate([np.full(3, turn_std), bias_std, np.tile(USUAL_STD, loads)])
    return Prior(guess, np.diag(1 / std**2))
