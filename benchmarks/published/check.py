"""Do the studies still find what is stored of them? A small run of each must fall inside.

    python benchmarks/published/check.py [--only NAME...] [--runs N] [--json] [--list]
    python benchmarks/published/check.py --store NAME... [--out FOLDER] [--workers N]

A name is PAPER_FIGURE, as hersch2008_figure3; all that are stored when none is given. `--runs`
takes the mean of so many small runs. Exit code 1 if a number falls outside (see `spread.py`), never
came, or a study failed. `--store` does the full-size run and writes NAME.json here; interrupted,
the same command goes on in FOLDER.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

# Run as a script, only this folder is searched.
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np

from bodyschema.errors import MissingExtraError
from bodyschema.studies.runner import run_study
from published.entries import ENTRIES
from published.entry import GATE, Entry
from published.spread import digits, half_width, inside
from published.store import STORED, Document, read_stored, stored


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare, or store; returns the exit code."""
    asked = _parser().parse_args(arguments)
    if asked.list:
        return show_list()
    if asked.store:
        return store([known(name) for name in asked.store], asked.out, asked.workers)
    documents = chosen(asked.only)
    rows: dict[str, Document] = {}
    for name, document in documents.items():
        row = compared(known(name), document, asked.runs)
        print(f"{name}: {told(row)}", file=sys.stderr, flush=True)
        if "skipped" not in row:
            rows[name] = row
    if asked.json:
        print(json.dumps({"studies": rows}))
    else:
        show(rows)
    return int(not all(row["ok"] for row in rows.values()))


def known(name: str) -> Entry:
    """The entry of that name."""
    if name not in ENTRIES:
        sys.exit(f"no study '{name}'; --list tells what there is.")
    return ENTRIES[name]


def chosen(names: Sequence[str]) -> dict[str, Document]:
    """What is stored of these, or of all."""
    documents = read_stored()
    for name in names:
        known(name)
        if name not in documents:
            sys.exit(f"nothing is stored of {name}; check.py --store {name} does so.")
    return {name: documents[name] for name in names or documents}


def compared(entry: Entry, document: Mapping[str, Any], runs: int = 1) -> Document:
    """Do small runs of a study, and say which of their numbers are not as stored."""
    begin = time.process_time()
    try:
        studies = [entry.study(entry.small, GATE + run) for run in range(runs)]
        found = [entry.chosen(study.summary(run_study(study, 1))) for study in studies]
    except MissingExtraError as missing:
        return {"ok": False, "skipped": str(missing)}
    except Exception as error:
        return {"ok": False, "failure": f"{type(error).__name__}: {error}"}
    seconds = round(time.process_time() - begin, 1)
    return judged(document["figures"], found) | {"seconds": seconds}


def judged(figures: Mapping[str, Any], found: Sequence[Mapping[str, float | None]]) -> Document:
    """The line of a study: what lies outside, by name, with what is allowed."""
    outside: Document = {}
    gated = {name: one for name, one in figures.items() if "mean" in one}
    for name, one in gated.items():
        values = [copy.get(name) for copy in found]
        lost = any(value is None for value in values)
        value = None if lost else digits(float(np.mean(values)))  # type: ignore[arg-type]
        if not inside(value, one, len(found)):
            width = digits(half_width(one, len(found)))
            outside[name] = {"value": value, "stored": one["mean"], "within": width}
    return {"ok": bool(gated) and not outside, "numbers": len(gated), "outside": outside}


def store(entries: Sequence[Entry], folder: Path, workers: int) -> int:
    """Write the files of these studies; returns 0 if a small run falls inside each."""
    good = True
    for entry in entries:
        document = stored(entry, folder, workers)
        text = json.dumps(document, indent=1, allow_nan=False) + "\n"
        (STORED / f"{entry.name}.json").write_text(text, "utf-8")
        row = compared(entry, document)
        print(f"{entry.name}.json: {document['cpu_seconds']:g} s; a small run: {told(row)}")
        good &= row["ok"]
    return int(not good)


def told(row: Mapping[str, Any]) -> str:
    """A study in words."""
    if "skipped" in row or "failure" in row:
        return f"skipped: {row['skipped']}" if "skipped" in row else str(row["failure"])
    if row["ok"]:
        return f"{row['numbers']} numbers inside, {row['seconds']:g} s"
    return "outside: " + ", ".join(
        f"{name} {one['value']} (stored {one['stored']} +- {one['within']})"
        for name, one in row["outside"].items()
    )


def show(rows: Mapping[str, Document]) -> None:
    """How many are as they were."""
    bad = [name for name, row in rows.items() if not row["ok"]]
    print(f"{len(rows) - len(bad)} of {len(rows)} studies find what is stored.")
    if bad:
        print("Not: " + ", ".join(bad))


def show_list() -> int:
    """All entries, stored or not; returns 0."""
    there = read_stored()
    for name, entry in ENTRIES.items():
        state = there[name]["date"] if name in there else "not stored"
        print(f"{name:28} {state:12} {entry.command(entry.small, GATE)}")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    add = parser.add_argument
    add("--only", nargs="+", default=[], metavar="NAME", help="these studies; all when absent")
    add("--runs", type=int, default=1, help="small runs of each, whose mean is compared")
    add("--json", action="store_true", help="one JSON object on standard output")
    add("--list", action="store_true", help="tell what there is, run nothing")
    add("--store", nargs="+", default=[], metavar="NAME", help="do the full-size runs of these")
    add("--out", type=Path, default=Path("studies/published"), help="folder of the stored runs")
    add("--workers", type=int, default=1, help="processes, for --store")
    return parser


if __name__ == "__main__":
    sys.exit(main())
