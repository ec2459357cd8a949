"""What the touches of a study come to: millimetres, rates and shares."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from bodyschema.studies.study import Result

Part = tuple[Mapping[str, Any], Result]
"""Settings of a task, and what it found."""


def at_force(
    force: float, parts: Sequence[Part], others: Sequence[str], false: Mapping[str, float]
) -> Result:
    """The cell of a surface and a force.

    Args:
        force: N.
        parts: of the surface.
        others: kinds of contact that are no points.
        false: touches an hour that were none, by condition; "identified" comes out on top.
    """
    here = [(settings, result) for settings, result in parts if settings.get("force") == force]
    blocks = [result for settings, result in here if settings["kind"] == "point"]
    cells = {name: _span([r[name] for r in blocks], rate) for name, rate in false.items()}
    cells["paper"] = millimetres([e for r in blocks for e in r["identified"]["paper"]])
    refused = {}
    for kind in others:
        verdicts = [v for s, r in here if s["kind"] == kind for v in r["verdicts"]]
        refused[kind] = share([verdict != "point" for verdict in verdicts])
    return cells.pop("identified") | cells | {"refused": refused}


def _span(blocks: Sequence[Result], false_per_hour: float) -> Result:
    errors = [e for block in blocks for e in block["error"]]
    unnoticed = sum(block["unnoticed"] for block in blocks)
    return millimetres(errors) | {
        "false_per_hour": false_per_hour,
        "coverage": share([held for block in blocks for held in block["held"]]),
        "taken_for_points": share([point for block in blocks for point in block["point"]]),
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
