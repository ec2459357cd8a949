"""Can the answers be believed? Coverage, change detection, null directions, planning.

    python benchmarks/trust.py [--json] [--seeds 20]

coverage    share of unseen postures in which the true tool-point error stays under the stated 95 %
            bound: simulated arms with unknown tracker and marker, wrong joint zeros, and 0, 5 and
            15 % outliers, from 10, 30 and 100 samples of poses; and of FR3's held-out samples
check       share of changed bodies that are detected, and blamed on the right part, at a
            false-alarm rate of 1 %; "none" is the share of false alarms
null_cases  built cases of what cannot be told: named, missed; invented over 100 well-excited ones
plan_ratio  tool error after 10 planned poses over that after 10 random ones
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

import arms
import bodyschema as bs
import null_cases
import planning
import recordings
from bodyschema.estimation.agreement import within_prediction
from bodyschema.estimation.discrepancy import learn_discrepancy
from bodyschema.estimation.prediction import degrees_of_freedom, predict_error
from bodyschema.estimation.problem import Problem
from bodyschema.monitoring.change import detect_change

OUTLIERS = (0.0, 0.05, 0.15)
SAMPLES = (10, 30, 100)
FAULTS = (("none", 0.0), ("offset_deg", 0.2), ("offset_deg", 0.5), ("offset_deg", 1.0),
          ("camera_mm", 2.0), ("camera_mm", 5.0))  # fmt: skip


def coverage(arm: arms.Arm, share: float, count: int, seeds: int) -> float:
    """Share of 100 unseen postures a seed in which the true error is within the stated bound."""
    inside = []
    for seed in range(seeds):
        rng = np.random.default_rng([seed, count])
        truth = arm.truth(rng)
        seen = arm.record(truth, count, share, rng)
        fit = arm.fit(seen)
        q = arm.postures(100, rng)
        said = predict_error(fit, q, "tracker", "marker", degrees_of_freedom(fit, [seen]))
        inside.append(arm.error(fit.body, truth, q) < said.position)
    return float(np.mean(inside))


def fr3_coverage(data: Path) -> float:
    """Share of FR3's held-out positions within their predicted 95 % bound, noise included."""
    body, q, pose = recordings.fr3(data)
    inside = []
    for fold in np.array_split(np.random.default_rng(0).permutation(len(q)), 5):
        seen = bs.Poses.make(q, pose, "board", "camera")
        training, unseen = seen.take(np.setdiff1d(np.arange(len(q)), fold)), seen.take(fold)
        problem = Problem(body, (training,), {"board": "no", "camera": "no"}, body.joints)
        fit = problem.fit(problem.variables(recordings.FULL), [training])
        residual = unseen.residual(fit.body)
        told = within_prediction(fit, unseen, fit.levels[0], residual, fit.freedom[0])
        inside.append(told["position"])
    return float(np.mean(np.concatenate(inside)))


def changed(
    arm: arms.Arm, truth: bs.Body, fault: str, size: float, rng: np.random.Generator
) -> tuple[bs.Body, str]:
    """The robot after a fault, and the part that had it."""
    if fault == "offset_deg":
        offsets = bs.free_joints(truth, ("offsets",), arm.joints)
        x = np.zeros(len(offsets))
        j = rng.integers(len(offsets))
        x[j] = np.deg2rad(size) * rng.choice([-1.0, 1.0])
        return truth.with_variables(offsets, x), arm.joints[j]
    if fault == "camera_mm":
        T = truth.placement[truth.frame_index("tracker")].copy()
        direction = rng.normal(size=3)
        T[:3, 3] += 1e-3 * size * direction / np.linalg.norm(direction)
        return truth.with_placement("tracker", T), "tracker"
    return truth, ""


def check(arm: arms.Arm, fault: str, size: float, seeds: int) -> dict[str, float]:
    """Calibrate on 60 samples, let the fault happen, check on 30 new ones; 5 % outliers in both."""
    detected, blamed = [], []
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        truth = arm.truth(rng)
        seen = arm.record(truth, 60, 0.05, rng)
        fit = arm.fit(seen)
        good = ~fit.outliers[0]
        fields = {seen.label: learn_discrepancy(fit.body, seen, good)}
        after, part = changed(arm, truth, fault, size, rng)
        answer = detect_change(fit, [arm.record(after, 30, 0.05, rng)], fields)
        detected.append(answer.changed)
        blamed.append(part in {suspect.part for suspect in answer.suspects})
    return {"detected": float(np.mean(detected)), "blamed": float(np.mean(blamed))}


def measure(data: Path, seeds: int) -> dict[str, Any]:
    """All figures."""
    cover: dict[str, Any] = {
        arm.name: {
            f"{share:.0%}": {str(n): coverage(arm, share, n, seeds) for n in SAMPLES}
            for share in OUTLIERS
        }
        for arm in arms.ARMS
    }
    cover["fr3_held_out"] = fr3_coverage(data)
    faults = {
        f"{fault} {size:g}": check(arms.ARMS[2], fault, size, 50 if fault != "none" else 300)
        for fault, size in FAULTS
    }
    plans = {arm.name: planning.plan_ratio(arm.name, seeds) for arm in arms.ARMS}
    return {
        "coverage": cover,
        "plan_ratio": {name: plan["ratio"] for name, plan in plans.items()},
        "plan": plans,
        "check": faults,
        "null_cases": null_cases.measure(),
    }


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description="Can the answers be believed?")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    parser.add_argument(
        "--data", type=Path, default=recordings.DATA, help="folder of the data sets"
    )
    parser.add_argument("--seeds", type=int, default=20, help="of each simulated case")
    options = parser.parse_args()
    figures = measure(options.data, options.seeds)
    print(json.dumps(figures) if options.json else json.dumps(figures, indent=2))


if __name__ == "__main__":
    main()
