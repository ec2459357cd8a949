"""Today's key figures of every part of the product beside their frozen values.

    python benchmarks/figures.py [--only NAME...] [--json] [--list] [--freeze] [--data FOLDER]

A name is a figure's (fr3.clean) or that of its part (fr3); all when none is given. A figure is ok
when it is not worse than the frozen value by more than its tolerance; the exit code is 1 if one is
not, or could not be measured. Parts run in two processes, with one BLAS thread each; seconds are
of the processor. What is missing here (a package, a data set) is skipped with a word.

`--freeze` writes what is measured now to figures.json as the values to keep up with. Figures and
tolerances are in `key_figures/registry.py`.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from key_figures.figure import Figure, Outcome, Part, measure
from key_figures.registry import PARTS

FROZEN = Path(__file__).with_name("figures.json")
DATA = Path(__file__).resolve().parents[2] / "shared" / "data"
WORKERS = 2
ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""What numpy heeds when a worker imports it."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure and print; returns the exit code."""
    asked = _parser().parse_args(arguments)
    parts, figures = chosen(asked.only)
    if asked.list:
        show_list(parts, figures)
        return 0
    outcomes = list(measured(parts, asked.data))
    values = {key: v for one in outcomes for key, v in one.values.items() if key in figures}
    frozen = read_frozen()
    if asked.freeze:
        frozen = {key: v for key, v in (frozen | values).items() if key in _all()}
        FROZEN.write_text(json.dumps(dict(sorted(frozen.items())), indent=2) + "\n", "utf-8")
    skipped = {one.part for one in outcomes if one.skipped}
    keys = [part.key(f) for part in parts if part.name not in skipped for f in part.figures]
    rows = {
        key: judged(figures[key], values.get(key), frozen.get(key))
        for key in keys
        if key in figures
    }
    if asked.json:
        print(json.dumps({"figures": rows}))
    else:
        show(parts, figures, rows, outcomes)
    return int(not all(row["ok"] for row in rows.values()))


def chosen(names: Sequence[str]) -> tuple[list[Part], dict[str, Figure]]:
    """Parts to measure and figures to tell, by names of either; all when there are none."""
    figures = _all()
    known = {*figures, *(part.name for part in PARTS)}
    if unknown := [name for name in names if name not in known]:
        sys.exit(f"no figure '{unknown[0]}'; --list tells what there is.")
    told = {
        key: figure
        for key, figure in figures.items()
        if not names or key in names or key.partition(".")[0] in names
    }
    return [part for part in PARTS if part.keys.keys() & told.keys()], told


def _all() -> dict[str, Figure]:
    return {key: figure for part in PARTS for key, figure in part.keys.items()}


def measured(parts: Sequence[Part], data: Path) -> Iterator[Outcome]:
    """Outcomes as they come, each told on standard error."""
    os.environ.update(ONE_THREAD)
    # Spawned processes begin clean: no threads or compiled state of this one come along.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(WORKERS, context, initializer=_quiet) as pool:
        waiting = [pool.submit(measure, part, data) for part in parts]
        for done, future in enumerate(as_completed(waiting), start=1):
            one = future.result()
            word = one.failure or (f"skipped: {one.skipped}" if one.skipped else "")
            print(
                f"{done}/{len(parts)} {one.part} {one.seconds:.1f} s {word}",
                file=sys.stderr, flush=True,
            )  # fmt: skip
            yield one


def _quiet() -> None:
    """What a benchmark prints does not belong on standard output."""
    os.dup2(2, 1)


def read_frozen() -> dict[str, float]:
    """Values by whole names; none before the first `--freeze`."""
    if not FROZEN.is_file():
        return {}
    return dict(json.loads(FROZEN.read_text("utf-8")))


def judged(figure: Figure, value: float | None, frozen: float | None) -> dict[str, Any]:
    """A figure's line of the JSON object."""
    ok = figure.ok(value, frozen)
    return {"value": value, "frozen": frozen, "unit": figure.unit, "ok": ok}


def show(
    parts: Sequence[Part],
    figures: dict[str, Figure],
    rows: dict[str, dict[str, Any]],
    outcomes: Sequence[Outcome],
) -> None:
    """A line a figure; seconds stand at the first figure of a part."""
    seconds = {one.part: f"{one.seconds:.1f}" for one in outcomes}
    table = Table()
    for head in ("figure", "value", "frozen", "tolerance", "unit", "ok", "CPU s"):
        table.add_column(head, justify="left" if head in ("figure", "unit", "ok") else "right")
    for key, row in rows.items():
        figure, frozen = figures[key], row["frozen"]
        table.add_row(
            key, _number(row["value"]), _number(frozen), tolerance(figure, frozen), row["unit"],
            "yes" if row["ok"] else "NO", seconds.pop(key.partition(".")[0], ""),
        )  # fmt: skip
    # As wide as it needs, in a file too.
    Console(width=120).print(table)
    for one in outcomes:
        if one.skipped:
            print(f"{one.part} was skipped: {one.skipped}")
    bad = [key for key, row in rows.items() if not row["ok"]]
    total = sum(one.seconds for one in outcomes)
    print(f"{len(rows) - len(bad)} of {len(rows)} ok, {total:.0f} s of processor time.")


def show_list(parts: Sequence[Part], figures: dict[str, Figure]) -> None:
    """What there is, with reasons."""
    for part in parts:
        for key, figure in part.keys.items():
            if key in figures:
                print(f"{key:30} {figure.better:6} {tolerance(figure, None):>8} "
                      f"{figure.unit:12} {figure.reason}")  # fmt: skip


def tolerance(figure: Figure, frozen: float | None) -> str:
    """With the direction in which it is allowed; a share as such when nothing is frozen."""
    sign = {"lower": "+", "higher": "-", "equal": "±"}[figure.better]
    if figure.relative and frozen is None:
        return f"{sign}{100 * figure.tolerance:.0f} %"
    return sign + _number(figure.band(frozen or 0.0))


def _number(value: float | None) -> str:
    return "never" if value is None else f"{value:.4g}"


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument(
        "--only", nargs="+", default=[], metavar="NAME", help="figures or parts; all when absent"
    )
    parser.add_argument("--json", action="store_true", help="one JSON object on standard output")
    parser.add_argument("--list", action="store_true", help="tell what there is, measure nothing")
    parser.add_argument("--freeze", action="store_true", help="keep what is measured as frozen")
    parser.add_argument("--data", type=Path, default=DATA, help="folder of the data sets")
    return parser


if __name__ == "__main__":
    sys.exit(main())
