"""What planned poses buy over random ones, in the true (not the predicted) tool error.

    python benchmarks/planning.py [--json] [--seeds 20] [--data FOLDER]

icub, ur5, panda       simulated: 10 random poses, then 10 planned or 10 random ones. "offsets" sees
                       a point and corrects joint offsets; "full" sees poses and corrects offsets,
                       axes and links. rms over 200 unseen random postures, over all seeds; ratio is
                       planned / random; worth is the number of random poses that do as well as the
                       10 planned ones.
fr3                    recorded: 6 random poses, then 14 chosen of the other 108 or drawn at random;
                       rms of the flange on the poses that neither used, over the draws.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

import bodyschema as bs
from arms import ARMS
from bodyschema import lie
from bodyschema.acting.candidates import Candidates, find_candidates
from bodyschema.acting.next_poses import plan_poses
from bodyschema.estimation.estimate import Estimate
from bodyschema.estimation.problem import Problem
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.sense import Sense, concatenate
from recordings import DATA, FULL, fr3, link8_error

START, ADDED = 10, 10
MORE = (10, 14, 20, 28, 40)
"""Numbers of random poses among which the worth of the planned ones is sought."""
REPEATS = 2
"""Draws of noise and of random poses for each seed."""
STD = (1e-3, 5e-3)
"""m and rad."""
UNKNOWN = {"tracker": "no", "marker": "no"}


class Simulated:
    """A robot that is not as modelled, and a tracker that sees its tool."""

    def __init__(self, name: str, groups: Sequence[str], seed: int) -> None:
        self.rng = np.random.default_rng(seed)
        arm = next(arm for arm in ARMS if arm.name == name)
        self.body, self.joints, self.groups = arm.body, arm.joints, tuple(groups)
        far = lie.transform(lie.exp_so3(self.rng.normal(size=3)), self.rng.normal(size=3))
        near = lie.transform(
            lie.exp_so3(0.5 * self.rng.normal(size=3)), 0.1 * self.rng.normal(size=3)
        )
        placed = self.body.with_placement("tracker", far).with_placement("marker", near)
        wrong = bs.free_joints(placed, groups, self.joints)
        x = 0.5 * wrong.prior_std * self.rng.normal(size=len(wrong))
        self.truth = placed.with_variables(wrong, x)
        self.test = self.random_poses(200)

    def random_poses(self, n: int) -> np.ndarray:
        """Uniform over the limits of the arm's joints, (n, n_joints)."""
        q = np.zeros((n, len(self.body.joints)))
        for joint in self.joints:
            j = self.body.joint_index(joint)
            q[:, j] = self.rng.uniform(self.body.lower[j], self.body.upper[j], n)
        return q

    def observe(self, q: np.ndarray) -> Sense:
        """What the tracker sees: points for joint offsets, poses for more."""
        T = relative_pose(self.truth, q, "tracker", "marker")
        T[:, :3, 3] += STD[0] * self.rng.normal(size=(len(q), 3))
        if self.groups == ("offsets",):
            return bs.Points.make(q, T[:, :3, 3], "tracker", "marker")
        T[:, :3, :3] = lie.exp_so3(STD[1] * self.rng.normal(size=(len(q), 3))) @ T[:, :3, :3]
        return bs.Poses.make(q, T, "tracker", "marker", STD)

    def fit(self, sense: Sense) -> Estimate:
        """Calibrate from it."""
        problem = Problem(self.body, (sense,), UNKNOWN, self.joints)  # type: ignore[arg-type]
        return problem.fit(problem.variables(self.groups), [sense])

    def error(self, fit: Estimate) -> float:
        """True mean squared tool error in the test postures, mm^2."""
        found, true = (
            relative_pose(body, self.test, "tracker", "marker")[:, :3, 3]
            for body in (fit.body, self.truth)
        )
        return float(1e6 * np.mean(np.sum((found - true) ** 2, axis=1)))


