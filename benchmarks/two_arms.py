"""Baxter with a wrong body, and what it would see and feel of itself, for `self_contained`.

The true frames come from Pinocchio, out of a URDF of the true robot; postures that bring two points
together are found by Newton steps, and Pinocchio confirms each.
"""

from __future__ import annotations

import sysconfig
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import bodyschema as bs  # sets one BLAS thread a process, so it must come before numpy

# isort: split
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model import parts
from bodyschema.senses.carried import carried
from bodyschema.senses.distances import Distances
from bodyschema.senses.gravity import G, Gravity
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.planes import Planes
from bodyschema.senses.sense import Sense
from bodyschema.senses.touches import Touches

Array = NDArray[np.float64]

BAXTER = Path(
    sysconfig.get_path("purelib"),
    "cmeel.prefix/share/example-robot-data/robots/baxter_description/urdf/baxter.urdf",
)
WRONG = {"offsets": 0.03, "axes": 0.005, "links": 0.002}
"""rad, rad, m: standard deviations of what is wrong with the robot."""

GROUPS = tuple(WRONG)
SIDES = ("left", "right")
SKIN, FINGER = 0.06, np.array([0.0, 0.0, 0.06])
"""m: radius of a forearm, and the fingertip in the gripper's frame."""

BALL = 0.04
"""m, radius."""

GRID = 0.03 * np.stack([*np.mgrid[-1:2, -1:2], np.zeros((3, 3))], axis=-1).reshape(-1, 3)
"""(9, 3) m, corners of a board."""

LENS = bs.Camera("eye", "eye", 640, 480, np.array([[520.0, 0, 320], [0, 520, 240], [0, 0, 1]]))
NOISE = {"touches": 2e-3, "distances": 5e-4, "planes": 5e-4, "pixels": 0.3, "gravity": 0.03}
COUNT = {"touches": 100, "distances": 150, "planes": 75, "pixels": 40, "gravity": 60}
"""Samples, for each hand where there are two; pictures for pixels."""

FORWARD = lie.exp_so3([0.0, 0.6, 0.0]) @ np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0.0]])
SIDEWAYS = lie.exp_so3([0.0, np.pi / 2, 0.0])
PLACES = {
    "table": ("base", np.eye(3), [0.0, 0.0, -0.15]),
    "eye": ("head", FORWARD, [0.15, 0.0, 0.1]),
    "left_ball": ("left_gripper", np.eye(3), [0.0, 0.0, 0.05]),
    "right_ball": ("right_gripper", np.eye(3), [0.0, 0.0, 0.05]),
    "left_board": ("left_gripper", SIDEWAYS, [0.06, 0.0, -0.03]),
    "right_board": ("right_gripper", SIDEWAYS, [0.06, 0.0, -0.03]),
}
"""Frame -> parent, rotation and place (m), from which it is off by 0.15 rad and 20 mm."""

PART_ERRORS = 0.2
"""Of the priors: how wrong the lens and the accelerometers are."""


@dataclass(frozen=True)
class Robot:
    """What is believed of a robot, and what is true."""

    nominal: bs.Body
    """With every frame that is known; the others at their parents' origins."""
    truth: bs.Body
    model: Any
    """Pinocchio's, read from the true robot's URDF."""

    def poses(self, q: Array, a: str, b: str) -> Array:
        """(n, 4, 4) true T_a_b by Pinocchio."""
        data, found = self.model.createData(), np.empty((len(q), 4, 4))
        ids = [self.model.getFrameId(frame, pin.FrameType.BODY) for frame in (a, b)]
        columns = [self.model.joints[self.model.getJointId(j)].idx_q for j in self.truth.joints]
        full = np.zeros(self.model.nq)
        for i, readings in enumerate(q):
            full[columns] = readings
            pin.framesForwardKinematics(self.model, data, full)
            T_a, T_b = (data.oMf[k] for k in ids)
            found[i] = T_a.actInv(T_b).homogeneous
        return found


