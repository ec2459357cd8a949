"""Cost of one online step, and how it grows with the number of joints.

    python benchmarks/online_step.py [--json]

For random chains of 1, 3, 5 and 7 joints, and for the humanoid of 24 joints (one hand or foot a
step, in turn), in microseconds of processor time, the least of several rounds:

    gradient          compiled, samples one after the other in one call
    gradient_step     `OnlineGradient.step`, one Python call a sample
    gauss_newton      `Filter.step`, with all axes, links and the tip free

`path` is the mean number of nodes between eye and point, `variables` the numbers that the
recursive learner keeps. `gradient_us_per_node` is the slope over the four chains.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable

import numpy as np

import bodyschema as bs
from bodyschema.learners.learner import run
from bodyschema.learners.published.online_gradient import OnlineGradient
from bodyschema.learners.skeletons.samples import SkeletonSamples
from bodyschema.model.kernels import FIXED
from bodyschema.model.kinematics import path_between, relative_pose
from bodyschema.simulation.humanoid import ENDS, EYE, humanoid

REPEATS, SAMPLES = 15, 2000


def least(work: Callable[[], object], count: int) -> float:
    """Microseconds a sample; on a busy machine the least disturbed round is the truth."""
    work()
    times = []
    for _ in range(REPEATS):
        begin = time.process_time()
        work()
        times.append(time.process_time() - begin)
    return 1e6 * min(times) / count


def skeleton_parameters(body: bs.Body) -> bs.Variables:
    """Every axis and every link."""
    ends = [f for f, kind in zip(body.frames[1:], body.kind[1:], strict=True) if kind == FIXED]
    frames = [bs.free_frame(body, frame, turn_std=None) for frame in ends]
    return bs.join(bs.free_joints(body, ("axes", "links")), *frames)


def looked_at(body: bs.Body, eye: str, points: tuple[str, ...]) -> list[bs.Points]:
    """Noisy positions, each point in its share of the moments."""
    rng = np.random.default_rng(1)
    senses = []
    for i, point in enumerate(points):
        q = rng.uniform(-1.2, 1.2, (SAMPLES, len(body.joints)))
        seen = relative_pose(body, q, eye, point)[:, :3, 3] + 1e-3 * rng.normal(size=(SAMPLES, 3))
        moments = len(points) * np.arange(SAMPLES) + i
        senses.append(bs.Points.make(q, seen, eye, point, time=moments.astype(float)))
    return senses


def costs(body: bs.Body, eye: str, points: tuple[str, ...]) -> dict[str, float]:
    """Microseconds a sample, and the sizes that they depend on."""
    senses, variables = looked_at(body, eye, points), skeleton_parameters(body)
    gradient = OnlineGradient(0.01)
    start = gradient.start(body, variables)
    seen = [SkeletonSamples.of(sense, body, start.R0) for sense in senses]
    compiled = least(lambda: [gradient.descend(start, one) for one in seen], SAMPLES * len(seen))

    def stepping(learner, state):
        few = [sense.take(range(20)) for sense in senses]
        return least(lambda: [None for _ in run(learner, state, few)], 20 * len(few))

    recursive = bs.Filter()
    # A noise level and a first fit are there before the filter runs.
    begun = [sense.take(range(50)) for sense in senses]
    *_, (belief, _) = run(recursive, recursive.start(body, variables), begun)
    return {
        "path": float(np.mean([len(path_between(body, eye, point)[0]) for point in points])),
        "parameters": len(variables),
        "gradient_us": compiled,
        "gradient_step_us": stepping(gradient, start),
        "gauss_newton_us": stepping(recursive, belief),
    }


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description="Cost of one online step.")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    options = parser.parse_args()
    rng = np.random.default_rng(0)
    found = {str(n): costs(bs.Body.random_chain(n, rng), "base", ("tip",)) for n in (1, 3, 5, 7)}
    found["24"] = costs(humanoid(), EYE, ENDS)
    chains = [found[n] for n in "1357"]
    slope = np.polyfit([one["path"] for one in chains], [one["gradient_us"] for one in chains], 1)
    answer = {"joints": found, "gradient_us_per_node": float(slope[0])}
    print(json.dumps(answer) if options.json else json.dumps(answer, indent=2))


if __name__ == "__main__":
    main()
