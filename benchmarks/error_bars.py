"""Is the truth within what is stated, where the robot is not its model?

    python benchmarks/error_bars.py [--runs N] [--seed S] [--json]

For each kind of recording of `honest.faults` named in KINDS, N robots are calibrated; "covered" is
the share of 200 fresh postures of each, in the box of those recorded, whose error is below the 95 %
that the answer states, and "good" the share of the answers that say nothing against themselves.
Answers that are withheld state nothing, and are counted apart.
"""

from __future__ import annotations

import argparse
import json
import os

os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

import bodyschema as bs
from honest.calibrations import FOLDS, asked
from honest.drawing import draw
from honest.faults import FAULTS, Fault

KINDS = (
    "none", "sag 0.6 deg", "bending links", "gear waves", "drifting tracker", "warming",
    "12 postures x 7 frames", "AR noise (smooth path)", "8-20 rows", "sensor distortion",
)  # fmt: skip


def covered(fault: Fault, runs: int, seed: int) -> dict[str, float]:
    """Of one kind of recording."""
    shares, good, withheld = [], 0, 0
    for index in range(runs):
        rng = np.random.default_rng([seed, index, len(fault.name)])
        scene = fault.change(draw(fault.plan, rng), rng)
        senses, groups = scene.senses(rng), asked(scene, rng)
        answer = bs.calibrate(scene.given, senses, scene.frames, groups, folds=FOLDS)
        good += answer.trust.level == "good"
        if answer.withheld or answer.stated_95 is None:
            withheld += 1
            continue
        shares.append(np.mean(scene.errors(answer.body, rng) <= answer.stated_95))
    return {
        "runs": runs,
        "withheld": withheld,
        "good": good,
        "covered": float(np.mean(shares)) if shares else float("nan"),
    }


def main() -> None:
    """Print the shares."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--runs", type=int, default=20, help="of each kind")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    options = parser.parse_args()
    found = {
        fault.name: covered(fault, options.runs, options.seed)
        for fault in FAULTS
        if fault.name in KINDS
    }
    if options.json:
        print(json.dumps(found))
        return
    for name, one in found.items():
        print(
            f"{name:26} covered {100 * one['covered']:5.1f} %  of {one['runs']} runs, "
            f"{one['withheld']} withheld, {one['good']} good"
        )


if __name__ == "__main__":
    main()
