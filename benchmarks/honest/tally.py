"""Tally: outcomes counted, as one JSON object and as a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from honest.outcome import Outcome


def tally(outcomes: Sequence[Outcome], only_bad: int = 3) -> dict[str, Any]:
    """Counts over all, by fault and by kind, and the good runs' flags and bars.

    Args:
        outcomes: of all runs.
        only_bad: how many failed runs are named for each fault.
    """
    faults = list(dict.fromkeys((one.kind, one.fault) for one in outcomes))
    plain = [one for one in outcomes if not one.apart]
    return {
        **_counts(outcomes),
        "by_fault": {
            fault if kind == "calibrate" else f"{kind}: {fault}": _row(
                [one for one in outcomes if (one.kind, one.fault) == (kind, fault)], only_bad
            )
            for kind, fault in faults
        },
        "good": _good([one for one in outcomes if one.good]),
        "good_by_sense": {
            sense: _good([one for one in outcomes if one.good and one.sense == sense])
            for sense in dict.fromkeys(one.sense for one in outcomes if one.sense)
        },
        "with_rivals": _counts(plain),
        "apart": _counts([one for one in outcomes if one.apart]),
        "by_kind": {
            kind: {
                **_counts([one for one in outcomes if one.kind == kind]),
                "good": _good([one for one in outcomes if one.kind == kind and one.good]),
            }
            for kind in dict.fromkeys(one.kind for one in outcomes)
        },
        "crashed": [f"{one.kind}/{one.name} {one.crash}" for one in outcomes if one.crash],
        "cpu_seconds": round(sum(one.seconds for one in outcomes), 1),
    }


def _counts(some: Sequence[Outcome]) -> dict[str, int]:
    return {
        "runs": len(some),
        "wrong": sum(one.wrong for one in some),
        "unflagged": sum(one.unflagged for one in some),
    }


def _row(some: Sequence[Outcome], only_bad: int) -> dict[str, Any]:
    counts = _counts(some)
    told = np.array([one.ratio for one in some])
    told = told[np.isfinite(told)]
    return {
        "n": counts["runs"],
        "wrong": counts["wrong"],
        "unflagged": counts["unflagged"],
        "flagged": sum(one.doubted if one.good else one.flagged for one in some),
        "true_over_stated": round(float(np.median(1 / told)), 3) if len(told) else None,
        "cpu_seconds": round(float(np.mean([one.seconds for one in some])), 2),
        "failed": [one.name for one in some if one.unflagged or (one.good and one.doubted)][
            :only_bad
        ],
    }


def _good(some: Sequence[Outcome]) -> dict[str, Any]:
    """Flags, and stated over true: a median, or of single errors that of their 95 %."""
    told = np.array([one.ratio for one in some if not one.single])
    told = told[np.isfinite(told)]
    alone = np.array([1 / one.ratio for one in some if one.single])
    alone = alone[np.isfinite(alone)]
    low, middle, high = np.quantile(told, [0.1, 0.5, 0.9]) if len(told) else [np.nan] * 3
    return {
        "n": len(some),
        "flagged": sum(one.doubted for one in some),
        "stated_over_true": _number(middle),
        "stated_over_true_10": _number(low),
        "stated_over_true_90": _number(high),
        "single_stated_over_true": _number(1 / np.quantile(alone, 0.95) if len(alone) else np.nan),
    }


def _number(value: float) -> float | None:
    return round(float(value), 3) if np.isfinite(value) else None


def show(counted: dict[str, Any]) -> None:
    """The table, faults with unflagged runs first to the eye by their names."""
    table = Table()
    heads = ("fault", "n", "wrong", "unflagged", "flagged", "true / stated", "CPU s", "failed")
    for head in heads:
        table.add_column(head, justify="left" if head in ("fault", "failed") else "right")
    for fault, row in counted["by_fault"].items():
        ratio = row["true_over_stated"]
        table.add_row(
            fault, str(row["n"]), str(row["wrong"]), str(row["unflagged"]), str(row["flagged"]),
            "" if ratio is None else f"{ratio:.2f}", f"{row['cpu_seconds']:.2f}",
            " ".join(name.rpartition(":")[2] for name in row["failed"]),
        )  # fmt: skip
    # As wide as it needs, in a file too.
    Console(width=140).print(table)
    for name in ("with_rivals", "apart"):
        part = counted[name]
        print(f"{name}: {part['unflagged']} of {part['runs']} wrong and unflagged")
    good = counted["good"]
    print(
        f"all: {counted['unflagged']} of {counted['runs']} wrong and unflagged; good runs: "
        f"{good['flagged']} of {good['n']} flagged, stated / true {good['stated_over_true']} "
        f"({good['stated_over_true_10']}-{good['stated_over_true_90']}), of single errors "
        f"{good['single_stated_over_true']}; "
        f"{counted['cpu_seconds']:.0f} s of processor time"
    )
    for crash in counted["crashed"]:
        print(f"crashed: {crash}")
