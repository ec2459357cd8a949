"""Held-out torque residual of the Staubli TX40 recording: base parameters, and real links.

    python benchmarks/arm_torques.py FOLDER

Positions and currents are low-passed at 20 Hz without delay, differentiated, and thinned to 100 a
second; the first 70 % of the time is fitted, the last 30 % is held out. Percent are of the norm of
the held-out torque, low-passed alike; `raw` is of the torque as recorded.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, filtfilt

from bodyschema.learners.payload.arm import fit_arm
from bodyschema.model.motion import Motion
from bodyschema.model.tree import Body
from bodyschema.senses.joint_torques import (
    arm_regressor,
    base_directions,
    motor_regressor,
    moved_links,
)

Array = NDArray[np.float64]

RATE, CUT, THIN, FITTED = 5000.0, 20.0, 50, 0.7


def recording(folder: Path) -> tuple[Motion, Array, Array]:
    """Motion, low-passed and raw torque of the joints, 100 a second."""
    data = np.load(folder / "data.npz")
    ratio = np.array([32, 32, 45, -48, 45, 32.0])
    R, R_t = np.diag(ratio), np.diag(ratio)
    R[5, 4] = R_t[4, 5] = ratio[5]
    zero = np.array([0, -np.pi / 2, np.pi / 2, 0, 0, 0])
    q = data["motor_pos_rad"].astype(float) @ np.linalg.inv(R).T + zero
    tau = data["cur"].astype(float) @ R_t.T
    b, a = butter(5, CUT / (RATE / 2))
    smooth = filtfilt(b, a, q, axis=0)
    dq = np.gradient(smooth, 1 / RATE, axis=0)
    ddq = np.gradient(dq, 1 / RATE, axis=0)
    rows = slice(250, -250, THIN)
    motion = Motion(smooth[rows], dq[rows], ddq[rows])
    return motion, filtfilt(b, a, tau, axis=0)[rows], tau[rows]


def torque_percent(folder: Path) -> dict[str, float]:
    """Residuals of a plain and of a physically consistent fit."""
    body = Body.from_urdf(folder / "tx40_nomesh.urdf")
    motion, tau, raw = recording(folder)
    G = np.eye(6)
    G[5, 4] = 1.0  # the last motor turns with the wrist's last two joints
    W = np.concatenate([arm_regressor(body, motion), motor_regressor(motion, G)], axis=2)
    fitted = round(FITTED * len(tau))
    A = W[:fitted].reshape(-1, W.shape[2])
    length = np.linalg.norm(A, axis=0)
    length[length == 0] = 1.0
    directions, _ = base_directions(A)
    base, *_ = np.linalg.lstsq(A / length @ directions, tau[:fitted].ravel(), rcond=None)
    plain = directions @ base / length
    arm = fit_arm(W[:fitted], tau[:fitted], len(moved_links(body)))
    answer = {"base_parameters": float(directions.shape[1])}
    for name, x in (("base", plain), ("physical", arm.x)):
        for kind, truth in (("", tau), ("_raw", raw)):
            left = truth[fitted:] - W[fitted:] @ x
            answer[name + kind] = float(100 * np.linalg.norm(left) / np.linalg.norm(truth[fitted:]))
    return answer


if __name__ == "__main__":
    print(torque_percent(Path(sys.argv[1])))
