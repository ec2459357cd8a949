"""What a recording says of a load, as an estimate over the parts of a body.

The fit knows theta = (w, b, phi_1 .. phi_K): turn and offset of the sensor along the mount's axes
and the loads in the mount's frame (`chart`). A body has the frame "sensor", whose placement turns,
the part "force sensor" with its offsets, and a part "load" for each load, all in the sensor's own
frame as `senses.wrist_wrenches` has them. With R from the sensor's axes to the mount's,

    turn   x_R = log R,           d x_R = J_r(x_R)^-1 R^T w
    offset o = R^T b,             d o   = R^T db + R^T [b]x w
    load   phi' is phi in the sensor's frame, eta its roots:   d eta = (d phi' / d eta)^-1 d phi'

so the covariance is J P J^T. Its inverse less the prior is what the data said; directions in which
the prior of the roots says more than all data are left to the prior.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import (
    SAYS_LITTLE,
    Identifiability,
    OpenDirection,
)
from bodyschema.estimation.loads import SIX
from bodyschema.learners.payload.chart import SHARED
from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.payload.recorded import PayloadFit
from bodyschema.model.inertia import (
    Inertia,
    log_cholesky,
    nearest_physical,
    phi_of_log_cholesky,
    symmetric,
)
from bodyschema.model.kernels import FIXED, TURN
from bodyschema.model.parts import force_sensor, load
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_part, join

Array = NDArray[np.float64]

SENSOR, CHANNELS = "force sensor", ("fx", "fy", "fz", "tx", "ty", "tz")
"""Name of the part with the sensor's offsets."""

SURE = 1e-4
"""rad: a mounting that is known better is not looked for."""

WIDEST = 3.0
"""rad: prior of a turn of which nothing is known."""


@dataclass(frozen=True)
class WristFrames:
    """The body that a wrist sensor is part of."""

    body: Body
    """With the sensor as declared, and no loads yet."""
    sensor: str
    """Its frame."""

    @classmethod
    def on(cls, body: Body | None, link: str, T_link_sensor: Array) -> WristFrames:
        """A sensor on a link of a robot, or on a flange of which nothing else is known.

        Args:
            body: the robot; None if there is no description.
            link: that carries it.
            T_link_sensor: (4, 4) as declared.
        """
        if body is None:
            flat = [[0.0, 0.0, 1.0]]
            body = Body.build("wrist", ["flange"], [""], [-1], [FIXED], flat, np.eye(4)[None])
            link = "flange"
        name = "sensor"
        while name in body.frames:
            name = f"wrist_{name}"
        return cls(body.attach(name, link, T_link_sensor), name)


def load_estimate(fit: PayloadFit, frames: WristFrames, learner: LoadLearner) -> Estimate:
    """The belief over turn and offset of the sensor and the loads.

    Args:
        fit: of a recording.
        frames: the body with the sensor.
        learner: with the priors of the sensor.
    """
    body = frames.body.with_part(SENSOR, force_sensor())
    for name in fit.names:
        body = body.with_part(name, load())
    variables = _variables(body, frames.sensor, fit, learner)
    values, J = _charted(fit)
    there = values - np.concatenate([np.zeros(SHARED), *[body.part(n).values for n in fit.names]])
    kept = np.ones(len(there), dtype=bool)
    kept[:3] = learner.turn_std > SURE
    J = J[kept]
    C = J @ _whole_covariance(fit) @ J.T
    noise = np.sqrt(fit.solution.levels.variance.reshape(2, 3).mean(axis=1))
    label = f"wrench of {' and '.join(fit.names)} on {frames.sensor}"
    return Estimate(
        body,
        variables,
        there[kept],
        _beyond(C, variables.prior_std),
        {f"{label}: force (N)": float(noise[0]), f"{label}: torque (Nm)": float(noise[1])},
        converged=fit.solution.settled,
    )


def load_identifiability(fit: PayloadFit, estimate: Estimate) -> Identifiability:
    """What the motion did not tell, in the words of `untold`."""
    scale = estimate.variables.scale
    F = scale[:, None] * estimate.data_information * scale
    values, vectors = np.linalg.eigh(F)
    said = dict[str, OpenDirection]()
    for name in fit.names:
        for one in fit.untold(name):
            sentence = one.sentence if len(fit.names) == 1 else f"{name}: {one.sentence}"
            said.setdefault(sentence, OpenDirection((f"{name}.{one.what}",), False, sentence))
    open_share = np.sum(vectors[:, values < SAYS_LITTLE].T ** 2, axis=0)
    return Identifiability(int(np.sum(values >= SAYS_LITTLE)), tuple(said.values()), open_share)