def plan_ratio(name: str, seeds: int, groups: Sequence[str] = ("offsets",)) -> dict[str, float]:
    """True tool error after planned and after random poses, and what the planned are worth."""
    start, planned, seconds = [], [], []
    drawn: dict[int, list[float]] = {n: [] for n in MORE}
    for seed in range(seeds):
        world = Simulated(name, groups, seed)
        q = world.random_poses(START)
        seen = world.observe(q)
        fit = world.fit(seen)
        start.append(world.error(fit))
        begin = time.perf_counter()
        candidates = find_candidates(fit.body, [seen], 4000, world.rng, anywhere=True)
        plan = plan_poses(fit, [seen], ADDED, candidates=candidates)
        seconds.append(time.perf_counter() - begin)
        for _ in range(REPEATS):
            planned.append(world.error(world.fit(concatenate([seen, world.observe(plan.q)]))))
            more = world.observe(world.random_poses(MORE[-1]))
            for n in MORE:
                some = more.take(np.arange(n))
                drawn[n].append(world.error(world.fit(concatenate([seen, some]))))
    rms = {n: float(np.sqrt(np.mean(errors))) for n, errors in drawn.items()}
    after = float(np.sqrt(np.mean(planned)))
    return {
        "start_rms_mm": float(np.sqrt(np.mean(start))),
        "planned_rms_mm": after,
        "random_rms_mm": rms[ADDED],
        "ratio": after / rms[ADDED],
        "share_of_seeds_better": float(np.mean(np.array(planned) < np.array(drawn[ADDED]))),
        "worth_random_poses": _worth(rms, after),
        "seconds": float(np.mean(seconds)),
    }


def _worth(rms: dict[int, float], after: float) -> float:
    """Number of random poses with the same error, by interpolation of the logarithms."""
    errors = np.log([rms[n] for n in MORE])
    steady = np.minimum.accumulate(errors)
    return float(np.exp(np.interp(-np.log(after), -steady, np.log(MORE))))


def fr3_choice(data: Path, draws: int, begin: int = 6, total: int = 20) -> dict[str, float]:
    """Held-out flange error when the recorded poses to learn from are chosen or drawn."""
    body, q, pose = fr3(data)
    whole = bs.Poses.make(q, pose, "board", "camera")
    frames = {"board": "no", "camera": "no"}
    errors: dict[str, list[float]] = {"planned": [], "random": []}
    for seed in range(draws):
        order = np.random.default_rng(seed).permutation(len(q))
        first, rest = order[:begin], order[begin:]
        problem = Problem(body, (whole,), frames, body.joints)  # type: ignore[arg-type]
        variables = problem.variables(FULL)
        fit = problem.fit(variables, [whole.take(first)])
        seen = np.ones((len(rest), 1), dtype=bool)
        candidates = Candidates(q[rest], seen, q, body.joints)
        plan = plan_poses(fit, [whole.take(first)], total - begin, candidates=candidates, seed=seed)
        chosen = [int(rest[np.argmin(np.abs(q[rest] - p).sum(axis=1))]) for p in plan.q]
        sets = {"planned": chosen, "random": rest[: total - begin]}
        used = np.concatenate([first, *sets.values()])
        left = np.setdiff1d(np.arange(len(q)), used)
        for name, rows in sets.items():
            learned = problem.fit(variables, [whole.take(np.concatenate([first, rows]))])
            predicted = relative_pose(learned.body, q[left], "board", "camera")
            errors[name].append(float(np.mean(link8_error(predicted, pose[left]) ** 2)))
    rms = {name: float(np.sqrt(np.mean(values))) for name, values in errors.items()}
    better = np.mean(np.array(errors["planned"]) < np.array(errors["random"]))
    return {
        "planned_rms_mm": rms["planned"],
        "random_rms_mm": rms["random"],
        "ratio": rms["planned"] / rms["random"],
        "share_of_draws_better": float(better),
    }


def measure(seeds: int, data: Path) -> dict[str, Any]:
    """All figures."""
    figures: dict[str, Any] = {
        name: {"offsets": plan_ratio(name, seeds), "full": plan_ratio(name, seeds, FULL)}
        for name in ("icub", "ur5", "panda")
    }
    return {**figures, "fr3": fr3_choice(data, seeds)}


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description="Planned poses against random ones.")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the data sets")
    options = parser.parse_args()
    figures = measure(options.seeds, options.data)
    print(json.dumps(figures) if options.json else json.dumps(figures, indent=2))


if __name__ == "__main__":
    main()