def draw_robot(rng: np.random.Generator, errors: float = 1.0) -> Robot:
    """Baxter with a share of the usual errors; table, eye, balls and boards somewhere."""
    body = bs.Body.from_urdf(BAXTER).with_part("lens", parts.lens(LENS))
    for side in SIDES:
        body = body.with_part(f"{side}_feel", parts.accelerometer())
        body = body.attach(f"{side}_imu", f"{side}_hand_link")
    truth = body
    for frame, (parent, R, t) in PLACES.items():
        turned, shifted = R @ lie.exp_so3(rng.normal(0, 0.15, 3)), t + rng.normal(0, 0.02, 3)
        truth = truth.attach(frame, parent, lie.transform(turned, shifted))
        body = body.attach(frame, parent)
    wrong = bs.free_joints(truth, GROUPS, arms(truth))
    x = errors * rng.normal(size=len(wrong)) * [WRONG[group] for group in wrong.groups]
    truth = truth.with_variables(wrong, x)
    for name, part in truth.parts.items():
        off = PART_ERRORS * part.prior_std * rng.normal(size=len(part.values))
        truth = truth.with_part(name, part.moved(np.arange(len(off)), off))
    return Robot(body, truth, pin.buildModelFromXML(write_urdf(truth).decode()))


def arms(body: bs.Body) -> tuple[str, ...]:
    """The joints of arms and neck: all but the fingers."""
    return tuple(joint for joint in body.joints if "finger" not in joint)


def postures(body: bs.Body, n: int, rng: np.random.Generator) -> Array:
    """(n, n_joints) uniform within the limits, fingers closed."""
    moving = np.isin(body.joints, arms(body))
    return np.where(moving, rng.uniform(body.lower, body.upper, (n, len(body.joints))), 0.0)


def reach(robot: Robot, a: str, b: str, v: Array, aim: Array, rng: np.random.Generator) -> Array:
    """Postures (m, n_joints) that bring the point v of b to aims (n, 3) in a, as many as are found.

    Newton steps of least length from random postures; Pinocchio confirms each.
    """
    body, none = robot.truth, bs.free_joints(robot.truth, ())
    q = postures(body, len(aim), rng)
    moving = np.isin(body.joints, arms(body))
    for _ in range(60):
        p = carried(body, none, np.empty(0), Touches.make(q, aim, v, a, b), np.tile(v, (len(q), 1)))
        J = p.by_joint * moving
        square = J @ np.swapaxes(J, 1, 2) + 1e-6 * np.eye(3)
        step = np.swapaxes(J, 1, 2) @ np.linalg.solve(square, (aim - p.position)[..., None])
        step = step[..., 0] / np.maximum(1, np.abs(step[..., 0]).max(axis=1, keepdims=True) / 0.3)
        q = np.clip(q + step, body.lower, body.upper)
    T = robot.poses(q, a, b)
    there = np.linalg.norm(T[:, :3, :3] @ v + T[:, :3, 3] - aim, axis=1) < 1e-6
    return q[there]


def touches(robot: Robot, n: int, rng: np.random.Generator) -> list[Sense]:
    """Each fingertip on the other forearm."""
    made: list[Sense] = []
    for arm, other in (SIDES, SIDES[::-1]):
        angle, along = rng.uniform(-np.pi, np.pi, 2 * n), rng.uniform(0.02, 0.22, 2 * n)
        aim = np.stack([SKIN * np.cos(angle), SKIN * np.sin(angle), along], axis=1)
        a, b = f"{arm}_upper_forearm", f"{other}_gripper"
        q = reach(robot, a, b, FINGER, aim, rng)[:n]
        T = robot.poses(q, a, b)
        felt = T[:, :3, :3] @ FINGER + T[:, :3, 3] + NOISE["touches"] * rng.normal(size=(len(q), 3))
        made.append(Touches.make(q, felt, FINGER, a, b, std=NOISE["touches"]))
    return made


