"""How often is a wrong answer given a green light, and a good one none?

    python benchmarks/honesty.py --runs N [--only FAULT,...] [--kinds KIND,...] [--seed S]
        [--workers 2] [--json] [--ledger FILE] [--list]

Robots, sensors and recordings with known faults are simulated and given to the public functions.
An answer is *wrong* if the truth is beyond twice the 95 % error that it states, and *unflagged* if
it is wrong while its trust is good and its verdict is not withheld. Runs are shared out over the
kinds, ten for `calibrate` to one for each other, and over the faults of each kind, one after the
other; a run depends on the seed, its fault and its number alone, so that `--only "late 50 ms:17"`
makes one run again. Kinds:

    calibrate   arms seen by trackers and cameras, see honest/faults.py
    hand-eye    lists of poses of a hand and of a target
    payload     what hangs on a wrist with a force sensor
    track       pictures of an arm without markers
    touch       where something touches an arm, by the wrist's force

"good" counts the runs without a fault: how many are not trusted, and the stated error over the true
one (median, and 10 and 90 %). Faults that nothing in the product looks for are told "apart".
"""

from __future__ import annotations

import argparse
import importlib
import json
import multiprocessing
import os
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from honest.outcome import Outcome
    from honest.trial import Row

ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"
)
"""What numpy heeds when a worker imports it."""

KINDS = {
    "calibrate": "honest.calibrations",
    "hand-eye": "honest.hand_eyes",
    "payload": "honest.payloads",
    "track": "honest.tracks",
    "touch": "honest.touches",
}
"""Kind -> module with its ROWS."""

SHARES = dict.fromkeys(KINDS, 1) | {"calibrate": 10}
"""Of the runs: its recordings have the most faults."""

Job = tuple[str, str, int]
"""Kind, fault, index."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run and print; returns the exit code."""
    asked = _parser().parse_args(arguments)
    os.environ.update(ONE_THREAD)
    from honest.tally import show, tally

    kinds = asked.kinds.split(",")
    if unknown := [kind for kind in kinds if kind not in KINDS]:
        sys.exit(f"no kind '{unknown[0]}'; there are {', '.join(KINDS)}.")
    if asked.list:
        for kind in kinds:
            print("\n".join(f"{kind}: {row.fault}" for row in rows(kind)))
        return 0
    total = sum(SHARES[kind] for kind in kinds)
    jobs = [
        job
        for kind in kinds
        for job in shared_out(kind, -(-asked.runs * SHARES[kind] // total), asked.only)
    ]
    if not jobs:
        sys.exit(f"no fault '{asked.only}'; --list tells what there is.")
    outcomes = []
    for done, (job, one) in enumerate(measured(jobs, asked.seed, asked.workers), start=1):
        outcomes.append((job, one))
        word = "UNFLAGGED" if one.unflagged else one.crash or one.level
        if asked.ledger is not None:
            write(asked.ledger, asked.seed, one)
        print(f"{done}/{len(jobs)} {one.kind}: {one.name} {word} {one.seconds:.1f} s",
              file=sys.stderr, flush=True)  # fmt: skip
    outcomes.sort(key=lambda pair: jobs.index(pair[0]))
    found = [one for _, one in outcomes]
    counted = tally(found)
    print(json.dumps(counted)) if asked.json else show(counted)
    return 0


def write(ledger: Path, seed: int, one: Outcome) -> None:
    """Append a run, at once: a campaign that is broken off has not been for nothing."""
    line = json.dumps({"seed": seed, "at": time.strftime("%Y-%m-%dT%H:%M:%S"), **one.record})
    with ledger.open("a", encoding="utf-8") as file:
        file.write(line + "\n")


def rows(kind: str) -> tuple[Row, ...]:
    """The rows of a kind's table."""
    return tuple(importlib.import_module(KINDS[kind]).ROWS)


def shared_out(kind: str, runs: int, only: str) -> list[Job]:
    """Which runs: as many as asked for, evenly over the chosen faults by their weights."""
    names = [name.strip() for name in only.split(",") if name.strip()]
    single = [name.rpartition(":") for name in names if name.rpartition(":")[2].isdigit()]
    table = rows(kind)
    known = {row.fault for row in table}
    if single:
        return [(kind, fault, int(index)) for fault, _, index in single if fault in known]
    chosen = [row for row in table if not names or row.fault in names]
    jobs: list[Job] = []
    for turn in count() if chosen else ():
        for row in chosen:
            jobs += [(kind, row.fault, row.weight * turn + i) for i in range(row.weight)]
        if len(jobs) >= runs:
            break
    return jobs[:runs]


def measured(jobs: Sequence[Job], seed: int, workers: int) -> Iterator[tuple[Job, Outcome]]:
    """Outcomes as they come."""
    if workers <= 1:
        yield from ((job, run(job, seed)) for job in jobs)
        return
    # Spawned processes begin clean: no threads or compiled state of this one come along.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, context, initializer=_quiet) as pool:
        waiting = {pool.submit(run, job, seed): job for job in jobs}
        for future in as_completed(waiting):
            yield waiting[future], future.result()


def run(job: Job, seed: int) -> Outcome:
    """One run."""
    kind, fault, index = job
    row = next(row for row in rows(kind) if row.fault == fault)
    return row.run(index, seed)


def _quiet() -> None:
    """What a verb prints does not belong on standard output."""
    os.dup2(2, 1)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--runs", type=int, default=200, help="of all kinds together")
    parser.add_argument("--only", default="", help='faults, with commas; "FAULT:NUMBER" for a run')
    parser.add_argument("--kinds", default=",".join(KINDS), help="with commas; all")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    parser.add_argument("--ledger", type=Path, help="file to append a line a run to")
    parser.add_argument("--list", action="store_true", help="tell what there is, measure nothing")
    return parser


if __name__ == "__main__":
    sys.exit(main())
