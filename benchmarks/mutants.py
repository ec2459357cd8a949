"""Are the promises of the watching code guarded? Each rule is removed; a test must fail.

    python benchmarks/mutants.py [--only WORD] [--json]

A mutant (`mutants.toml`) is one replacement in a copy of the source tree, in a folder that goes
away again. The guarantee tests of the mutant's own file run on each copy; a mutant that they let
pass has survived. Without changes all tests must pass, which is run first.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
SOURCE = ROOT / "src"


class Mutant(NamedTuple):
    """One rule, removed."""

    name: str
    file: str
    """In the package."""
    old: str
    """Stands in the file exactly once."""
    new: str
    test: str
    """File of tests/guarantee that must fail."""


MUTANTS = tuple(
    Mutant(**entry)
    for entry in tomllib.loads((ROOT / "benchmarks/mutants.toml").read_text())["mutant"]
)


class Outcome(NamedTuple):
    """What became of a mutant."""

    mutant: str
    killed: bool
    seconds: float
    """CPU."""
    by: str
    """The first test that failed."""


def run(source: Path, test: str) -> tuple[bool, str, float]:
    """Whether the guarantee tests of a file pass on a source tree; the first that fails; CPU s."""
    target = ROOT / "tests/guarantee" / test
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-n", "0", "-p", "no:cacheprovider"]
    environment = os.environ | {"PYTHONPATH": str(source), "OMP_NUM_THREADS": "1"}
    begin = os.times()
    done = subprocess.run(
        [*command, str(target)], cwd=ROOT, env=environment, capture_output=True, text=True
    )
    end = os.times()
    failed = [line for line in done.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    by = failed[0].partition("::")[2].partition(" - ")[0] if failed else done.stdout[-300:]
    return done.returncode == 0, by, end.children_user - begin.children_user


def outcome(mutant: Mutant) -> Outcome:
    """One mutant.

    Raises:
        ValueError: its text does not stand in the file exactly once.
    """
    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "src"
        # With compiled kernels and their times: only what changes is compiled anew.
        shutil.copytree(SOURCE, source)
        path = source / "bodyschema" / mutant.file
        text = path.read_text()
        if text.count(mutant.old) != 1:
            raise ValueError(f"'{mutant.name}': text stands {text.count(mutant.old)} times.")
        path.write_text(text.replace(mutant.old, mutant.new))
        passed, by, seconds = run(source, mutant.test)
    return Outcome(mutant.name, not passed, seconds, "" if passed else by)


def main() -> None:
    """Print what was killed and what survived; exit 1 if anything survived."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--only", default="", help="mutants whose name or test has this word")
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    options = parser.parse_args()
    chosen = [m for m in MUTANTS if options.only in f"{m.name} {m.test} {m.file}"]
    whole, begin = 0.0, time.process_time()
    for test in sorted({m.test for m in chosen}):
        passed, by, seconds = run(SOURCE, test)
        whole += seconds
        if not passed:
            sys.exit(f"{test} fails on the code as it is: {by}")
    found = []
    for mutant in chosen:
        found.append(outcome(mutant))
        word = "killed  " if found[-1].killed else "SURVIVED"
        print(
            f"{word} {found[-1].seconds:5.1f} s  {mutant.name}  {found[-1].by}",
            file=sys.stderr,
            flush=True,
        )
    survived = [one.mutant for one in found if not one.killed]
    answer = {
        "mutants": len(found), "killed": len(found) - len(survived), "survived": survived,
        "unchanged_cpu_s": whole, "cpu_s": time.process_time() - begin,
    }  # fmt: skip
    print(json.dumps(answer) if options.json else json.dumps(answer, indent=2))
    sys.exit(bool(survived))


if __name__ == "__main__":
    main()
