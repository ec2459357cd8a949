"""How to make the same result again: command, run, versions, hashes of the inputs."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from bodyschema.export.documents import plain, versions
from bodyschema.report.evidence import Evidence
from bodyschema.report.page import render

APART = ("command", "versions", "sha256")
"""Entries of a run that are shown by themselves."""


@dataclass(frozen=True)
class Reproduction:
    """Everything that the numbers depend on."""

    evidence: Evidence
    title: str = "How to reproduce it"

    def render(self) -> str:
        """See `Section`."""
        return reproduction_html(self.evidence.run)


def reproduction_html(run: Mapping[str, Any]) -> str:
    """Of a run with its command, versions and hashes; see `export.result_folder.run_record`."""
    known = plain(run)
    asked = {key: value for key, value in known.items() if key not in APART}
    return render(
        "reproduction.html",
        command=known.get("command", ""),
        asked="\n".join(f"{key}: {_line(value)}" for key, value in asked.items()),
        versions=known.get("versions") or versions(),
        hashes=known.get("sha256", {}),
    )


def _line(value: object) -> str:
    """JSON, records of a list and long mappings on lines of their own."""
    nested = isinstance(value, dict | list) and any(isinstance(v, dict) for v in _inner(value))
    if not nested:
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, dict):
        lines = [
            f"  {key}: {json.dumps(inner, ensure_ascii=False)}" for key, inner in value.items()
        ]
    else:
        lines = [f"  - {json.dumps(inner, ensure_ascii=False)}" for inner in _inner(value)]
    return "\n" + "\n".join(lines)


def _inner(value: object) -> list[object]:
    if isinstance(value, dict):
        return list(value.values())
    return list(value) if isinstance(value, list) else []
