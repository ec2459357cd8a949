"""The finished tasks of a study on disk: one JSON line each, appended as they come.

    study.json      paper, figure, settings and version: what the lines belong to
    tasks.jsonl     {"key": ..., "result": ...}

A line that was cut off by a power failure or a kill is dropped when the file is opened again. Lines
of other settings are never mixed in: results would then be those of no study at all.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from bodyschema.atomic import check_new_folder, new_file
from bodyschema.errors import InputError
from bodyschema.studies.study import Result

HEAD, LINES = "study.json", "tasks.jsonl"


@dataclass(frozen=True)
class Ledger:
    """A folder that remembers finished tasks."""

    folder: Path

    @classmethod
    def open(cls, folder: Path, head: Mapping[str, Any], overwrite: bool = False) -> Ledger:
        """Begin a folder, or go on in one that was begun with the same settings.

        Args:
            folder: made if it is not there.
            head: what the results depend on; JSON types.
            overwrite: forget what an earlier study left in the folder.

        Raises:
            InputError: the folder holds another study or something else, or cannot be written.
        """
        ledger = cls(folder)
        known = ledger._head()
        if known is None:
            check_new_folder(folder)
        elif overwrite:
            (folder / LINES).unlink(missing_ok=True)
        elif known != head:
            raise InputError(
                f"'{folder}' was begun with {_difference(known, head)}; name another folder with "
                "--out, or pass --overwrite to begin anew."
            )
        if known != head:
            with new_file(folder / HEAD) as fresh:
                fresh.write_text(json.dumps(head, indent=2) + "\n", encoding="utf-8")
        return ledger

    def finished(self) -> dict[str, Result]:
        """Results by key; cuts off a last line that is not whole."""
        path = self.folder / LINES
        if not path.is_file():
            return {}
        content = path.read_bytes()
        whole = content[: content.rfind(b"\n") + 1]
        if len(whole) < len(content):
            path.write_bytes(whole)
        entries = [json.loads(line) for line in whole.splitlines()]
        return {entry["key"]: entry["result"] for entry in entries}

    def add(self, key: str, result: Result) -> None:
        """Remember a finished task."""
        line = json.dumps({"key": key, "result": result}, allow_nan=False)
        with (self.folder / LINES).open("a", encoding="utf-8") as file:
            file.write(line + "\n")

    def _head(self) -> dict[str, Any] | None:
        path = self.folder / HEAD
        try:
            return dict(json.loads(path.read_text(encoding="utf-8"))) if path.is_file() else None
        except (OSError, ValueError):
            raise InputError(
                f"'{path}' cannot be read as the settings of a study; name another folder."
            ) from None


def _difference(known: Mapping[str, Any], head: Mapping[str, Any]) -> str:
    """The settings that differ, in words."""
    pairs = [
        f"{key} = {known.get(key)!r} (now {head.get(key)!r})"
        for key in dict.fromkeys([*known, *head])
        if known.get(key) != head.get(key)
    ]
    return ", ".join(pairs)
