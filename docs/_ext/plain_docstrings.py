"""Turns this library's docstrings, which are plain text, into reStructuredText.

They are written to be read in an editor: `name` in backticks is code, an indented block is a
formula or a listing, *, | and a trailing _ are just characters, and the sections "Args:",
"Returns:" and "Raises:" have the Google form.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from itertools import groupby
from typing import Any

from sphinx.application import Sphinx

FIELDS = {"Args": "param", "Raises": "raises", "Returns": "returns"}
SECTION = re.compile(rf"({'|'.join(FIELDS)}):\s*$")
ENTRY = re.compile(r" {4}(\*{0,2}\w+): (.*)")
CODE = re.compile(r"(`+[^`]+`+)")
SPECIAL = re.compile(r"([*|\\])")
TRAILING_UNDERSCORE = re.compile(r"(?<=\w)_(?!\w)")
ALIAS = re.compile(r"TypeAliasForwardRef\('(\w+)'\)")


def to_rest(lines: Iterable[str]) -> list[str]:
    """The same text with sections as fields, listings set apart and characters escaped."""
    out: list[str] = []
    section = ""
    blocks = [list(block) for filled, block in groupby(lines, key=bool) if filled]
    for block in blocks:
        for indented, part in groupby(block, key=lambda line: line.startswith("  ")):
            text = list(part)
            heading = SECTION.match(text[-1])
            if not indented:
                section = heading[1] if heading else ""
                text = text[:-1] if heading else text
                out += [*map(escape, text), ""]
            elif section:
                out += [*_fields(section, text), ""]
            else:
                out += ["::", "", *text, ""]
    return out


def _fields(section: str, lines: Iterable[str]) -> Iterator[str]:
    """One field for each entry; for a section without entries, one field in all."""
    role, started = FIELDS[section], False
    for line in lines:
        entry = ENTRY.match(line) if role != "returns" else None
        if entry:
            yield f":{role} {escape(entry[1])}: {escape(entry[2])}"
        elif not started:
            yield f":{role}: {escape(line.strip())}"
        else:
            yield "    " + escape(line.strip())
        started = True


def escape(line: str) -> str:
    """Escape markup outside backticks, and make `code` of what is inside."""
    parts = CODE.split(line)
    for i, part in enumerate(parts):
        if i % 2:
            parts[i] = "``" + part.strip("`") + "``"
        else:
            parts[i] = TRAILING_UNDERSCORE.sub(r"\\_", SPECIAL.sub(r"\\\1", part))
    return "".join(parts)


def _docstring(app: Sphinx, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    lines[:] = to_rest(lines)


def _signature(
    app: Sphinx, what: str, name: str, obj: Any, options: Any, given: str | None, back: str | None
) -> tuple[str | None, str | None]:
    """Sphinx spells a type alias inside a union out as its placeholder; show the alias."""
    return given and ALIAS.sub(r"\1", given), back and ALIAS.sub(r"\1", back)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx."""
    app.connect("autodoc-process-docstring", _docstring)
    app.connect("autodoc-process-signature", _signature)
    return {"parallel_read_safe": True}
