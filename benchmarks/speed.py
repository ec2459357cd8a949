"""Speed of what runs most, as ratios measured in one run.

    python benchmarks/speed.py [--json]

batch_kinematics   tip poses of a 7-joint arm in 10,000 postures, against a loop over Pinocchio's
                   forward kinematics from Python (which has no batches)
derivatives        those poses with their derivatives by 7 joints and 42 parameters, against a loop
                   over Pinocchio's frame Jacobian and kinematic regressor
one_posture        pose and Jacobian of a single posture, from Python
start              tracker and marker placed from nothing by 3,000 points or poses, 45 % wrong
field              the residual field of 400 points
clock              the test for late rows of 10,000
recursive_update   one step of the recursive learner on a pose of that arm, with all offsets, axes,
                   links and both end frames free (54 parameters)
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pinocchio

import bodyschema as bs
from bodyschema import lie
from bodyschema.estimation.clock import chance
from bodyschema.estimation.discrepancy import most_likely
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.learners.learner import run
from bodyschema.model.kinematics import frame_jacobian, relative_pose, relative_pose_derivatives
from bodyschema.seeds.starts import start_frames

REPEATS = 7


def fastest(work: Callable[[], object]) -> float:
    """Shortest of several processor times in s; a busy machine disturbs it least."""
    work()
    times = []
    for _ in range(REPEATS):
        begin = time.process_time()
        work()
        times.append(time.process_time() - begin)
    return min(times)


def batch_kinematics() -> dict[str, float]:
    """Ours against a Pinocchio loop; both return the same poses."""
    body, q = arm(10_000)
    model = pinocchio.buildModelFromXML(write_urdf(body).decode())
    data, tip = model.createData(), model.getFrameId("tip")

    def peer() -> np.ndarray:
        poses = np.empty((len(q), 4, 4))
        for i, posture in enumerate(q):
            pinocchio.forwardKinematics(model, data, posture)
            poses[i] = pinocchio.updateFramePlacement(model, data, tip).homogeneous
        return poses

    def ours() -> np.ndarray:
        return relative_pose(body, q, "base", "tip")

    if not np.allclose(peer(), ours(), atol=1e-9):
        raise SystemExit("the two disagree")
    times = fastest(ours), fastest(peer)
    return {"ours_ms": 1e3 * times[0], "pinocchio_ms": 1e3 * times[1], "ratio": times[1] / times[0]}


def derivatives() -> dict[str, float]:
    """Ours against Pinocchio, for one posture each, in microseconds."""
    body, q = arm(10_000)
    model = pinocchio.buildModelFromXML(write_urdf(body).decode())
    data, tip = model.createData(), model.getFrameId("tip")
    frame = pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
    variables = bs.free_joints(body, ("offsets", "axes", "links"))
    x = np.zeros(len(variables))

    def peer() -> None:
        for posture in q:
            pinocchio.forwardKinematics(model, data, posture)
            pinocchio.computeJointJacobians(model, data, posture)
            pinocchio.getFrameJacobian(model, data, tip, frame)
            pinocchio.computeFrameKinematicRegressor(model, data, tip, frame)

    def ours() -> object:
        return relative_pose_derivatives(body, variables, x, q, "base", "tip")

    times = 1e6 * fastest(ours) / len(q), 1e6 * fastest(peer) / len(q)
    return {"us": times[0], "pinocchio_us": times[1], "parameters": len(variables)}


def one_posture() -> dict[str, float]:
    """What reaching and servoing call at every step."""
    body, q = arm(1000)

    def poses() -> None:
        for posture in q:
            relative_pose(body, posture, "base", "tip")

    def jacobians() -> None:
        for posture in q:
            frame_jacobian(body, posture, "base", "tip")

    return {"pose_us": 1e3 * fastest(poses), "jacobian_us": 1e3 * fastest(jacobians)}


def start() -> dict[str, float]:
    """Seconds to place both unknown frames."""
    rng = np.random.default_rng(0)
    body, q = arm(3000)
    blank = body.attach("tracker", "base").attach("marker", "tip")
    T = lie.transform(lie.exp_so3(rng.normal(size=3)), rng.normal(size=3))
    pose = relative_pose(blank.with_placement("tracker", T), q, "tracker", "marker")
    bad = rng.random(len(q)) < 0.45
    pose[bad, :3, 3] += 0.2 * rng.normal(size=(int(bad.sum()), 3))
    senses = {
        "points": bs.Points.make(q, pose[:, :3, 3], "tracker", "marker"),
        "poses": bs.Poses.make(q, pose, "tracker", "marker"),
    }
    unknown = ("tracker", "marker")
    return {
        f"{name}_ms": 1e3 * fastest(partial(start_frames, blank, unknown, [sense]))
        for name, sense in senses.items()
    }


def field() -> dict[str, float]:
    """Seconds of one fit by maximum marginal likelihood."""
    rng = np.random.default_rng(0)
    _, q = arm(400)
    part = np.sin(q[:, :3] + q[:, 1:4]) + rng.normal(size=(400, 3))
    return {"ms": 1e3 * fastest(lambda: most_likely(q, [part / np.sqrt(np.mean(part**2))]))}


def clock() -> dict[str, float]:
    """Seconds of the shuffles: of honest rows, and where a tenth is late."""
    rng = np.random.default_rng(0)
    motion = rng.normal(size=(10_000, 3))
    motion /= np.linalg.norm(motion, axis=1, keepdims=True)
    honest = rng.normal(size=(10_000, 3))
    late = honest + np.where(np.arange(10_000) % 10 == 0, 1.0, 0.0)[:, None] * motion
    return {
        name: 1e3 * fastest(partial(chance, residual, motion, np.random.default_rng(0)))
        for name, residual in (("honest_ms", honest), ("late_ms", late))
    }


def arm(postures: int) -> tuple[bs.Body, np.ndarray]:
    """Seven joints with limits: Pinocchio holds a joint without them as cosine and sine."""
    rng = np.random.default_rng(0)
    body = replace(bs.Body.random_chain(7, rng), lower=np.full(7, -3.0), upper=np.full(7, 3.0))
    return body, rng.uniform(-2, 2, size=(postures, 7))


def recursive_update() -> dict[str, float]:
    """Time of one step, once the filter runs."""
    rng = np.random.default_rng(0)
    body = bs.Body.random_chain(7, rng).attach("tracker", "base").attach("hand", "tip")
    q = rng.uniform(-1.5, 1.5, size=(200, 7))
    pose = relative_pose(body, q, "tracker", "hand")
    pose[:, :3, 3] += 1e-3 * rng.normal(size=(200, 3))
    seen = bs.Poses.make(q, pose, "tracker", "hand")
    frames = [bs.free_frame(body, frame) for frame in ("tracker", "hand")]
    variables = bs.join(bs.free_joints(body, ("offsets", "axes", "links")), *frames)
    learner = bs.Filter(unknown=("tracker", "hand"))
    *_, (state, _) = run(learner, learner.start(body, variables), [seen.take(range(100))])
    samples = [seen.take([i]) for i in range(100, 200)]

    def steps() -> None:
        belief = state
        for sample in samples:
            belief, _ = learner.step(belief, (sample,))

    return {"us": 1e6 * fastest(steps) / len(samples), "parameters": len(variables)}


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description="Speed of what runs most.")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    options = parser.parse_args()
    parts = (
        batch_kinematics, derivatives, one_posture, start, field, clock, recursive_update,
    )  # fmt: skip
    figures = {part.__name__: part() for part in parts}
    print(json.dumps(figures) if options.json else json.dumps(figures, indent=2))


if __name__ == "__main__":
    main()