def distances(robot: Robot, n: int, rng: np.random.Generator) -> list[Sense]:
    """The balls in contact, wherever on them."""
    way = rng.normal(size=(2 * n, 3))
    apart = 2 * BALL + NOISE["distances"] * rng.normal(size=(2 * n, 1))
    aim = apart * way / np.linalg.norm(way, axis=1, keepdims=True)
    q = reach(robot, "left_ball", "right_ball", np.zeros(3), aim, rng)[:n]
    return [Distances.make(q, 2 * BALL, "left_ball", "right_ball", std=NOISE["distances"])]


def planes(robot: Robot, n: int, rng: np.random.Generator) -> list[Sense]:
    """Either ball on the table."""
    made: list[Sense] = []
    for side in SIDES:
        low = np.array([0.3, -0.2 if side == "left" else -0.8, BALL])
        aim = rng.uniform(low, low + np.array([0.5, 1.0, 0.0]), (3 * n, 3))
        aim[:, 2] += NOISE["planes"] * rng.normal(size=3 * n)
        q = reach(robot, "table", f"{side}_ball", np.zeros(3), aim, rng)[:n]
        made.append(Planes.make(q, "table", f"{side}_ball", BALL, std=NOISE["planes"]))
    return made


def pixels(robot: Robot, n: int, rng: np.random.Generator) -> list[Sense]:
    """A board on either hand, where the camera sees its front."""
    made: list[Sense] = []
    f_x, f_y, c_x, c_y, *bent = robot.truth.parts["lens"].values
    K = np.array([[f_x, 0.0, c_x], [0.0, f_y, c_y], [0.0, 0.0, 1.0]])
    camera = replace(LENS, matrix=K, distortion=np.array(bent))
    for side in SIDES:
        board, depth = f"{side}_board", rng.uniform(0.45, 1.1, (12 * n, 1))
        aim = np.hstack([depth * rng.uniform([-0.4, -0.3], [0.4, 0.3], (12 * n, 2)), depth])
        q = reach(robot, "eye", board, np.zeros(3), aim, rng)
        T = robot.poses(q, "eye", board)
        sight = T[:, :3, 3] / np.linalg.norm(T[:, :3, 3], axis=1, keepdims=True)
        front = np.flatnonzero(np.einsum("ni,ni->n", T[:, :3, 2], -sight) > 0.5)[:n]
        p = np.einsum("nij,kj->nki", T[front, :3, :3], GRID) + T[front, None, :3, 3]
        image = camera.project(p) + NOISE["pixels"] * rng.normal(size=(*p.shape[:2], 2))
        rows = np.repeat(np.arange(len(front)), len(GRID))
        made.append(
            Pixels.make(
                q[front][rows],
                image.reshape(-1, 2),
                "eye",
                board,
                "lens",
                np.tile(GRID, (len(front), 1)),
                std=NOISE["pixels"],
                time=rows,
                rows=rows,
            )
        )
    return made


def gravity(robot: Robot, n: int, rng: np.random.Generator) -> list[Sense]:
    """An accelerometer in either hand; the robot stands level."""
    made: list[Sense] = []
    for side in SIDES:
        q, imu, feel = postures(robot.truth, n, rng), f"{side}_imu", f"{side}_feel"
        up = G * robot.poses(q, imu, "base")[:, :3, 2]
        offset, gain = np.split(robot.truth.parts[feel].values, 2)
        felt = (1 + gain) * up + offset + NOISE["gravity"] * rng.normal(size=(n, 3))
        made.append(Gravity.make(q, felt, imu, "base", feel, NOISE["gravity"]))
    return made


SENSES: dict[str, Callable[[Robot, int, np.random.Generator], list[Sense]]] = {
    "touches": touches,
    "distances": distances,
    "planes": planes,
    "pixels": pixels,
    "gravity": gravity,
}
