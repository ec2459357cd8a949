"""How many iterations a fit takes, and whether its levels are right.

    python benchmarks/solver.py [--json] [--data FOLDER] [--quick]

table      iterations and processor time of each bed of `solver_beds`, beside those of the solver
           before (expectation-maximisation with Marquardt's damping), measured once on one machine
random     the same for 30 random beds: mean, largest, unsettled
grid       over the variants of a bed that the old solver failed in: fits that settled, levels
           within 10 % of the residuals' rms, outliers missed and false, and how often the largest
           model, which is the true one, is the best by held-out density
family     what the robust family costs: level over true, error of the tip and coverage of the 95 %
           bound, by kind of noise, for the Student-t of 4 alone and for the family that adapts
repeats    coverage where each posture was seen several times and the model errs by posture, with
           each sample counted in full and for what it is worth
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

import bodyschema as bs
import solver_beds as beds
from bodyschema.estimation.held_out import folds_of, held_out
from bodyschema.estimation.loss import Loss
from bodyschema.estimation.prediction import degrees_of_freedom, predict_error
from bodyschema.model.kinematics import relative_pose
from recordings import DATA

ADAPTS, STUDENT = bs.Solver(), bs.Solver(Loss(adapt=False))
FULL_COUNT = 1e-12
"""rad: no two postures are nearer to each other, so that every sample counts in full."""

BEFORE: dict[str, tuple[int, float]] = {
    "fr3 clean": (42, 100.0),
    "fr3, 15 % at 3 cm": (56, 126.0),
    "fr3, 15 % at 20 cm": (57, 126.0),
    "talos": (81, 101.0),
    "narrow points": (45, 62.0),
    "narrow poses": (39, 74.0),
    "7 joints, 300 points": (32, 126.0),
    "7 joints, 3,000 poses": (40, 2595.0),
    "7 joints, 10,000 points": (66, 9462.0),
    "three senses": (36, 298.0),
    "grid, a joint that never moves": (50, 146.0),
}
"""Iterations and ms of the old solver."""

BEFORE_RANDOM = {"mean": 44.2, "largest": 100, "unsettled": 2, "ms": 2525.0}
BEFORE_GRID = {
    "beds": 16,
    "fits": 48,
    "settled": 34,
    "level": 3,
    "order": 16,
    "missed": 0,
    "false": 0,
}


def fitted(bed: beds.Bed, solver: bs.Solver = ADAPTS) -> tuple[bs.Estimate, float]:
    """A fit and its processor time in s, the better of two."""
    times = []
    for _ in range(2):
        begin = time.process_time()
        fit = bed.fit(solver)
        times.append(time.process_time() - begin)
    return fit, min(times)


def iterations(data: Path) -> dict[str, Any]:
    """Of each bed."""
    found = {}
    for name, make in beds.table(data).items():
        bed = make()
        fit, seconds = fitted(bed)
        found[name] = {
            "iterations": fit.iterations,
            "student_t_alone": fitted(bed, STUDENT)[0].iterations,
            "settled": fit.converged,
            "ms": 1e3 * seconds,
            "before": BEFORE[name][0],
            "before_ms": BEFORE[name][1],
        }
    return found


def random_beds(n: int) -> dict[str, Any]:
    """Of random beds."""
    runs = [fitted(beds.drawn(seed)) for seed in range(n)]
    steps = [fit.iterations for fit, _ in runs]
    return {
        "mean": float(np.mean(steps)),
        "largest": max(steps),
        "unsettled": sum(not fit.converged for fit, _ in runs),
        "ms": 1e3 * sum(seconds for _, seconds in runs),
        "before": BEFORE_RANDOM,
    }


def grid(seeds: int) -> dict[str, Any]:
    """Over the variants of the bed."""
    keys = ("beds", "fits", "settled", "level", "order", "outliers", "missed", "false")
    found = dict.fromkeys(keys, 0)
    for changes in beds.VARIANTS.values():
        for seed in range(seeds):
            judge_variant(seed, changes, found)
    return found


def judge_variant(seed: int, changes: dict[str, Any], found: dict[str, int]) -> None:
    """Add what one bed shows."""
    scores = {}
    for groups in beds.MODELS:
        bed = beds.grid(seed, groups=groups, **changes)
        fit, senses = bed.fit(ADAPTS), bed.problem.senses
        cut = folds_of(senses, 5, 0)
        again = held_out(lambda s, b=bed, f=fit: b.problem.again(f, s), senses, cut, Loss())
        scores[groups] = again.scores[~bed.bad[0]].mean()
        found["fits"] += 1
        found["settled"] += fit.converged
    found["beds"] += 1
    (sense,), (bad,) = senses, bed.bad
    left = sense.residual(fit.body)[~bad][:, :3]
    # The fit has taken some of the noise out of its own residuals.
    rms = np.sqrt(np.sum(left**2) / (left.size * degrees_of_freedom(fit, senses) / total(senses)))
    found["level"] += bool(abs(spread(fit) / rms - 1) < 0.1)
    found["order"] += min(scores, key=lambda groups: scores[groups]) == beds.FULL
    found["outliers"] += int(bad.sum())
    found["missed"] += int((bad & ~fit.outliers[0]).sum())
    found["false"] += int((fit.outliers[0] & ~bad).sum())


def total(senses: Sequence[Any]) -> int:
    """Numbers of all samples."""
    return sum(len(sense) * len(sense.covariance) for sense in senses)


def spread(fit: bs.Estimate) -> float:
    """Standard deviation in m of a number with the level and the tails of the first sense."""
    level, nu = next(iter((fit.noise or {}).values())), fit.freedom[0]
    return level * float(np.sqrt(nu / (nu - 2))) if 2 < nu < np.inf else level


def family(seeds: int) -> dict[str, Any]:
    """By kind of noise."""
    kinds = {
        "normal": (np.inf, 0.0, 100),
        "normal, 15 % at 3 cm": (np.inf, 0.15, 100),
        "normal, 30 % at 3 cm": (np.inf, 0.3, 100),
        "t4": (4.0, 0.0, 100),
        "t4, 15 % at 3 cm": (4.0, 0.15, 100),
        "normal, 40 samples": (np.inf, 0.0, 40),
    }
    return {
        name: {
            "student_t": in_noise(STUDENT, *kind, seeds),
            "adapts": in_noise(ADAPTS, *kind, seeds),
        }
        for name, kind in kinds.items()
    }


def in_noise(solver: bs.Solver, nu: float, share: float, n: int, seeds: int) -> dict[str, float]:
    """Mean level over true, mm at the tip, coverage; 7 joints, 1 mm."""
    rows = []
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        body, truth = beds.arm(7, rng)
        q = rng.uniform(-2, 2, (n, 7))
        noise = 1e-3 * rng.normal(size=(n, 3))
        if np.isfinite(nu):
            noise *= np.sqrt(nu / rng.chisquare(nu, n))[:, None]
        sense = beds.seen(truth, q, (0.0, 0.0), "points", rng)
        sense, _ = beds.spoil(replace(sense, observed=sense.observed + noise), share, 0.03, rng)
        fit = beds.bed(body, [sense], ("tracker", "tool")).fit(solver)
        rows.append([fit.levels[0][0], *judged(fit, truth, [sense], rng)])
    level, tip, within = np.mean(rows, axis=0)
    return {"level": level, "tip_mm": tip, "within_95": within}


def judged(
    fit: bs.Estimate, truth: bs.Body, senses: list[Any], rng: np.random.Generator
) -> tuple[float, float]:
    """rms error of the tip in mm at fresh postures, and the share within its 95 % bound."""
    q = rng.uniform(-2, 2, (100, len(truth.joints)))
    there, true = (relative_pose(b, q, "tracker", "tool")[:, :3, 3] for b in (fit.body, truth))
    error = np.linalg.norm(there - true, axis=1)
    said = predict_error(fit, q, "tracker", "tool", degrees_of_freedom(fit, senses))
    return 1e3 * float(np.sqrt(np.mean(error**2))), float(np.mean(error < said.position))


def repeats(seeds: int) -> dict[str, Any]:
    """Postures x samples, errors by posture and by sample in mm."""
    kinds = {
        "12 x 7, 1 and 0.3 mm": (12, 7, 1e-3, 0.3e-3),
        "30 x 7, 1 and 1 mm": (30, 7, 1e-3, 1e-3),
        "30 x 7, 0 and 1 mm": (30, 7, 0.0, 1e-3),
        "20 x 50, 1 and 1 mm": (20, 50, 1e-3, 1e-3),
    }
    solvers = {"in_full": replace(ADAPTS, same_posture=FULL_COUNT), "worth": ADAPTS}
    return {
        name: {key: in_repeats(solver, *kind, seeds) for key, solver in solvers.items()}
        for name, kind in kinds.items()
    }


def in_repeats(
    solver: bs.Solver, n: int, m: int, by_posture: float, by_sample: float, seeds: int
) -> dict[str, float]:
    """mm at the tip and coverage; 6 joints, offsets free."""
    rows = []
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        body = bs.Body.random_chain(6, rng).attach("tracker", "base").attach("tool", "tip")
        offsets = bs.free_joints(body, ("offsets",))
        truth = body.with_variables(offsets, 0.05 * rng.normal(size=6))
        truth = truth.with_placement("tracker", beds.placed(rng, rng.uniform(-1, 1, 3)))
        q = np.repeat(rng.uniform(-2, 2, (n, 6)), m, axis=0) + 1e-10 * rng.normal(size=(n * m, 6))
        sense = beds.seen(truth, q, (by_sample, 0.0), "points", rng)
        shift = np.repeat(by_posture * rng.normal(size=(n, 3)), m, axis=0)
        sense = replace(sense, observed=sense.observed + shift)
        fit = beds.bed(body, [sense], ("tracker", "tool"), ("offsets",)).fit(solver)
        rows.append(judged(fit, truth, [sense], rng))
    tip, within = np.mean(rows, axis=0)
    return {"tip_mm": tip, "within_95": within}


def main() -> None:
    """Print the figures."""
    parser = argparse.ArgumentParser(description="Iterations, levels and coverage of the solver.")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the data sets")
    parser.add_argument("--quick", action="store_true", help="the table alone")
    options = parser.parse_args()
    figures = {"table": iterations(options.data), "random": random_beds(30)}
    if not options.quick:
        figures |= {
            "grid": grid(1),
            "grid_before": BEFORE_GRID,
            "family": family(16),
            "repeats": repeats(16),
        }
    print(json.dumps(figures) if options.json else json.dumps(figures, indent=2))


if __name__ == "__main__":
    main()
