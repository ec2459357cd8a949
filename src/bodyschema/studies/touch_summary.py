"""What the touches of a study come to: millimetres, rates and shares."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bodyschema.studies.study import Result

Part = tuple[Mapping[str, Any], Result]
"""Settings of a task, and what it found."""


def refusals(parts: Sequence[Part], force: float, others: Sequence[str]) -> Result:
    """Share of the contacts of each other kind, with a force in N, that are taken for no point."""
    answer: Result = {}
    for kind in others:
        here = [r for s, r in parts if s["kind"] == kind and s["force"] == force]
        answer[kind] = share([verdict != "point" for r in here for verdict in r["verdicts"]])
    return answer


def compared(blocks: Sequence[Result], ending: str, speed: str, speeds: Sequence[str]) -> Result:
    """Both methods in one case at one force.

    Args:
        blocks: what the tasks of a surface and force found.
        ending: "" within the paper's premises, "_outside" outside them.
        speed: that of the case; its figures come out on top.
        speeds: all of them.

    Returns:
        "faithful" and "better", each with `speeds`; the first with `readings` of the text too.
    """
    cells: dict[str, Result] = {"faithful": {}, "better": {}}
    for s in speeds:
        here = [block["compared"][ending][s] for block in blocks]
        readings = {
            reading: millimetres([e for part in here for e in part["faithful"][reading]])
            for reading in here[0]["faithful"]
        }
        cells["faithful"][s] = readings["one"] | {"readings": readings}
        cells["better"][s] = span(here)
    return {name: found[speed] | {"speeds": found} for name, found in cells.items()}


def span(blocks: Sequence[Result]) -> Result:
    """Of touches that were looked for: millimetres, and how many were held, missed or invented."""
    errors = [e for block in blocks for e in block["error"]]
    unnoticed = sum(block["unnoticed"] for block in blocks)
    return millimetres(errors) | {
        "coverage": share([h for block in blocks for h in block["held"]]),
        "taken_for_points": share([p for block in blocks for p in block["point"]]),
        "unnoticed": unnoticed / (len(errors) + unnoticed),
        "false_between_touches": sum(block["false"] for block in blocks),
        "touches": len(errors) + unnoticed,
    }


def millimetres(errors: Sequence[float]) -> Result:
    """Median and 95 % of distances in m; None of none."""
    if not errors:
        return {"median_mm": None, "p95_mm": None}
    e = 1e3 * np.array(errors)
    return {"median_mm": float(np.median(e)), "p95_mm": float(np.quantile(e, 0.95))}


def share(flags: Sequence[bool]) -> float | None:
    """Of those that are true; None of none."""
    return float(np.mean(flags)) if len(flags) else None


def span_text(cell: Mapping[str, float | None]) -> str:
    """Median and 95 % for a table."""
    middle, tail = cell["median_mm"], cell["p95_mm"]
    if middle is None or tail is None:
        return "-"
    return "/".join(f"{value:.{0 if value >= 10 else 1 if value >= 1 else 2}f}"
                    for value in (middle, tail))  # fmt: skip


def percent(value: float | None) -> str:
    """A share for a table."""
    return "-" if value is None else f"{100 * value:.0f}"
