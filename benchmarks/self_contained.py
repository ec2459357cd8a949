"""A two-armed robot calibrates itself, and a tracker that the fit never saw says how well.

    python benchmarks/self_contained.py [--seeds 5] [--size 1.0] [--errors 1.0] [--json]

Baxter, with wrong joint zeros (1.7 degrees), axes (0.3 degrees) and links (2 mm) in both arms and
the neck, or a share of that. Where its frames really are comes from Pinocchio, out of a URDF of the
true robot.

touches     each fingertip on the skin of the other forearm, 2 mm
distances   a ball on either hand, in contact with the other, 0.5 mm; where they sit nobody measured
planes      the same balls on a table that nobody measured, 0.5 mm
pixels      a board on either hand before the camera on the head, 0.3 px; camera and boards are
            where nobody measured, the lens is known to a per cent
gravity     accelerometers in the hands, of known mounting, 0.03 m/s^2, with offsets

For each sense alone, all four, and all with gravity: `after_mm` the rms error of both hands at
fresh postures, up to the tracker's own mounting; `nominal_mm` that of the robot as modelled;
`stated_mm` what the covariance says of it; `told` in how many of the trials the fit settled and its
correction is at least twice as large as what it states to be left: otherwise the answer is that
these data cannot tell. `worse` and `worse_though_told`: trials that end farther off than the robot
as modelled. `open` is the number of directions that the data leave as they were believed.
"""

from __future__ import annotations

import argparse
import json
import sysconfig
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import bodyschema as bs  # sets one BLAS thread a process, so it must come before numpy

# isort: split
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.identifiability import identifiability
from bodyschema.estimation.problem import Problem
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.model import parts
from bodyschema.model.kinematics import relative_pose, relative_pose_derivatives
from bodyschema.seeds.closed_forms import align_points
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

FRAMES = {
    "touches": (),
    "distances": ("left_ball", "right_ball"),
    "planes": ("table", "left_ball", "right_ball"),
    "pixels": ("eye", "left_board", "right_board"),
    "gravity": (),
}
"""Frames that nobody measured, by sense."""

PARTS = {"pixels": ("lens",), "gravity": ("left_feel", "right_feel")}
FOUR = ("touches", "distances", "planes", "pixels")
SETS = {**{name: (name,) for name in NOISE}, "four": FOUR, "all": (*FOUR, "gravity")}


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


@dataclass(frozen=True)
class Tracker:
    """Both hands at fresh postures, as a tracker of unknown mounting would have them."""

    q: Array
    hands: Array
    """(2 n, 3) m, true, in the robot's base."""

    @classmethod
    def watching(cls, robot: Robot, n: int, rng: np.random.Generator) -> Tracker:
        """At n random postures, by Pinocchio."""
        q = postures(robot.truth, n, rng)
        seen = [robot.poses(q, "base", f"{side}_gripper")[:, :3, 3] for side in SIDES]
        return cls(q, np.concatenate(seen))

    def hands_of(self, body: bs.Body) -> Array:
        """(2 n, 3) m, as a body has them."""
        return np.concatenate(
            [relative_pose(body, self.q, "base", f"{side}_gripper")[:, :3, 3] for side in SIDES]
        )

    def error(self, body: bs.Body, true: Array | None = None) -> float:
        """rms distance from the true hands, or from others, after the best mounting, m."""
        theirs, mine = self.hands if true is None else true, self.hands_of(body)
        T = align_points(mine, theirs, np.ones(len(mine)))
        left = mine @ T[:3, :3].T + T[:3, 3] - theirs
        return float(np.sqrt(np.mean(np.sum(left**2, axis=1))))

    def stated(self, fit: Estimate) -> float:
        """rms error of the hands that an estimate admits to, after the best mounting, m."""
        J = np.concatenate(
            [
                relative_pose_derivatives(
                    fit.reference, fit.variables, fit.x, self.q, "base", f"{side}_gripper"
                ).by_parameter[:, :3]
                for side in SIDES
            ]
        )
        moves = np.concatenate([np.tile(np.eye(3), (len(J), 1, 1)), lie.skew(self.hands)], axis=2)
        basis = np.linalg.qr(moves.reshape(-1, 6))[0]
        flat = J.reshape(-1, J.shape[2])
        flat = flat - basis @ (basis.T @ flat)
        return float(np.sqrt(np.einsum("ij,jk,ik->", flat, fit.covariance, flat) / len(J)))