def _variables(body: Body, sensor: str, fit: PayloadFit, learner: LoadLearner) -> Variables:
    offsets = [f"offset_{channel}" for channel in CHANNELS]
    stds = np.repeat([learner.force_bias_std, learner.torque_bias_std], 3)
    prior = dict(zip(offsets, stds.tolist(), strict=True))
    parts = [free_part(body, SENSOR, offsets, prior), *(free_part(body, n) for n in fit.names)]
    if learner.turn_std <= SURE:
        return join(*parts)
    placed = free_frame(body, sensor, 1.0, min(learner.turn_std, WIDEST))
    turns = placed.take(np.flatnonzero(placed.code == TURN).tolist())
    return join(turns, *parts)


def _charted(fit: PayloadFit) -> tuple[Array, Array]:
    """Turn, offset and roots of the loads (9 + 10 K,), and their derivatives by theta."""
    R, b, K = fit.R, fit.solution.guess.bias, len(fit.names)
    turn, J = lie.log_so3(R), np.zeros((SHARED + 10 * K, SHARED + 10 * K))
    J[:3, :3] = np.linalg.solve(lie.right_jacobian(turn), R.T)
    for i in (0, 3):
        J[3 + i : 6 + i, :3] = R.T @ lie.skew(b[i : i + 3])
        J[3 + i : 6 + i, 3 + i : 6 + i] = R.T
    values, back = [turn, (b.reshape(2, 3) @ R).ravel()], lie.transform(R.T, np.zeros(3))
    for k, name in enumerate(fit.names):
        at = slice(SHARED + 10 * k, SHARED + 10 * (k + 1))
        phi = fit.loads[name].in_frame(back).phi
        eta = log_cholesky(phi if Inertia.from_phi(phi).physical else nearest_physical(phi, 1e-4))
        slope = phi_of_log_cholesky(eta)[1]
        by_turn, by_phi = _turned_slopes(fit.loads[name].phi, R)
        J[at, :3] = np.linalg.solve(slope, by_turn)
        J[at, at] = np.linalg.solve(slope, by_phi)
        values.append(eta)
    return np.concatenate(values), J


def _turned_slopes(phi: Array, R: Array) -> tuple[Array, Array]:
    """Derivatives of phi' by w (10, 3) and by phi (10, 10): R^T exp(-w) turns h and I."""
    h, moments, axes = phi[1:4], symmetric(phi[4:]), np.eye(3)
    by_turn = np.zeros((10, 3))
    for k, S in enumerate(lie.skew(axes)):
        by_turn[1:4, k] = R.T @ np.cross(h, axes[k])
        by_turn[4:, k] = _six(R.T @ (moments @ S - S @ moments) @ R)
    by_phi = np.zeros((10, 10))
    by_phi[0, 0], by_phi[1:4, 1:4] = 1.0, R.T
    for k, one in enumerate(np.eye(6)):
        by_phi[4:, 4 + k] = _six(R.T @ symmetric(one) @ R)
    return by_turn, by_phi


def _six(moments: Array) -> Array:
    """xx, xy, yy, xz, yz, zz of (3, 3)."""
    return np.array([moments[i, j] for i, j in SIX])


def _whole_covariance(fit: PayloadFit) -> Array:
    """(9 + 10 K, 9 + 10 K) of noise, and of all that is known to err in common."""
    return fit.solution.covariance if fit.whole is None else fit.whole


def _beyond(C: Array, prior_std: Array) -> Array:
    """Information of the data alone where C (n, n) is the covariance with it; never negative."""
    D = prior_std
    unit = C / np.outer(D, D)
    scale = 1 / np.sqrt(np.diag(unit))
    inverse = np.linalg.inv(unit * np.outer(scale, scale)) * np.outer(scale, scale)
    values, vectors = np.linalg.eigh((inverse + inverse.T) / 2 - np.eye(len(D)))
    data = (vectors * np.maximum(values, 0.0)) @ vectors.T / np.outer(D, D)
    return np.asarray((data + data.T) / 2)
