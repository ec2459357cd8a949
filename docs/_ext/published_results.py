"""Puts tables of the stored results of the studies where a page has `<!-- published PAPER -->`.

They are made from benchmarks/published/PAPER_FIGURE.json, which `check.py --store` writes, so that
no page can say another number than the one that is checked.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

STORED = Path(__file__).parents[2] / "benchmarks" / "published"
PLACE = re.compile(r"<!-- published (\w+) -->")
NONE = "Nothing is stored yet."
MOST = 12
"""Lines of a study that does not say which of its numbers are told."""


def tables(paper: str, folder: Path = STORED) -> str:
    """For each stored study of a paper what was run, and its numbers."""
    documents = [json.loads(path.read_text("utf-8")) for path in files(paper, folder)]
    return "\n".join(line for document in documents for line in lines(document)) or NONE


def files(paper: str, folder: Path = STORED) -> list[Path]:
    """Of all stored studies of a paper: figure 3 before figure 10."""
    found = folder.glob(f"{paper}_*.json")
    return sorted(found, key=lambda path: [int(d) for d in re.findall(r"\d+", path.stem)[1:]])


def lines(document: Mapping[str, Any]) -> Iterator[str]:
    """Command, size and time of a study, and a line for each number that it tells."""
    copies = len(document["small"]["seeds"])
    yield f"`{document['command']}`: version {document['version']}, {document['date']}, "
    yield f"{document['cpu_seconds']:,.0f} s of processor time. Small: mean and standard deviation "
    yield f"of {copies} runs like `{document['small']['command']}`."
    yield ""
    yield "| | paper | here | small |"
    yield "|---|---|---|---|"
    for name, one in told(document["figures"]):
        around = f"{shown(one['mean'])} ± {shown(one['sd'])}" if "mean" in one else ""
        paper = one.get("paper", "").replace("<", "&lt;")
        yield f"| {one.get('words', f'`{name}`')} | {paper} | {shown(one['value'])} | {around} |"
    yield ""


def told(figures: Mapping[str, Any]) -> Sequence[tuple[str, Any]]:
    """The numbers that have words; the first that are checked where none has."""
    worded = [(name, one) for name, one in figures.items() if "words" in one]
    return worded or [(name, one) for name, one in figures.items() if "mean" in one][:MOST]


def shown(value: float | None) -> str:
    """Three digits, or all of a whole number."""
    if value is None:
        return "never"
    if value == round(value) or abs(value) >= 100:
        return f"{value:,.0f}"
    return f"{value:.3g}"


def _put_in(app: Sphinx, page: str, source: list[str]) -> None:
    for found in PLACE.finditer(source[0]):
        # A page is read again when one of its tables has changed.
        for path in files(found[1]):
            app.env.note_dependency(path, docname=page)
    source[0] = PLACE.sub(lambda found: tables(found[1]), source[0])


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx."""
    app.connect("source-read", _put_in)
    return {"parallel_read_safe": True}
