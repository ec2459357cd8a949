"""The answer of `calibrate`, as one JSON object for machines and as text for people."""

from __future__ import annotations

import math
from typing import Any

from rich.console import Console
from rich.table import Table

from bodyschema.learning.calibration import Accuracy, Calibration, describe_groups
from bodyschema.learning.held_out import Errors

MOST_SENTENCES = 5
"""Sentences on what the data cannot tell that the terminal shows; the files hold all."""

SHOWN = {"rad": (180 / math.pi, "deg"), "m": (1e3, "mm"), "1": (100.0, "%")}
"""What people read instead of SI."""

DETERMINED = 0.5
"""A parameter with more of its prior variance than this in open directions has no error bar."""


def as_json(calibration: Calibration) -> dict[str, Any]:
    """Everything of the answer in plain types; lengths in mm, rotations in deg, values in SI."""
    estimate = calibration.estimate
    parameters, known = estimate.parameters, calibration.identifiability
    rows = zip(
        parameters.names, estimate.x, estimate.std, parameters.units, known.open_share, strict=True
    )
    return {
        "verdict": calibration.verdict,
        "explanation": calibration.explanation,
        "groups": list(calibration.groups),
        "nominal": accuracy_json(calibration.nominal),
        "held_out": accuracy_json(calibration.held_out),
        "held_out_with_residual_field": accuracy_json(calibration.with_field),
        "models": [
            {
                "groups": list(candidate.groups),
                "parameters": candidate.n_parameters,
                "score": candidate.score,
                "standard_errors_behind": candidate.behind,
                **accuracy_json(candidate.accuracy),
            }
            for candidate in calibration.candidates
        ],
        "unidentifiable": list(known.sentences),
        "parameters": [
            {
                "name": name,
                "value": float(value),
                "std": float(std) if share < DETERMINED else None,
                "unit": unit,
                "identifiable": bool(share < DETERMINED),
                "combined_with": list(known.partners(name)),
            }
            for name, value, std, unit, share in rows
        ],
        "noise": dict(estimate.noise or {}),
        "outliers": list(calibration.outliers),
        "clock": {
            "p_value": calibration.clock.p_value,
            "late_rows": list(calibration.clock.late_rows),
        },
        "rows": calibration.n_rows,
        "converged": calibration.fit.converged,
        "seconds": calibration.seconds,
    }


def accuracy_json(accuracy: Accuracy) -> dict[str, Any]:
    """Errors in mm and deg; no rotation where none was seen."""
    shown = {"position_mm": _errors(accuracy.position, 1e3)}
    if accuracy.rotation is not None:
        shown["rotation_deg"] = _errors(accuracy.rotation, 180 / math.pi)
    return shown


def _errors(errors: Errors, scale: float) -> dict[str, float]:
    return {name: scale * getattr(errors, name) for name in ("rms", "median", "max")}


def print_answer(console: Console, calibration: Calibration) -> None:
    """Verdict, errors before and after, parameters, and what the data do not tell."""
    colour = {"calibrated": "green", "only frames": "yellow", "refused": "red"}
    verdict = calibration.verdict
    console.print(f"\n[bold {colour[verdict]}]{verdict}[/]  {calibration.explanation}\n")
    console.print(_error_table(calibration))
    console.print(_parameter_table(calibration))
    sentences = calibration.identifiability.sentences
    if sentences:
        console.print("[bold]What these data cannot tell[/]")
        for sentence in sentences[:MOST_SENTENCES]:
            console.print(f"  - {sentence}", highlight=False)
        if len(sentences) > MOST_SENTENCES:
            more = len(sentences) - MOST_SENTENCES
            console.print(f"  ... and {more} more; calibration.yaml lists all.")
    for line in _warnings(calibration):
        console.print(line, highlight=False)


def _warnings(calibration: Calibration) -> list[str]:
    lines = []
    clock = calibration.clock
    if clock.faulty:
        rows = ", ".join(map(str, clock.late_rows)) or "none singly certain"
        lines.append(
            f"[bold yellow]Clock fault[/] (p = {clock.p_value:.2g}): the body was seen after it had "
            f"begun to move on; rows {rows}. Compare the clocks of joints and tracker."
        )
    if calibration.outliers:
        shown = ", ".join(map(str, calibration.outliers[:20]))
        more = " ..." if len(calibration.outliers) > 20 else ""
        lines.append(
            f"[bold]{len(calibration.outliers)} outlier rows[/] (counted from 0) were held off and "
            f"left out of the errors above: {shown}{more}"
        )
    if not calibration.fit.converged:
        lines.append("[bold yellow]The fit had not settled[/] when the iterations ran out.")
    return lines


def _error_table(calibration: Calibration) -> Table:
    table = Table(title=f"Held-out error over {calibration.n_rows} rows", title_justify="left")
    posed = calibration.held_out.rotation is not None
    heads = ("", "rms mm", "median mm", "max mm", *(("rms deg",) if posed else ()))
    for head in heads:
        table.add_column(head, justify="left" if not head else "right")
    named = (
        ("as modelled", calibration.nominal),
        (describe_groups(calibration.groups) + " corrected", calibration.held_out),
        ("... with the residual field", calibration.with_field),
    )
    for name, accuracy in named:
        position = accuracy.position
        cells = [f"{1e3 * value:.2f}" for value in (position.rms, position.median, position.max)]
        if accuracy.rotation is not None:
            cells.append(f"{math.degrees(accuracy.rotation.rms):.3f}")
        table.add_row(name, *cells)
    return table


def _parameter_table(calibration: Calibration) -> Table:
    table = Table(title="Corrections", title_justify="left")
    for head in ("parameter", "value", "± std", "unit"):
        table.add_column(head, justify="left" if head in ("parameter", "unit") else "right")
    estimate, known = calibration.estimate, calibration.identifiability
    names, units = estimate.parameters.names, estimate.parameters.units
    rows = zip(names, estimate.x, estimate.std, units, known.open_share, strict=True)
    for name, value, std, unit, share in rows:
        scale, shown = SHOWN[unit]
        bar = f"{scale * std:.3f}" if share < DETERMINED else "not determined"
        table.add_row(name, f"{scale * value:+.3f}", bar, shown)
    return table