def fit_set(robot: Robot, seen: dict[str, list[Sense]], names: Sequence[str]) -> Estimate:
    """The product's own fit of some of the senses, from frames that nobody measured."""
    senses = [sense for name in names for sense in seen[name]]
    frames = dict.fromkeys((f for name in names for f in FRAMES[name]), "no")
    free = dict.fromkeys(part for name in names for part in PARTS.get(name, ()))
    problem = Problem(robot.nominal, tuple(senses), frames, arms(robot.nominal), parts=free)
    return problem.fit(problem.variables(GROUPS), senses)


def trial(
    seed: int, size: float = 1.0, errors: float = 1.0, sets: Sequence[str] = tuple(SETS)
) -> dict[str, dict[str, Any]]:
    """One robot, each set of senses.

    Args:
        seed: of the robot and of all noise.
        size: share of the usual number of samples.
        errors: share of the usual errors of the joints.
        sets: names in SETS.
    """
    rng = np.random.default_rng(seed)
    robot = draw_robot(rng, errors)
    used = {name for chosen in sets for name in SETS[chosen]}
    seen = {
        name: make(robot, int(size * COUNT[name]), rng)
        for name, make in SENSES.items()
        if name in used
    }
    tracker = Tracker.watching(robot, 100, rng)
    nominal, found = tracker.error(robot.nominal), {}
    for chosen in sets:
        begin = time.process_time()
        fit = fit_set(robot, seen, SETS[chosen])
        seconds = time.process_time() - begin
        stated = tracker.stated(fit)
        correction = tracker.error(fit.body, tracker.hands_of(robot.nominal))
        senses = [sense for name in SETS[chosen] for sense in seen[name]]
        found[chosen] = {
            "nominal_mm": 1e3 * nominal,
            "after_mm": 1e3 * tracker.error(fit.body),
            "stated_mm": 1e3 * stated,
            "correction_mm": 1e3 * correction,
            "tells": bool(fit.converged and correction > 2 * stated),
            "settled": bool(fit.converged),
            "open": len(identifiability(fit, senses).directions),
            "variables": len(fit.variables),
            "cpu_s": seconds,
        }
    return found


def measure(seeds: int, size: float, errors: float) -> dict[str, Any]:
    """All figures: medians over the seeds, and how often a set tells and ends worse."""
    trials = [trial(seed, size, errors) for seed in range(seeds)]
    figures: dict[str, Any] = {}
    for name in SETS:
        rows = [found[name] for found in trials]
        told = [row for row in rows if row["tells"]]
        figures[name] = {
            key: float(np.median([row[key] for row in rows]))
            for key in ("nominal_mm", "after_mm", "stated_mm", "open", "variables", "cpu_s")
        }
        figures[name] |= {
            "told": len(told),
            "settled": sum(row["settled"] for row in rows),
            "worse": sum(row["after_mm"] > row["nominal_mm"] for row in rows),
            "worse_though_told": sum(row["after_mm"] > row["nominal_mm"] for row in told),
            "over_stated": float(
                np.mean([(row["after_mm"] / row["stated_mm"]) ** 2 for row in rows])
            ),
        }
    return {"seeds": seeds, "size": size, "errors": errors, "sets": figures, "trials": trials}


def show(figures: dict[str, Any]) -> None:
    """A table for people."""
    n = figures["seeds"]
    print(
        "senses      nominal   after  stated mm  told worse worse_though_told open (after/stated)^2"
    )
    for name, row in figures["sets"].items():
        lengths = " ".join(f"{row[key]:7.2f}" for key in ("nominal_mm", "after_mm", "stated_mm"))
        counts = f"{row['told']:2}/{n:<2} {row['worse']:5} {row['worse_though_told']:16}"
        print(f"{name:10} {lengths}   {counts} {row['open']:6.0f} {row['over_stated']:8.2f}")


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description="Two arms calibrate themselves.")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--size", type=float, default=1.0, help="share of the usual samples")
    parser.add_argument("--errors", type=float, default=1.0, help="share of the usual errors")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    options = parser.parse_args()
    figures = measure(options.seeds, options.size, options.errors)
    if options.json:
        print(json.dumps(figures))
    else:
        show(figures)


if __name__ == "__main__":
    main()
