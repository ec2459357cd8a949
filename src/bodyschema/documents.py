"""Files that others wrote, read whole: place, size and form are looked at before the content.

A name may be too long for the system, a place a pipe that never ends, a text of gigabytes, lists in
lists until the stack is used up, a number of five thousand digits. Each is one sentence here, so
that no reader has to think of it.
"""

from __future__ import annotations

import json
import os
import stat
import tomllib
from pathlib import Path
from typing import Any

from bodyschema.errors import InputError, shown

MOST_BYTES = 64 << 20
"""Of a description, a run file or a table of settings; the largest known robots have 1 MB."""

DEEPEST = 64
"""Levels of lists and tables in one another; what is written here has at most ten."""

LARGEST = 2**63
"""Whole numbers from here on fit no array, and TOML has none."""


def is_file(path: Path) -> bool:
    """Whether a regular file is there; no name is too odd to ask."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def is_there(path: Path) -> bool:
    """Whether anything is there; no name is too odd to ask."""
    try:
        return path.exists()
    except (OSError, ValueError):
        return False


def is_folder(path: Path) -> bool:
    """Whether a folder is there that can be looked into; no name is too odd to ask."""
    try:
        return path.is_dir() and os.access(path, os.R_OK | os.X_OK)
    except (OSError, ValueError):
        return False


def regular_file(path: Path, missing: str, most: int = 0) -> Path:
    """The path, if a regular file is there that is not too large.

    Args:
        path: of the file.
        missing: the sentence for a place where there is none.
        most: bytes that it may have; 0 for any number.

    Raises:
        InputError: it is missing, a pipe or device, cannot be looked at, or is too large.
    """
    try:
        found = path.stat()
    except (FileNotFoundError, NotADirectoryError):
        raise InputError(missing) from None
    except OSError as error:
        raise InputError(f"'{_short(path)}' cannot be opened: {error.strerror}.") from None
    except ValueError:
        raise InputError(f"'{_short(path)}' is no name that a file can have.") from None
    if stat.S_ISDIR(found.st_mode):
        raise InputError(missing)
    if not stat.S_ISREG(found.st_mode):
        raise InputError(f"'{path}' is a pipe or a device; write it into a file first.")
    if most and found.st_size > most:
        raise InputError(
            f"'{path}' has {found.st_size / 1e6:.0f} MB, and at most {most / 1e6:.0f} are read."
        )
    return path


def file_bytes(path: Path, missing: str, most: int = MOST_BYTES) -> bytes:
    """What a file holds; see `regular_file`.

    Raises:
        InputError: it cannot be read, in one sentence.
    """
    regular_file(path, missing, most)
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"'{path}' cannot be read: {error.strerror}.") from None


def file_text(path: Path, missing: str, most: int = MOST_BYTES) -> str:
    """The text of a file in UTF-8, without the mark that some editors put before it.

    Raises:
        InputError: it cannot be read, or is in another encoding.
    """
    content = file_bytes(path, missing, most)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"'{path}' is no text in UTF-8 (byte {error.start}); save it in that encoding."
        ) from None


def json_file(path: Path, missing: str, what: str, most: int = MOST_BYTES) -> Any:
    """What a JSON file holds; `what` it should be, for the message.

    Raises:
        InputError: it cannot be read, or holds what no file of ours does; see `refuse_odd`.
    """
    text = file_text(path, missing, most)
    try:
        # NaN and Infinity are no JSON, though many write them.
        return refuse_odd(json.loads(text, parse_constant=_no_number), path)
    except (ValueError, RecursionError) as error:
        raise InputError(f"'{path}' is {what}: {_reason(error)}.") from None


def toml_file(path: Path, missing: str, what: str, most: int = MOST_BYTES) -> dict[str, Any]:
    """What a TOML file holds; `what` it should be, for the message.

    Raises:
        InputError: it cannot be read, or holds what no file of ours does; see `refuse_odd`.
    """
    text = file_text(path, missing, most)
    try:
        table: dict[str, Any] = refuse_odd(tomllib.loads(text), path)
    except (ValueError, RecursionError) as error:
        raise InputError(f"'{path}' is {what}: {_reason(error)}.") from None
    return table


def refuse_odd(document: Any, path: Path) -> Any:
    """The document, unless it is too deep or has numbers or texts that nothing can hold.

    Raises:
        InputError: deeper than `DEEPEST`, a whole number beyond `LARGEST`, or half a character.
    """
    level = [document]
    for _ in range(DEEPEST):
        inner: list[Any] = []
        for value in level:
            if isinstance(value, dict):
                inner += value.keys()
                inner += value.values()
            elif isinstance(value, list):
                inner += value
            elif isinstance(value, int) and abs(value) >= LARGEST:
                raise InputError(f"'{path}' has a whole number of {len(hex(value)) * 4} bits.")
            elif isinstance(value, str) and not (value.isascii() or _whole(value)):
                raise InputError(f"'{path}' has a text with half a character, {value[:40]!a}.")
        level = inner
        if not level:
            return document
    raise InputError(f"'{path}' has lists or tables more than {DEEPEST} deep.")


def printable(document: Any) -> Any:
    """The same for a terminal: in no text or key is an escape or a mark of direction left."""
    if isinstance(document, dict):
        return {printable(key): printable(value) for key, value in document.items()}
    if isinstance(document, list | tuple):
        return [printable(value) for value in document]
    return shown(document) if isinstance(document, str) else document


def _whole(text: str) -> bool:
    """Whether a text can be written: JSON may hold one half of a pair that is one character."""
    return not any("\ud800" <= letter <= "\udfff" for letter in text)


def _no_number(word: str) -> float:
    raise ValueError(f"{word} is no number of JSON")


def _reason(error: Exception) -> str:
    if isinstance(error, RecursionError):
        return f"lists or tables are more than {DEEPEST} deep"
    return str(error).partition("\n")[0].rstrip(".")[:200]


def _short(path: Path) -> str:
    name = str(path)
    return name if len(name) < 200 else f"{name[:80]} ... {name[-40:]}"
