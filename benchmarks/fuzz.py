"""Can a damaged or hostile file crash, hang, fill or run anything?

    python benchmarks/fuzz.py --mutants N [--seed S] [--reader NAME] [--only NAME:NUMBER]
        [--jobs 2] [--json]

Whole small inputs of every kind that is read are made, mutated (bytes, words, tables of JSON and
TOML, elements of XML, cells, columns of Parquet, headers of pictures), and read, each in a process
with 10 s and a bounded memory. A mutant must be read, or refused in a sentence; the verbs must end
with 0, 1 or 2. Counted are tracebacks, signals, hangs, and files touched or programs started
outside of the mutant's folder. A mutant depends on the seed, its reader and its number alone:
`--only "urdf:17"` makes one again and shows where it failed.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING

for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

if TYPE_CHECKING:
    from fuzzing.bench import Tally


def shares(mutants: int, names: list[str]) -> dict[str, int]:
    """Mutants of each reader, one at least."""
    from fuzzing.readers import READERS

    total = sum(READERS[name].share for name in names)
    return {name: max(1, round(mutants * READERS[name].share / total)) for name in names}


def _fuzzed(name: str, count: int, seed: int, place: str, first: int) -> Tally:
    from fuzzing.bench import fuzz

    return fuzz(name, count, seed, Path(place), first)


def run(mutants: int, seed: int, names: list[str], jobs: int = 1) -> Iterator[Tally]:
    """Fuzz readers, `jobs` of them at once; what became of each, as soon as it is known."""
    counts = shares(mutants, names)
    with tempfile.TemporaryDirectory(prefix="fuzz-") as place:
        if jobs == 1:
            for name, count in counts.items():
                yield _fuzzed(name, count, seed, place, 0)
            return
        # Spawned: each pool worker forks its own mutants from a process without threads.
        context = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(jobs, context) as pool:
            for future in [pool.submit(_fuzzed, n, c, seed, place, 0) for n, c in counts.items()]:
                yield future.result()


def _told(tally: Tally) -> str:
    """A line on a reader, and one on each kind of failure."""
    kinds = ", ".join(f"{n} {kind}" for kind, n in tally.outcomes.most_common())
    lines = [f"{tally.reader:14} {tally.mutants:6} mutants {tally.seconds:6.1f} s   {kinds}"]
    for detail, numbers in sorted(tally.failures.items(), key=lambda found: -len(found[1])):
        lines.append(f"    {len(numbers):4} x {detail}   {tally.reader}:{numbers[0]}")
    return "\n".join(lines)


def again(what: str, seed: int) -> int:
    """Make one mutant again, here, with its traceback."""
    import random

    from fuzzing.bench import mutate
    from fuzzing.readers import READERS

    name, _, number = what.rpartition(":")
    reader, rng = READERS[name], random.Random(f"{seed}:{name}:{int(number)}")
    with tempfile.TemporaryDirectory(prefix="fuzz-") as place:
        folder = Path(place) / "inside" / "work"
        folder.mkdir(parents=True)
        reader.make(folder)
        os.chdir(folder)
        path = mutate(reader, folder, rng)
        print(f"{path}: {path.read_bytes()[:3000]!r}")
        reader.read(path, rng)
    return 0


def main() -> int:
    """Print a line a reader and the sum; returns 1 if any mutant failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mutants", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--reader", action="append", default=[])
    parser.add_argument("--only", default="")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--json", action="store_true")
    asked = parser.parse_args()
    from fuzzing.readers import READERS

    if asked.only:
        return again(asked.only, asked.seed)
    unknown = [name for name in asked.reader if name not in READERS]
    if unknown:
        parser.error(f"no reader '{unknown[0]}'; there are: {', '.join(READERS)}")
    tallies = []
    for tally in run(asked.mutants, asked.seed, asked.reader or list(READERS), asked.jobs):
        tallies.append(tally)
        if not asked.json:
            print(_told(tally), flush=True)
    failed, made = sum(t.failed for t in tallies), sum(t.mutants for t in tallies)
    if asked.json:
        print(json.dumps({"mutants": made, "failed": failed, "readers": list(map(vars, tallies))}))
    else:
        print(f"{made} mutants, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
