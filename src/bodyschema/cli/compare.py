"""`bodyschema compare`: what differs between two results of one robot, and what it means."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from bodyschema.errors import InputError, shown
from bodyschema.units import millimetres, read_as, significant, with_error
from bodyschema.units import shown as in_unit

if TYPE_CHECKING:
    from bodyschema.answers.compared_part import ComparedPair, ComparedPart
    from bodyschema.answers.comparison import Comparison

MOST = 12
"""Parts that do not differ which are printed; --json has all."""


@dataclass(frozen=True)
class Compare:
    """Compare two results of one robot: what differs, how surely, what it moves. Code 1 if so."""

    first: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="A")]
    """Folder that a verb wrote."""
    second: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="B")]
    """Folder of another run of that robot; differences are B less A."""
    false_alarm: float = 0.01
    """Chance of calling two results different when nothing has changed; all parts counted in."""
    json: bool = False
    """Print one JSON object instead of text."""

    def run(self) -> int:
        """Compare and print; returns 1 when something differs."""
        from bodyschema.answers.answer import load
        from bodyschema.answers.comparison import compare

        if not 0 < self.false_alarm < 1:
            raise InputError(
                f"--false-alarm is a probability, between 0 and 1; got {self.false_alarm}."
            )
        found = compare(load(self.first), load(self.second), self.false_alarm)
        if self.json:
            print(json.dumps(_object(found, self)))
        else:
            print(shown("\n".join(_told(found, self.false_alarm))))
        return 0 if found.same else 1


def _object(found: Comparison, asked: Compare) -> dict[str, Any]:
    """The answer in plain types; SI, mm where a key says so."""
    return {
        "first": str(asked.first),
        "second": str(asked.second),
        "verdict": "the same" if found.same else "different",
        "same": found.same,
        "p_value": found.p_value,
        "differs": [part.part for part in found.parts if part.differs],
        "more_differs": found.unexplained,
        "parts": [
            {
                "part": part.part,
                "differs": part.differs,
                "or": list(part.alike),
                "difference": dict(zip(part.names, map(float, part.change), strict=True)),
                "std": dict(zip(part.names, map(float, part.std), strict=True)),
                "units": dict(zip(part.names, part.units, strict=True)),
                "deviations": part.deviations,
                "p_value": part.p_value,
                "moves_mm_95": 1e3 * part.effect,
                "moves_mm_between": [1e3 * part.effect_low, 1e3 * part.effect_high],
            }
            for part in found.parts
        ],
        "pairs": [
            {
                "seen_from": pair.seen_from,
                "seen": pair.seen,
                "apart_mm_95": 1e3 * pair.apart,
                "apart_deg_95": read_as("rad")[0] * pair.turned,
                "chance_mm_95": 1e3 * pair.chance,
                "chance_deg_95": read_as("rad")[0] * pair.chance_turned,
                "unexplained_mm_95": 1e3 * pair.left,
            }
            for pair in found.pairs
        ],
        "notes": list(found.notes),
    }


def _told(found: Comparison, false_alarm: float) -> Iterator[str]:
    """The verdict, what differs, what it moves, what does not differ."""
    chance = f"p = {found.p_value:.2g} (different below {false_alarm:g})"
    if found.same:
        yield f"the same: what differs is no more than chance brings; {chance}."
    else:
        named = ", ".join(_named(part) for part in found.parts if part.differs)
        yield f"different: {named or 'no single part explains it'}; {chance}."
        if named and found.unexplained:
            yield "More differs than these parts explain."
    yield ""
    yield from (_pair(pair, found) for pair in found.pairs)
    others = [part for part in found.parts if not part.differs]
    rows = [_row(part, found) for part in found.parts if part.differs or part in others[:MOST]]
    if rows:
        yield ""
        yield from _columns([("part", "B less A", "sd", "p", "moves (95 %)"), *rows])
    if len(others) > MOST:
        yield f"... and {len(others) - MOST} parts more that do not differ; --json has all."
    yield from ("", *found.notes) if found.notes else ()


def _named(part: ComparedPart) -> str:
    return " or ".join((part.part, *part.alike))


def _pair(pair: ComparedPair, found: Comparison) -> str:
    """Where two results place what was seen."""
    said = (
        f"{pair.seen} in {pair.seen_from}: {millimetres(pair.apart)} mm and "
        f"{in_unit(pair.turned, 'rad')} apart (95 % of postures); if nothing had changed below "
        f"{millimetres(pair.chance)} mm and {in_unit(pair.chance_turned, 'rad')}"
    )
    if any(part.differs for part in found.parts):
        said += f"; {millimetres(pair.left)} mm is left without what differs"
    return f"{said}."


Row = tuple[str, str, str, str, str]


def _row(part: ComparedPart, found: Comparison) -> Row:
    cells = []
    for name, unit, value, std in zip(part.names, part.units, part.change, part.std, strict=True):
        scale, word = read_as(unit)
        size, error = with_error(scale * float(value), scale * float(std))
        what = name.removeprefix(f"{part.part}.")
        cells.append(f"{what} {size} ± {error} {word}")
    moves = ""
    if found.pairs:
        low, high = (significant(1e3 * bound, 2) for bound in (part.effect_low, part.effect_high))
        size = f"{significant(1e3 * part.effect, 2)} mm ({low} to {high})"
        moves = size if part.differs else f"below {high} mm"
    mark = _named(part) if part.differs else part.part
    p_value = f"{part.p_value:.2g}" if part.p_value < 1 else "1"
    mark = ("* " if part.differs else "  ") + mark
    return mark, "; ".join(cells), _deviations(part), p_value, moves


def _deviations(part: ComparedPart) -> str:
    return f"{part.deviations:.1f}" if part.deviations < 100 else f"{part.deviations:.0f}"


def _columns(rows: list[Row]) -> Iterator[str]:
    """Rows under one another; the differences, which may be long, on lines of their own."""
    first, *rest = rows
    width = max(len(row[0]) for row in rest)
    for name, change, deviations, p_value, moves in (("  " + first[0], *first[1:]), *rest):
        yield f"{name:{width}}  {deviations:>6}  {p_value:>8}  {moves:24}  {change}".rstrip()
