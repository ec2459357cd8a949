"""By how many pixels each joint moves what a camera sees of a robot: MuJoCo's Jacobian, projected.

A point p = z (x, y, 1) in the optical frame, moved by dp, moves in the image by

    (du, dv) = f / z ((dp_x, dp_y) - (x, y) dp_z).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


def pixel_speeds(
    mujoco: Any, model: Any, data: Any, camera: str, joints: Sequence[str],
    body: NDArray[np.int32], depth: Array,
) -> Array:  # fmt: skip
    """Pixels/rad by which each joint moves what is seen in each pixel.

    Args:
        mujoco: the module.
        model: compiled model.
        data: its state, placed.
        camera: name.
        joints: names, (J,).
        body: (height, width) number of the body seen in each pixel, -1 where none counts.
        depth: (height, width) m along the optical axis.

    Returns:
        (J, height, width), 0 where no body counts.
    """
    height, width = depth.shape
    eye = data.camera(camera)
    R = eye.xmat.reshape(3, 3) @ np.diag([1.0, -1.0, -1.0])  # optical frame: x right, y down
    f = height / 2 / np.tan(np.deg2rad(model.camera(camera).fovy[0]) / 2)
    speed, jacobian = np.zeros((len(joints), height, width)), np.zeros((3, model.nv))
    columns = [model.joint(name).dofadr[0] for name in joints]
    for v, u in zip(*np.nonzero(body >= 0), strict=True):
        ray = np.array([(u + 0.5 - width / 2) / f, (v + 0.5 - height / 2) / f, 1.0])
        point = eye.xpos + R @ (depth[v, u] * ray)
        mujoco.mj_jac(model, data, jacobian, None, point, body[v, u])
        moved = R.T @ jacobian[:, columns]
        speed[:, v, u] = f / depth[v, u] * np.hypot(*(moved[:2] - ray[:2, None] * moved[2]))
    return speed
