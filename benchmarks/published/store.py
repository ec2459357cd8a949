"""A full-size run and its small copies, made into the JSON file of a study.

All runs lie in one folder a study, each as the study itself keeps it, so that what was interrupted
goes on: FOLDER/full, FOLDER/copy-1001 ...; `seconds.jsonl` adds up the processor's time. Figures of
the same runs have one folder.
"""

from __future__ import annotations

import json
import resource
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from datetime import date
from importlib.metadata import version
from pathlib import Path
from typing import Any

from bodyschema.studies.ledger import Ledger
from bodyschema.studies.runner import run_study, settings_of
from bodyschema.studies.study import source_of
from published.entry import FIRST_COPY, Entry
from published.spread import digits, spread

STORED = Path(__file__).parent
Document = dict[str, Any]


def read_stored(folder: Path = STORED) -> dict[str, Document]:
    """The stored results by name."""
    return {
        path.stem: json.loads(path.read_text("utf-8")) for path in sorted(folder.glob("*.json"))
    }


def stored(entry: Entry, folder: Path, workers: int) -> Document:
    """Run what has not been run yet, and put it together.

    Args:
        entry: the study.
        folder: where the runs of all studies are kept.
        workers: processes.

    Returns:
        What the file of the study holds.
    """
    full = entry.study(entry.full)
    folder = folder / f"{entry.paper}_{source_of(full)}"
    summary = summary_in(full, folder, "full", workers)
    seeds = range(FIRST_COPY, FIRST_COPY + entry.copies)
    copies = [
        # In this process: to begin others would take longer than so small a run.
        entry.chosen(summary_in(entry.study(entry.small, seed), folder, f"copy-{seed}", workers=1))
        for seed in seeds
    ]
    spent = seconds_spent(folder)
    small = [spent.get(f"copy-{seed}", 0.0) for seed in seeds]
    return {
        "study": f"{entry.paper} {entry.figure}",
        "command": entry.command({"runs": full.runs} | entry.full, full.seed),
        "settings": settings_of(full),
        "seed": full.seed,
        "runs": full.runs,
        "version": version("bodyschema"),
        "date": date.today().isoformat(),
        "cpu_seconds": round(spent.get("full", 0.0), 1),
        "small": {
            "command": entry.command(entry.small, FIRST_COPY),
            "seeds": list(seeds),
            "cpu_seconds": round(sum(small) / len(small), 1),
        },
        "figures": figures(entry, entry.chosen(summary), copies),
    }


def figures(
    entry: Entry, found: Mapping[str, float | None], copies: list[dict[str, float | None]]
) -> Document:
    """Value of the full run, spread of the small ones, and the paper's, by name."""
    answer = {}
    for name, value in found.items():
        one: Document = {"value": None if value is None else digits(value)}
        around = spread([copy.get(name) for copy in copies]) if entry.gated(name) else None
        if around:
            least = entry.least_of(name)
            one |= around | ({"least": least} if least else {})
        told = entry.told.get(name)
        if told:
            one |= {"words": told.words} | ({"paper": told.paper} if told.paper else {})
        answer[name] = one
    return answer


def summary_in(study: Any, folder: Path, name: str, workers: int) -> Document:
    """The summary of a study whose finished tasks are kept in FOLDER/NAME."""
    folder.mkdir(parents=True, exist_ok=True)
    ledger = Ledger.open(folder / name, settings_of(study))
    with clocked(folder, name):
        results = run_study(study, workers, ledger)
    return dict(study.summary(results))


@contextmanager
def clocked(folder: Path, name: str) -> Iterator[None]:
    """Note the time of this process and its children, also of a sitting that was interrupted."""
    begin = _processor()
    try:
        yield
    finally:
        line = json.dumps({"run": name, "seconds": round(_processor() - begin, 3)})
        with (folder / "seconds.jsonl").open("a", encoding="utf-8") as file:
            file.write(line + "\n")


def seconds_spent(folder: Path) -> dict[str, float]:
    """Processor's time of each run, over all its sittings."""
    spent: dict[str, float] = {}
    for line in (folder / "seconds.jsonl").read_text("utf-8").splitlines():
        entry = json.loads(line)
        spent[entry["run"]] = spent.get(entry["run"], 0.0) + entry["seconds"]
    return spent


def _processor() -> float:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime
