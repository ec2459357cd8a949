"""The inertia of a whole arm from its joint torques: links that can exist, friction that brakes.

With W the regressor of `senses.joint_torques`, x = [phi_1 .. phi_L, motors] and one noise level a
joint,

    F = sum_j |tau_j - W_j x|^2 / v_j + pull^T Lambda pull

is minimised over the roots eta of the links and over the logarithms of rotor inertias, viscous and
Coulomb friction, so that masses are positive, moments those of a body, and friction takes energy
out. Directions that torques cannot show (`base_directions`) stay where a wide prior has them, and
the residual does not depend on them. v_j is the mean squared residual of joint j, taken by turns.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.relation_fit import Normal, descend
from bodyschema.model.inertia import phi_of_log_cholesky

Array = NDArray[np.float64]

LINK = np.array([0.5 * np.log(4.0), *[np.log(0.08)] * 3, *[0.0] * 6])
"""eta of a link of 4 kg spread over 8 cm."""

LINK_STD = np.array([1.0, *[1.0] * 3, *[0.1] * 3, *[0.2] * 3])

MOTOR = np.log([0.1, 1.0, 1.0])
"""Logarithms of rotor inertia (kg m^2), viscous (Nm s) and Coulomb friction (Nm), joint side."""

MOTOR_STD, OFFSET_STD = 3.0, 10.0
"""Of these logarithms, and of an offset in Nm."""


STRETCHES, FULLEST = 10, 1 - 1e-9
"""Of time, whose errors may be in common; and the largest share that one has in the fit."""


@dataclass(frozen=True)
class Arm:
    """Links and motors."""

    eta: Array
    """(L, 10)"""
    motors: Array
    """(M, 4) logarithms of rotor inertia, viscous and Coulomb friction; offset in Nm."""

    @property
    def x(self) -> Array:
        """(10 L + 4 M,) what the torques are linear in."""
        phi = [phi_of_log_cholesky(eta)[0] for eta in self.eta]
        return np.concatenate([*phi, self._motors().ravel()])

    def _motors(self) -> Array:
        return np.hstack([np.exp(self.motors[:, :3]), self.motors[:, 3:]])

    def slope(self) -> Array:
        """dx over the free numbers, square."""
        size, L = self.eta.size + self.motors.size, len(self.eta)
        J = np.zeros((size, size))
        for k, eta in enumerate(self.eta):
            J[10 * k : 10 * k + 10, 10 * k : 10 * k + 10] = phi_of_log_cholesky(eta)[1]
        change = self._motors()
        change[:, 3] = 1.0
        J[10 * L :, 10 * L :] = np.diag(change.ravel())
        return J


@dataclass(frozen=True)
class ArmProblem:
    """F at fixed noise levels; see `relation_fit.descend`."""

    C: Array
    """(p, p) sum of W^T W / v."""
    d: Array
    """(p,) sum of W^T tau / v."""
    whole: float
    """Sum of tau^2 / v."""
    middle: Arm
    information: Array
    """(p,) of the prior."""

    def normal(self, theta: Arm) -> Normal:
        """Cost, half slope and H."""
        x, J = theta.x, theta.slope()
        pull = _free(theta) - _free(self.middle)
        Cx, drawn = self.C @ x, self.information * pull
        cost = self.whole + float(x @ Cx - 2 * x @ self.d + pull @ drawn)
        H = J.T @ self.C @ J + np.diag(self.information)
        return Normal(cost, J.T @ (Cx - self.d) + drawn, (H + H.T) / 2)

    def move(self, theta: Arm, delta: Array) -> Arm:
        """A step, no longer than a factor e^1.5 in any logarithm."""
        step = delta / max(float(np.abs(delta).max()) / 1.5, 1.0)
        split = theta.eta.size
        return replace(
            theta,
            eta=theta.eta + step[:split].reshape(-1, 10),
            motors=theta.motors + step[split:].reshape(-1, 4),
        )


def _free(arm: Arm) -> Array:
    return np.concatenate([arm.eta.ravel(), arm.motors.ravel()])


def fit_arm(W: Array, tau: Array, links: int, rounds: int = 5) -> Arm:
    """Links and motors of an arm.

    Args:
        W: (n, n_joints, 10 links + 4 n_motors).
        tau: (n, n_joints) Nm, thinned out until samples are independent.
        links: L.
        rounds: turns of fit and noise levels.
    """
    motors = (W.shape[2] - 10 * links) // 4
    arm = Arm(np.tile(LINK, (links, 1)), np.tile([*MOTOR, 0.0], (motors, 1)))
    std = [*np.tile(LINK_STD, links), *np.tile([*[MOTOR_STD] * 3, OFFSET_STD], motors)]
    middle, v = arm, np.mean(tau**2, axis=0)
    for _ in range(rounds):
        whitened = W / np.sqrt(v)[:, None]
        y = tau / np.sqrt(v)
        C = np.einsum("njp,njq->pq", whitened, whitened, optimize=True)
        d = np.einsum("njp,nj->p", whitened, y)
        problem = ArmProblem(C, d, float(np.sum(y**2)), middle, 1 / np.square(std))
        arm, _, _ = descend(problem, arm, 60, 1e-2)
        v = np.mean((tau - W @ arm.x) ** 2, axis=0)
    return arm


def arm_covariance(W: Array, tau: Array, arm: Arm) -> Array:
    """What is not known of x: noise of each joint, the prior, and what errs in common.

    With A the whitened slope by the free numbers, z the whitened residuals, and C = (A^T A +
    Lambda)^-1, stretches of time pull the fit by C g_c, g_c = A_c^T (1 - A_c C A_c^T)^-1/2 z_c. The
    torque that they move, over that which C says, is the factor kappa by which C is too small.

    Args:
        W: (n, n_joints, p) in order of time.
        tau: (n, n_joints) Nm.
        arm: fitted to them.

    Returns:
        (p, p) of x, symmetric.
    """
    left, links, motors = tau - W @ arm.x, len(arm.eta), len(arm.motors)
    root = np.sqrt(np.mean(left**2, axis=0))
    J = arm.slope()
    A, z = (W / root[:, None]) @ J, left / root
    std = [*np.tile(LINK_STD, links), *np.tile([*[MOTOR_STD] * 3, OFFSET_STD], motors)]
    H = np.einsum("njp,njq->pq", A, A, optimize=True) + np.diag(1 / np.square(std))
    values, vectors = np.linalg.eigh(H)
    L = vectors / np.sqrt(values)
    B, count = A @ L, min(STRETCHES, len(tau))
    moved = []
    for rows in np.array_split(np.arange(len(tau)), count):
        b = B[rows].reshape(-1, B.shape[2])
        shares, axes = np.linalg.eigh(b.T @ b)
        factor = 1 / np.sqrt(1 - np.clip(shares, 0.0, FULLEST))
        moved.append(axes @ (factor * (axes.T @ (b.T @ z[rows].ravel()))))
    told = float(np.sum(B**2))
    kappa = float(np.sum((B @ np.array(moved).T) ** 2)) / max(told, 1e-300)
    wide = np.sqrt(max(kappa, 1.0)) * (J @ L)
    return np.asarray(wide @ wide.T)
