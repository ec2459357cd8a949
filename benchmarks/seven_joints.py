"""A seven-joint arm that sees a board on its hand, touches its own base, and feels gravity."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import lie
from bodyschema.model import parts
from bodyschema.model.camera import Camera
from bodyschema.model.kernels import FIXED, REVOLUTE
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.lens import UNSEEN
from bodyschema.model.variables import Variables, free_frame, free_joints, free_part, join
from bodyschema.senses.gravity import Gravity
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.sense import Sense
from bodyschema.senses.touches import Touches

Array = NDArray[np.float64]

RISES = (0.15, 0.19, 0.21, 0.19, 0.21, 0.19, 0.08)
"""m from each joint to the next, straight up at rest."""

AXES = ("z", "y", "z", "y", "z", "y", "z")

BOARD = np.array([[x, y, 0.0] for x in np.arange(5) - 2.0 for y in np.arange(4) - 1.5]) * 0.03
"""m, corners in the board's frame."""

LENS = Camera.from_fov("camera", "camera", 1280, 960, 0.8)

PICTURES, TOUCHES, RESTS = 15, 15, 20


def believed() -> tuple[bs.Body, Variables]:
    """The arm as drawn, and what may be wrong with it; the joints' zeros come first."""
    joints = [f"j{k}" for k in range(1, 8)]
    body = bs.Body.build(
        "arm7",
        ["base", *(f"link_{k}" for k in range(1, 8))],
        ["", *joints],
        range(-1, 7),
        [FIXED, *[REVOLUTE] * 7],
        [[0.0, 0, 1], *(np.eye(3)["xyz".index(axis)] for axis in AXES)],
        lie.transform(np.tile(np.eye(3), (8, 1, 1)), [[0, 0, z] for z in (0.0, *RISES)]),
        limits=dict.fromkeys(joints, (-1.8, 1.8)),
    )
    look = lie.exp_so3([-np.pi / 2, 0, 0])  # along the base's y axis
    body = body.attach("camera", "base", lie.transform(look, [0.2, -1.6, 0.6]))
    body = body.attach("board", "link_7", lie.transform(lie.exp_so3([1.6, 0, 0]), [0, -0.05, 0.05]))
    body = body.attach("finger", "link_7", lie.transform(np.eye(3), [0.0, 0.0, 0.12]))
    body = body.attach("imu", "link_7", lie.transform(lie.exp_so3([0, 0.4, 0]), [0.03, 0, 0.02]))
    made = {
        "lens": parts.lens(LENS), "size": parts.target(), "accelerometer": parts.accelerometer()
    }  # fmt: skip
    for name, part in made.items():
        body = body.with_part(name, part)
    return body, join(
        free_joints(body, ["offsets"]),
        free_frame(body, "camera", 0.05, 0.1),
        free_frame(body, "board", 0.03, 0.2),
        free_frame(body, "finger", 0.003, None),
        free_part(body, "lens", ("fx", "fy", "cx", "cy")),
        free_part(body, "size"),
        free_part(body, "accelerometer", ("offset_ax", "offset_ay", "offset_az")),
    )


def drawn(body: bs.Body, free: Variables, seed: int) -> tuple[Array, dict[str, Sense]]:
    """Deviations of an arm, (n_parameters,), and what it sees, touches and feels."""
    rng = np.random.default_rng([8, seed])
    share = np.where(np.arange(len(free)) < 7, 1.0, 0.5)
    x = share * free.prior_std * rng.normal(size=len(free))
    real = body.with_variables(free, x)
    q = rng.uniform(body.lower, body.upper, (40000, 7))
    finger = relative_pose(real, q, "base", "finger")[:, :3, 3]
    near = (np.hypot(finger[:, 0], finger[:, 1]) < 0.35) & (np.abs(finger[:, 2] - 0.1) < 0.1)
    touch = q[near][:TOUCHES]
    touches = Touches.make(touch, np.zeros((len(touch), 3)), np.zeros(3), "base", "finger", 2e-3)
    gravity = Gravity.make(
        q[-RESTS:], np.tile([0.0, 0.0, 9.81], (RESTS, 1)), "imu", "base", "accelerometer", 0.03
    )
    senses = {"pixels": _pictures(real, q), "touches": touches, "gravity": gravity}
    return x, {name: _seen(sense, real, rng) for name, sense in senses.items()}


def _pictures(real: bs.Body, q: Array) -> Pixels:
    """Corners of the board in the postures that show all of it from the front."""
    each = np.repeat(np.arange(400), len(BOARD))
    corners = np.tile(BOARD, (400, 1))
    blank = np.zeros((len(each), 2))
    tried = Pixels.make(q[each], blank, "camera", "board", "lens", corners, "size", 0.3)
    image = tried.predict(real).reshape(400, -1, 2)
    inside = (image > 10) & (image < [LENS.width - 10, LENS.height - 10]) & (image != UNSEEN)
    facing = relative_pose(real, q[:400], "camera", "board")[:, 2, 2] < -0.3
    good = np.flatnonzero(inside.all(axis=(1, 2)) & facing)[:PICTURES]
    kept = tried.take(np.isin(each, good))
    number = np.repeat(np.arange(len(good)), len(BOARD))
    return replace(kept, rows=number, time=number.astype(float))


def _seen(sense: Sense, real: bs.Body, rng: np.random.Generator) -> Sense:
    """The samples as a real body shows them, with noise."""
    shown = sense.predict(real)
    return replace(
        sense, observed=shown + np.sqrt(np.diag(sense.covariance)) * rng.normal(size=shown.shape)
    )
