"""Fits of an arm whose camera saw a board, as answers to compare."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import Body, lie
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.prediction import predict_error
from bodyschema.estimation.problem import Problem
from bodyschema.judging.accuracy import Accuracy
from bodyschema.judging.calibration import Calibration
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.poses import Poses

Array = NDArray[np.float64]

ARM = Body.random_chain(4, np.random.default_rng(3))
NOISE = np.array([5e-4] * 3 + [1e-3] * 3)
BOARD = lie.transform(lie.exp_so3([0.1, 0.2, -0.3]), [0.5, 0.1, 0.2])
CAMERA = lie.transform(lie.exp_so3([0.0, 0.1, 0.2]), [0.02, 0.0, 0.05])


def result(
    seed: int,
    zeros: Any = (0.0, 0.02, -0.03, 0.02),
    board: Array = BOARD,
    groups: tuple[str, ...] = ("offsets",),
    described: Body = ARM,
) -> Calibration:
    """A fit of forty poses of a camera seen from a board, neither of which is known."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-1.5, 1.5, (40, 4))
    true = ARM.attach("board", "base", board).attach("camera", "tip", CAMERA)
    T = relative_pose(true, q + np.array(zeros), "board", "camera")
    e = NOISE * rng.normal(size=(40, 6))
    T[:, :3, 3] += e[:, :3]
    T[:, :3, :3] = T[:, :3, :3] @ lie.exp_so3(e[:, 3:])
    began = described.attach("board", "base", board).attach("camera", "tip", CAMERA)
    sense = Poses.make(q, T, "board", "camera")
    frames = {"board": "no", "camera": "no"}
    problem = Problem(began, (sense,), frames, ARM.joints)
    fit = problem.fit(problem.variables(groups), problem.senses)
    return answer(fit, predict_error(fit, q, "board", "camera"))


def answer(fit: Estimate, *predicted: Any) -> Calibration:
    nothing = Accuracy({}, {})
    unasked: Any = None
    return Calibration(
        "calibrated", "", fit, nothing, nothing, unasked, (), 40, predicted=predicted
    )
