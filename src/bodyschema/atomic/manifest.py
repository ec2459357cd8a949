"""What was written into a folder: names and hashes, so that nothing else is ever replaced.

    .bodyschema.json    {"written_by": "bodyschema", "files": {"robot.urdf": ["<SHA-256>"], ...}}

Files of folders inside have their path from the folder, with slashes. A file is ours while its
content has one of its hashes; one without hashes grows (a ledger). What a folder of an earlier
version holds, from before there was this list, is for its reader to judge.
"""

from __future__ import annotations

import hashlib
import json
import os
import stat
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from pathlib import Path, PurePosixPath

from bodyschema.errors import InputError

MANIFEST = ".bodyschema.json"

SHOWN = 3
"""Names in a sentence; of more only the number."""

Manifest = dict[str, list[str]]
Earlier = Callable[[Path], bool]
"""Whether a folder without a list holds what an earlier version wrote, and nothing else."""


def never(_: Path) -> bool:
    """No earlier version wrote such a folder."""
    return False


def listed(folder: Path, growing: Collection[str] = ()) -> Manifest:
    """The list for a folder as it is, with the names of files that will grow."""
    names = sorted({name for name, path in entries(folder) if path.is_file()} | {*growing})
    return {name: [] if name in growing else [file_hash(folder / name)] for name in names}


def manifest_text(files: Mapping[str, Sequence[str]]) -> str:
    """Content of the list."""
    return json.dumps({"written_by": "bodyschema", "files": files}, indent=1) + "\n"


def read_manifest(folder: Path) -> Manifest | None:
    """The list of a folder; None if it has none that can be read."""
    path = folder / MANIFEST
    try:
        if not path.is_file():
            return None
        files = json.loads(path.read_text(encoding="utf-8"))["files"]
        return {str(name): [str(one) for one in hashes] for name, hashes in files.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None


def content_hash(content: bytes) -> str:
    """SHA-256 of the content of a file, in hexadecimal."""
    return hashlib.sha256(content).hexdigest()


def file_hash(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def strangers(folder: Path, earlier: Earlier = never) -> tuple[list[str], list[str]]:
    """Names in a folder that were not written by us, and of ours that were changed since.

    Args:
        folder: that is there.
        earlier: knows the folders of earlier versions.
    """
    files = read_manifest(folder)
    if files is None:
        return ([] if earlier(folder) else sorted(os.listdir(folder))), []
    ours = {parent.as_posix() for name in files for parent in PurePosixPath(name).parents}
    foreign, changed = [], []
    for name, path in entries(folder):
        hashes = files.get(name)
        if path.is_dir() and not path.is_symlink():
            foreign += [] if name in ours else [name]
        elif not is_plain(path) or (hashes is None and name != MANIFEST):
            foreign.append(name)
        elif hashes and file_hash(path) not in hashes:
            changed.append(name)
    return foreign, changed


def entries(folder: Path) -> Iterator[tuple[str, Path]]:
    """All that is in a folder and in folders inside, links not followed, in order: path from it."""
    for path in sorted(folder.iterdir()):
        yield path.name, path
        if path.is_dir() and not path.is_symlink():
            yield from ((f"{path.name}/{name}", inner) for name, inner in entries(path))


def is_plain(path: Path) -> bool:
    """Whether it is a file itself, neither link nor device."""
    return stat.S_ISREG(path.lstat().st_mode)


def refuse_strangers(folder: Path, earlier: Earlier = never) -> None:
    """Refuse to replace a folder that holds anything but what was written by us.

    Raises:
        InputError: naming what it holds.
    """
    foreign, changed = strangers(folder, earlier)
    if foreign:
        whose = "bodyschema did not write" if read_manifest(folder) else "is no result"
        raise InputError(
            f"'{folder}' holds {_named(foreign)}, which {whose}; --overwrite will not remove it: "
            "move it away, or name another folder."
        )
    if changed:
        raise InputError(
            f"in '{folder}' {_named(changed)} was changed since bodyschema wrote it; --overwrite "
            "will not remove it: move it away, or name another folder."
        )


def _named(names: Sequence[str]) -> str:
    shown = ", ".join(f"'{name}'" for name in names[:SHOWN])
    return shown + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")
