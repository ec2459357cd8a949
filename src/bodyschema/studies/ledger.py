"""The finished tasks of a study on disk: one JSON line each, appended as they come.

    study.json      paper, figure, settings and version: what the lines belong to
    tasks.jsonl     {"key": ..., "result": ..., "crc": ...}
    summary.json, figure.png, figure.svg    made of all lines in the end, see `Ledger.keep`

Each line is on the disk before the next task counts as finished, so that a kill or a power cut at
any instant loses at most the one that was being written; the next line takes its place. A line that
cannot be read, or whose checksum is not its own, is no result: its task is done again. Lines of
other settings are never mixed in: results would then be those of no study at all.
"""

from __future__ import annotations

import json
import os
import sys
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from bodyschema.atomic import found_again, new_file, new_folder
from bodyschema.atomic.manifest import (
    MANIFEST,
    content_hash,
    file_hash,
    manifest_text,
    read_manifest,
)
from bodyschema.atomic.places import kind_of, unwritable
from bodyschema.errors import InputError
from bodyschema.studies.study import Result

HEAD, LINES = "study.json", "tasks.jsonl"

KEPT = ("summary.json", "figure.png", "figure.svg")
"""Files that are made of the results."""


@dataclass(frozen=True)
class Lines:
    """What tasks.jsonl holds."""

    results: dict[str, Result]
    """By key."""
    damaged: int
    """Lines that cannot be read; a last one that was cut off is not counted."""


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
            overwrite: replace an earlier study in the folder, in one step, by one without results.

        Raises:
            InputError: the folder holds another study or something else, or cannot be written.
        """
        found_again(folder)
        ledger = cls(folder)
        known = ledger._head()
        if known is not None and not overwrite:
            ledger._refuse_other(known, head)
            return ledger
        try:
            with new_folder(folder, overwrite, is_earlier, growing=(LINES,)) as fresh:
                text = json.dumps(head, indent=2) + "\n"
                (fresh / HEAD).write_text(text, encoding="utf-8")
        except InputError:
            # Another run may have begun the same study meanwhile.
            if overwrite or ledger._head() != head:
                raise
        return ledger

    def read(self) -> Lines:
        """All lines that are whole, and how many are damaged; writes nothing."""
        path = self.folder / LINES
        content = path.read_bytes() if kind_of(path) == "a file" else b""
        *whole, _ = content.split(b"\n")
        found = [_entry(line) for line in whole if line.strip()]
        return Lines(dict(filter(None, found)), sum(entry is None for entry in found))

    def finished(self) -> dict[str, Result]:
        """Results by key."""
        return self.read().results

    def add(self, key: str, result: Result) -> None:
        """Remember a finished task; it is on the disk when this returns.

        Raises:
            InputError: the disk is full, or the file cannot be written.
        """
        path = self.folder / LINES
        kind = kind_of(path)
        if kind not in ("", "a file"):
            raise InputError(f"'{path}' is {kind}; move it away.")
        flags = os.O_RDWR | os.O_APPEND | os.O_CREAT
        flags |= getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0)
        try:
            with open(os.open(path, flags, 0o666), "r+b", buffering=0) as file:
                _lock(file)
                _drop_cut_line(file)
                _write_all(file, _line(key, result))
                os.fsync(file.fileno())
        except OSError as error:
            raise unwritable(path, error) from None

    def keep(self, files: Mapping[str, bytes]) -> None:
        """Write what was made of all results beside them, each file whole or not at all.

        Args:
            files: content by name; those of an earlier call are replaced.

        Raises:
            InputError: a file of such a name is not what an earlier call wrote.
        """
        known = self._kept()
        self._refuse_changed(known, files)
        # Listed before they are written: killed in between, what is there still is known as ours.
        for name, content in files.items():
            place = self.folder / name
            there = {file_hash(place)} if place.is_file() else set()
            known[name] = sorted({content_hash(content), *there})
        self._write(MANIFEST, manifest_text(known).encode())
        for name, content in files.items():
            self._write(name, content)

    def _write(self, name: str, content: bytes) -> None:
        with new_file(self.folder / name) as fresh:
            fresh.write_bytes(content)

    def _kept(self) -> dict[str, list[str]]:
        """Hashes by name; in folders of earlier versions, what is there."""
        known = read_manifest(self.folder)
        if known is not None:
            return known
        there = [name for name in (HEAD, *KEPT) if (self.folder / name).is_file()]
        return {LINES: [], **{name: [file_hash(self.folder / name)] for name in there}}

    def _refuse_other(self, known: Mapping[str, Any], head: Mapping[str, Any]) -> None:
        """Refuse to go on in the folder of a study with other settings, or with changed files."""
        if known != head:
            raise InputError(
                f"'{self.folder}' was begun with {_difference(known, head)}; name another folder "
                "with --out, or pass --overwrite to begin anew."
            )
        self._refuse_changed(self._kept(), {})

    def _refuse_changed(self, known: Mapping[str, list[str]], files: Mapping[str, bytes]) -> None:
        for name in dict.fromkeys((*KEPT, *files)):
            place = self.folder / name
            kind = kind_of(place)
            if kind and (kind != "a file" or file_hash(place) not in known.get(name, [])):
                raise InputError(
                    f"'{place}' is not what this study wrote there, and would be replaced; move "
                    "it away, or name another folder with --out."
                )

    def _head(self) -> dict[str, Any] | None:
        path = self.folder / HEAD
        try:
            return dict(json.loads(path.read_text(encoding="utf-8"))) if path.is_file() else None
        except (OSError, ValueError, TypeError, RecursionError):
            raise InputError(
                f"'{path}' cannot be read as the settings of a study; name another folder."
            ) from None


def is_earlier(folder: Path) -> bool:
    """Whether a folder is a study of a version that did not list its files, and no more."""
    try:
        with os.scandir(folder) as found:
            ours = all(
                entry.is_file(follow_symlinks=False) and entry.name in (HEAD, LINES, *KEPT)
                for entry in found
            )
        head = json.loads((folder / HEAD).read_text(encoding="utf-8")) if ours else {}
        return {"paper", "figure", "version"} <= {*head}
    except (OSError, ValueError, TypeError, RecursionError):
        return False


def _line(key: str, result: Result) -> bytes:
    body = json.dumps({"key": key, "result": result}, allow_nan=False)
    return f'{body[:-1]}, "crc": {zlib.crc32(body.encode())}}}\n'.encode()


def _entry(line: bytes) -> tuple[str, Result] | None:
    """Key and result of a line; None if it is not what was written."""
    try:
        entry = json.loads(line)
        key, result = entry["key"], entry["result"]
    except (ValueError, KeyError, TypeError, RecursionError):
        return None
    if not isinstance(key, str) or not isinstance(result, dict):
        return None
    # Earlier versions wrote no checksum.
    whole = "crc" not in entry or line.rstrip(b"\r") == _line(key, result).rstrip(b"\n")
    return (key, result) if whole else None


def _lock(file: BinaryIO) -> None:
    """Let no other run append meanwhile, where the system has locks."""
    if sys.platform != "win32":
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX)


def _drop_cut_line(file: BinaryIO) -> None:
    """Cut off what a killed run left after the last whole line: one call, nothing is rewritten."""
    size = file.seek(0, os.SEEK_END)
    end, tail = size, b""
    while end > 0 and b"\n" not in tail:
        start = max(0, end - 4096)
        file.seek(start)
        tail, end = file.read(end - start), start
    whole = end + tail.rfind(b"\n") + 1
    if whole < size:
        file.truncate(whole)


def _write_all(file: BinaryIO, line: bytes) -> None:
    while line:
        line = line[file.write(line) :]


def _difference(known: Mapping[str, Any], head: Mapping[str, Any]) -> str:
    """The settings that differ, in words."""
    pairs = [
        f"{key} = {known.get(key)!r} (now {head.get(key)!r})"
        for key in dict.fromkeys([*known, *head])
        if known.get(key) != head.get(key)
    ]
    return ", ".join(pairs)
