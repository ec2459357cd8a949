"""Cost of a sample of the linear relation, and whether it stays the same.

    python benchmarks/linear_relation.py [--json]

update_us   adding the rows of one sample to the sums: 16 unknowns (3 rows), 25 (6), 40 (3)
solve_us    smallest eigenvector of the sums
learn_us    one sample of the hand-eye learner once it is certified, its fits included
watch_us    one sample of the monitor while it observes
drift       watch_us in the last five minutes of an hour of stream over that in the first five

All are CPU times of one process; the fastest of several repeats where there are repeats.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable

import bodyschema  # noqa: F401  (sets one BLAS thread a process, so it must come before numpy)

# isort: split
import numpy as np

from bodyschema.learners.hand_eye.points import HandEyePoints
from bodyschema.learners.published.linear_relation import Moments, PaperRelation
from bodyschema.monitoring.monitor import Monitor
from bodyschema.simulation.katana import RATE, draw_scene, stereo, stream

SIZES = {16: 3, 25: 6, 40: 3}
"""Unknowns -> rows."""


def fastest(work: Callable[[], object], times: int, repeats: int = 7) -> float:
    """Microseconds a call."""
    work()
    best = np.inf
    for _ in range(repeats):
        begin = time.process_time()
        for _ in range(times):
            work()
        best = min(best, time.process_time() - begin)
    return 1e6 * best / times


def sums() -> dict[str, dict[str, float]]:
    """Update and solution at each size."""
    rng, update, solve = np.random.default_rng(0), {}, {}
    for unknowns, rows in SIZES.items():
        A = rng.normal(size=(rows, unknowns))
        moments = Moments.empty(unknowns)
        for _ in range(100):
            moments = moments.add(rng.normal(size=(rows, unknowns)))
        learner = PaperRelation(unknowns)
        update[str(unknowns)] = fastest(lambda m=moments, a=A: m.add(a), 2000)
        solve[str(unknowns)] = fastest(lambda m=moments, k=learner: k.solve(m), 300)
    return {"update_us": update, "solve_us": solve}


def watching() -> dict[str, float]:
    """An hour of stream through learner and monitor."""
    rng = np.random.default_rng(0)
    scene = draw_scene(rng)
    seen = stream(scene, 3600, stereo(), rng)
    monitor = Monitor(HandEyePoints(stereo()))
    state, five = monitor.start(), round(300 * RATE)
    pieces, begin = [], time.process_time()
    for i in range(len(seen)):
        state, _ = monitor.step(state, (seen.sample(i),))
        if i % five == five - 1:
            pieces.append(1e6 * (time.process_time() - begin) / five)
            begin = time.process_time()
    belief, last = state.belief, seen.sample(len(seen) - 1)
    learn = fastest(lambda: monitor.learner.step(belief, (last,)), 300)
    # The first five minutes hold the identification; watching begins with the second.
    return {
        "learn_us": learn,
        "watch_us": float(np.median(pieces[1:])),
        "drift": pieces[-1] / pieces[1],
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    answer = sums() | watching()
    print(json.dumps(answer) if arguments.json else json.dumps(answer, indent=2))


if __name__ == "__main__":
    main()
