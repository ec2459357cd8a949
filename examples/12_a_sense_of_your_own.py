"""A sense of your own: a draw-wire in ten lines, which then goes through every verb.

A drum beside the robot pays out a wire to the hand and says how long it is; where its zero lies
nobody knows. No derivatives, no noise model and no report are written for it. A line for each verb:

python examples/12_a_sense_of_your_own.py
"""

from __future__ import annotations

import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import bodyschema as bs

NOISE = 3e-4  # m


@dataclass(frozen=True)
class Wire(bs.Sense):
    """Lengths (n,) of a wire between the frames `seen_from` and `seen`, as its drum reads them."""

    measures = (("length", "m", 1),)

    def predict(self, body: bs.Body) -> np.ndarray:
        """The distance of both frames, and the drum's zero."""
        T = bs.relative_pose(body, self.readings(body), self.seen_from, self.seen)
        return np.linalg.norm(T[:, :3, 3], axis=1) + body.part("drum")["zero"]


def measured(robot: bs.Body, postures: np.ndarray) -> Wire:
    """What the drum reads of a robot."""
    silent = Wire.make(postures, np.zeros(len(postures)), "floor", "hook", NOISE)
    length = silent.predict(robot) + NOISE * rng.normal(size=len(postures))
    return Wire.make(postures, length, "floor", "hook", NOISE)


def postures(n: int) -> np.ndarray:
    """Random ones (n, 5), rad."""
    return rng.uniform(-1.5, 1.5, (n, 5))


def placed(x: float, y: float, z: float) -> np.ndarray:
    """A transform without a turn, m."""
    T = np.eye(4)
    T[:3, 3] = x, y, z
    return T


rng = np.random.default_rng(7)
arm = bs.Body.random_chain(5, rng)
arm = arm.attach("floor", "base", placed(0.6, -0.5, -0.2))
arm = arm.attach("hook", "tip", placed(0.0, 0.08, 0.1))
drum = bs.Part("constants", ("zero",), ("m",), np.zeros(1), np.full(1, 0.05))
arm = arm.with_part("drum", drum)  # a start of 0 m, and a prior of 5 cm

doubted = ["joint_2", "joint_3", "joint_4"]
wrong = bs.join(bs.free_joints(arm, ["offsets"], doubted), bs.free_part(arm, "drum"))
robot = arm.with_variables(wrong, [*np.deg2rad([1.5, -2.0, 3.0]), 0.021])
knocked = robot.with_variables(bs.free_joints(robot, ["offsets"], ["joint_3"]), [np.deg2rad(1)])

seen = measured(robot, postures(80))
parts = {"drum": ["zero"]}
answer = bs.calibrate(arm, [seen], groups=["offsets"], joints=doubted, parts=parts)
offsets = np.rad2deg(answer.body.offset[1:4]).round(2)
zero = 1e3 * answer.body.part("drum")["zero"]
print(f"calibrate: {answer.verdict}, offsets {offsets} deg and zero {zero:.1f} mm")

with tempfile.TemporaryDirectory() as there:
    answer.save(Path(there) / "result")
    answer = bs.load(Path(there) / "result")  # as on another day
    page = (Path(there) / "result" / "report.html").read_text(encoding="utf-8")

alike, other = (answer.check([measured(body, postures(25))]) for body in (robot, knocked))
blamed = f"{other.changed}, blamed on {other.suspects[0].part}"
print(f"check: changed {alike.changed} where nothing was; {blamed} after a knock of 1 deg")
print(f"plan: {np.rad2deg(answer.plan(2, [seen]).q).round().astype(int).tolist()} deg tell most")
_, _, errors = answer.held_out.main
print(f"report: a page of {len(page) // 1000} kB; length to {1e3 * errors.rms:.2f} mm, held out")
