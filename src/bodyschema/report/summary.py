"""An answer in short: one JSON object for machines, text for people."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from io import StringIO
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from bodyschema.estimation.clock import FALSE_ALARM
from bodyschema.export.calibration_yaml import (
    millimetres_95,
    predicted_errors,
    skeleton_entries,
    uncertainty,
)
from bodyschema.export.load_entry import load_entries, load_lines
from bodyschema.export.static_transforms import place_entries
from bodyschema.judging.calibration import Calibration
from bodyschema.judging.places import OPEN, PREFIX
from bodyschema.report.answer_first import angles, far_off, known, position, quaternion
from bodyschema.units import read_as, significant

COLOURS = {"good": "green", "doubtful": "yellow", "bad": "red"}

RMS_FIRST = ("rms", "median", "max")

HINT = "`bodyschema report FOLDER --all`"
"""How to see what an answer in short leaves out."""

MOST_ROWS = 20
"""Outlier rows that the terminal names; the files hold all."""


def as_json(calibration: Calibration) -> dict[str, Any]:
    """Everything of the answer in plain types; lengths in mm, rotations in deg, values in SI."""
    estimate = calibration.estimate
    variables, known = estimate.variables, calibration.identifiability
    rows = zip(
        variables.names, estimate.x, estimate.std, variables.units, known.open_share, strict=True
    )
    return {
        "transforms": place_entries(calibration),
        "verdict": calibration.verdict,
        "explanation": calibration.explanation,
        "trust": calibration.trust.document,
        "predicted_95_mm": millimetres_95(calibration),
        "uncertainty": uncertainty(calibration),
        "learner": calibration.learner,
        "groups": list(calibration.groups),
        "skeleton": skeleton_entries(calibration),
        "nominal": calibration.nominal.document(),
        "held_out": calibration.held_out.document(),
        "held_out_with_residual_field": calibration.with_field.document(),
        "predicted": predicted_errors(calibration),
        "agreement": calibration.agreement,
        "models": [
            {
                "groups": list(candidate.groups),
                "parameters": candidate.n_parameters,
                "score": candidate.score,
                "standard_errors_behind": candidate.behind,
                **candidate.accuracy.document(),
            }
            for candidate in calibration.candidates
        ],
        "unidentifiable": list(known.sentences),
        "parameters": [
            {
                "name": name,
                "value": float(value),
                "std": float(std) if share <= OPEN else None,
                "unit": unit,
                "identifiable": bool(share <= OPEN),
                "combined_with": list(known.partners(name)),
            }
            for name, value, std, unit, share in rows
        ],
        "findings": list(calibration.findings),
        "notes": list(calibration.notes),
        "loads": load_entries(estimate),
        "noise": dict(estimate.noise or {}),
        "outliers": list(calibration.outliers),
        "clock": {
            "p_value": calibration.clock.p_value,
            "late_rows": list(calibration.clock.late_rows),
        },
        "rows": calibration.n_rows,
        "converged": calibration.fit.converged,
        "seconds": calibration.seconds,
        **calibration.details,
    }


def summary_text(document: Mapping[str, Any], width: int = 100, everything: bool = False) -> str:
    """What `print_answer` prints, as plain text of so many columns."""
    console = Console(width=width, file=StringIO(), color_system=None, force_terminal=False)
    with console.capture() as text:
        print_answer(console, document, everything)
    return text.get().strip()


def print_answer(
    console: Console, document: Mapping[str, Any], everything: bool = False, hint: str = HINT
) -> None:
    """What was asked for, whether to believe it, and what to change; the rest when asked.

    Args:
        console: where to.
        document: everything that was found; see `calibration_document`.
        everything: also errors, all parameters, and what the data do not tell.
        hint: how to see everything; "" where nothing does.
    """
    console.print()
    for entry in document["transforms"]:
        _print_place(console, entry)
    _print_verdict(console, document)
    _print_trust(console, document["trust"], everything)
    if everything and any(document["held_out"]["after"].values()):
        console.print(_error_table(document))
    if everything and document["predicted"]:
        console.print(_prediction(document), highlight=False)
    for line in (*load_lines(document["loads"]), *document["findings"]):
        console.print(line, highlight=False, markup=False, soft_wrap=True)
    folded = _print_parameters(console, document, everything)
    if everything:
        _print_untold(console, document["not_determined"])
    for line in _warnings(document, everything):
        console.print(line, highlight=False)
    if not everything and hint:
        _print_folded(console, document, folded, hint)


def _print_place(console: Console, entry: Mapping[str, Any]) -> None:
    """Numbers for people, how well they are known, and lines to copy."""
    console.print(f"[bold]{escape(entry['name'])}[/]", highlight=False)
    for line in (
        f"xyz {position(entry)} mm",
        f"rpy {angles(entry)} deg",
        f"quaternion xyzw {quaternion(entry)}",
        known(entry),
    ):
        console.print(Padding(Text(line), (0, 0, 0, 2), expand=False), highlight=False)
    for key in ("origin", "command"):
        if key in entry:
            console.print(f"  {entry[key]}", highlight=False, markup=False, soft_wrap=True)
    console.print()


def _print_verdict(console: Console, document: Mapping[str, Any]) -> None:
    """The stated error first, the held-out one below."""
    style, far = COLOURS[document["tone"]], escape(far_off(document))
    explanation = escape(document["explanation"])
    first = f"[bold]{far}[/]" if far else explanation
    console.print(f"[bold {style}]{document['verdict']}[/]  {first}", highlight=False)
    if far:
        console.print(explanation, highlight=False)
    console.print()


def _print_trust(console: Console, trust: Mapping[str, Any], everything: bool) -> None:
    """Why the answer is not to be taken at its word; nothing where it is.

    The gravest reason of a limited answer; all where the data contradict it.
    """
    if trust["level"] == "good":
        return
    limited = trust["level"] == "limited"
    style = COLOURS["doubtful" if limited else "bad"]
    console.print(f"[bold {style}]Trust: {trust['level']}[/]")
    shown = trust["reasons"][: 1 if limited and not everything else None]
    for reason in shown:
        console.print(f"  - {escape(reason)}", highlight=False)
    more = len(trust["reasons"]) - len(shown)
    if more:
        console.print(f"  ... and {more} more reason{'s' * (more > 1)}.", highlight=False)
    console.print()


def _print_parameters(console: Console, document: Mapping[str, Any], everything: bool) -> int:
    """The skeleton, or what was changed; none where a wrist's sensor was told.

    Returns:
        How many parameters were not shown.
    """
    if document.get("skeleton"):
        console.print(_skeleton_table(document["skeleton"]))
        return 0
    rows = [p for p in document["parameters"] if not p["group"].startswith("load:")]
    if "sensor" in document["details"] or not rows:
        return 0
    changed = [r for r in rows if r["written_std"] is not None and not _is_frame(r)]
    if everything:
        console.print(_parameter_table(rows))
        return 0
    if changed:
        console.print(_parameter_table(changed, written=True))
    return len([r for r in rows if r["written_std"] is None])


def _is_frame(row: Mapping[str, Any]) -> bool:
    return bool(row["group"].startswith(PREFIX))


def _print_folded(console: Console, document: Mapping[str, Any], folded: int, hint: str) -> None:
    """What was left out, in one line."""
    left = []
    if any(document["held_out"]["after"].values()):
        left.append("errors before and after")
    if folded:
        said = "unchanged within their error or not determined"
        left.append(f"{folded} other parameter{'s' * (folded > 1)} ({said})")
    if document["not_determined"]:
        n = len(document["not_determined"])
        left.append(f"{n} sentence{'s' * (n > 1)} on what the data cannot tell")
    if left:
        console.print(f"[dim]More with {escape(hint)}: {', '.join(left)}.[/]", highlight=False)


def _print_untold(console: Console, sentences: Sequence[str]) -> None:
    if sentences:
        console.print("[bold]What these data cannot tell[/]")
        for sentence in sentences:
            console.print(f"  - {escape(sentence)}", highlight=False)


def _prediction(document: Mapping[str, Any]) -> str:
    """The stated error first, what noise alone would leave, and the worst by postures."""
    worst = max(entry["position_mm_95"] for entry in document["predicted"])
    anywhere = max(entry["anywhere_position_mm_95"] for entry in document["predicted"])
    parts, first = document.get("uncertainty"), document["predicted_95_mm"]
    alone = "" if parts is None else f", where noise alone would leave {parts['noise_mm_95']:.2f}"
    return (
        f"Predicted error of the corrected body: 95 % below [bold]{first:.2f} mm[/] over the joint "
        f"ranges recorded{alone}. In the postures seen {worst:.2f} mm, anywhere {anywhere:.2f} mm; "
        f"{100 * document['agreement']:.0f} % of the held-out errors lie within their bounds.\n"
    )


def _warnings(document: Mapping[str, Any], everything: bool) -> list[str]:
    lines = []
    if document["clock_p_value"] < FALSE_ALARM:
        rows = ", ".join(map(str, document["late_rows"])) or "none singly certain"
        instead = document["instead_of_late"]
        lines.append(
            f"[bold yellow]{'Perhaps a clock' if instead else 'Clock'} fault[/] "
            f"(p = {document['clock_p_value']:.2g}): the body was seen after it had begun to move "
            f"on; rows {rows}. Compare the clocks of joints and tracker."
            + (f" Or rather, {escape(instead)}: that explains more." if instead else "")
        )
    outliers = document["outlier_rows"]
    if outliers:
        shown = ", ".join(map(str, outliers[:MOST_ROWS]))
        more = " ..." if len(outliers) > MOST_ROWS else ""
        lines.append(
            f"[bold]{len(outliers)} outlier rows[/] (counted from 0) were held off and "
            f"left out of the errors above: {shown}{more}"
            if everything
            else f"[bold]{len(outliers)} of {document['rows']} rows[/] are outliers and were left "
            "out."
        )
    if not document["converged"]:
        learner = document.get("learner", "batch")
        when = "the iterations ran out" if learner == "batch" else f"{learner} had seen all samples"
        lines.append(f"[bold yellow]The fit had not settled[/] when {when}.")
    return [*lines, *(escape(note) for note in document["notes"])]


def _error_table(document: Mapping[str, Any]) -> Table:
    left = document["rows"] - len(document["outlier_rows"])
    over = f"{left} of {document['rows']}" if left < document["rows"] else str(left)
    table = Table(title=f"Held-out error over {over} rows", title_justify="left")
    held_out = document["held_out"]
    before, after = document["compared"]
    named = [(before, held_out["before"]), (after, held_out["after"])]
    if any(held_out["after_with_residual_field"].values()):
        named.append(("... with the residual field", held_out["after_with_residual_field"]))
    seen = [name for name, errors in held_out["after"].items() if errors is not None]
    seen.sort(key=lambda name: name != "position_mm")
    table.add_column("")
    for i, name in enumerate(seen):
        for what in RMS_FIRST if i == 0 else RMS_FIRST[:1]:
            quantity, unit = name.rsplit("_", 1)
            plain = quantity in ("position", "rotation")
            head = f"{what} {unit}" if plain else f"{what} {quantity} {unit}"
            table.add_column(head, justify="right")
    for what, accuracy in named:
        first = seen[0] == "position_mm"
        cells = [_number(accuracy[seen[0]][k], 2 if first else None) for k in RMS_FIRST]
        rest = [(name, 3 if name == "rotation_deg" else None) for name in seen[1:]]
        cells += [_number(accuracy[name]["rms"], decimals) for name, decimals in rest]
        table.add_row(what, *cells)
    return table


def _skeleton_table(skeleton: Mapping[str, Mapping[str, Any]]) -> Table:
    title = "Skeleton: axis of each joint, and its centre in the link it hangs on"
    table = Table(title=title, title_justify="left")
    for head in ("joint", "hangs on", "axis", "± deg", "link mm"):
        table.add_column(head, justify="left" if head in ("joint", "hangs on") else "right")
    for joint, entry in skeleton.items():
        axis = " ".join(f"{a:+.2f}" for a in entry["axis"])
        link = " ".join(f"{1e3 * c:+.0f}" for c in entry["link"])
        error = f"{math.degrees(entry['axis_std']):.2f}"
        table.add_row(escape(joint), escape(entry["parent"]), axis, error, link)
    return table


def _parameter_table(variables: Sequence[Mapping[str, Any]], written: bool = False) -> Table:
    """All values with their errors; of what is written those, the others being as modelled.

    Args:
        variables: entries of the document's `parameters`.
        written: whether all of them are.
    """
    table = Table(title="Corrections", title_justify="left")
    for head in ("parameter", "value", "± std", "unit"):
        left = head in ("parameter", "unit")
        table.add_column(head, justify="left" if left else "right", overflow="fold")
    for entry in variables:
        scale, shown = read_as(entry["unit"])
        changed = written or (entry["written_std"] is not None and not _is_frame(entry))
        value, error = ("written", "written_std") if changed else ("value", "std")
        std = entry[error]
        bar = "not determined" if std is None else f"{scale * std:.3f}"
        table.add_row(escape(entry["name"]), f"{scale * entry[value]:+.3f}", bar, shown)
    return table


def _number(value: float | None, decimals: int | None) -> str:
    """With so many decimals, or to three significant digits."""
    if value is None:
        return "-"
    return significant(value) if decimals is None else f"{value:.{decimals}f}"


def finite(value: object) -> object:
    """JSON has no NaN and no infinity: null says that there is no number."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list):
        return [finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
