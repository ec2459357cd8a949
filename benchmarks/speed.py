"""Speed of what runs most, as ratios measured in one run.

    python benchmarks/speed.py [--json]

batch_kinematics   tip poses of a 7-joint arm in 10,000 postures, against a loop over Pinocchio's
                   forward kinematics from Python (which has no batches)
recursive_update   one step of the recursive learner on a pose of that arm, with all offsets, axes,
                   links and both end frames free (54 parameters)
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pinocchio

import bodyschema as bs
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.learners.learner import run
from bodyschema.model.kinematics import relative_pose

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
    rng = np.random.default_rng(0)
    # With limits: Pinocchio holds a joint without them as cosine and sine.
    body = replace(bs.Body.random_chain(7, rng), lower=np.full(7, -3.0), upper=np.full(7, 3.0))
    q = rng.uniform(-2, 2, size=(10_000, 7))
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
    parser = argparse.ArgumentParser(
        description="Speed of kinematics and of the recursive learner."
    )
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    options = parser.parse_args()
    figures = {"batch_kinematics": batch_kinematics(), "recursive_update": recursive_update()}
    print(json.dumps(figures) if options.json else json.dumps(figures, indent=2))


if __name__ == "__main__":
    main()
