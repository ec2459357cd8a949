"""Where results may go: plain names in folders that may be written, and nothing that is in use."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from bodyschema.errors import InputError

KINDS = {
    stat.S_IFDIR: "a folder",
    stat.S_IFREG: "a file",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
}

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Errors of a disk, a quota or a limit that is full."""


def place_of(path: Path) -> Path:
    """The absolute path; links in the folders above are followed.

    Raises:
        InputError: it is a link itself, or no path of this system.
    """
    try:
        link = os.readlink(path) if path.is_symlink() else ""
    except (OSError, ValueError) as error:
        raise unwritable(path, error) from None
    if link:
        raise InputError(
            f"'{path}' is a link to '{link}', and links are never written through; name the "
            "place itself."
        )
    return resolved(path) if path.name in ("", "..") else resolved(path.parent) / path.name


def resolved(path: Path) -> Path:
    """The absolute path with all links followed.

    Raises:
        InputError: it is no path of this system.
    """
    try:
        return path.resolve()
    except (OSError, ValueError, RuntimeError) as error:
        raise unwritable(path, error) from None


def kind_of(path: Path) -> str:
    """What is there, in words; empty when nothing is.

    Raises:
        InputError: it cannot be looked at.
    """
    try:
        return KINDS.get(stat.S_IFMT(os.lstat(path).st_mode), "no plain file")
    except (FileNotFoundError, NotADirectoryError):
        return ""
    except (OSError, ValueError) as error:
        raise unwritable(path, error) from None


def refuse_in_use(target: Path) -> None:
    """Refuse a folder that somebody stands in, lives in or mounted; absolute.

    Raises:
        InputError: in one sentence.
    """
    for words, place in _in_use():
        if target == place or target in place.parents:
            verb = "is" if target == place else "holds"
            raise InputError(
                f"'{target}' {verb} {words}, and is never replaced; name a new folder, as in "
                f"'{target / 'results'}'."
            )
    if os.path.ismount(target):
        raise InputError(
            f"'{target}' is where a disk is mounted, and is never replaced; name a new folder, "
            f"as in '{target / 'results'}'."
        )


def refuse_unwritable(target: Path) -> None:
    """Refuse a place in which nothing can be made; writes nothing.

    Raises:
        InputError: in one sentence.
    """
    try:
        above = next(folder for folder in target.parents if folder.exists())
    except (OSError, ValueError) as error:
        raise unwritable(target.parent, error) from None
    if not above.is_dir():
        raise unwritable(above, NotADirectoryError(errno.ENOTDIR, "it is no folder"))
    for place in (above, *([target] if target.exists() else [])):
        if not os.access(place, os.W_OK | (os.X_OK if place.is_dir() else 0)):
            raise unwritable(place, PermissionError(errno.EACCES, "Permission denied"))


def unwritable(place: Path, error: Exception) -> InputError:
    """One sentence on a place that cannot be written."""
    reason = getattr(error, "strerror", None) or str(error)
    if getattr(error, "errno", None) in FULL:
        todo = "what was there is as it was. Make room, or name a place on another disk."
        return InputError(f"cannot write to '{place}' ({reason}); {todo}")
    return InputError(f"cannot write to '{place}' ({reason}); choose a folder that you may write.")


@contextmanager
def told(folder: Path, sign: str) -> Iterator[None]:
    """Errors in writing as one sentence on `folder`; those of other files are let through.

    Args:
        folder: that is written into.
        sign: part of the names of what is being written.
    """
    try:
        yield
    except OSError as error:
        ours = any(sign in str(name) for name in (error.filename, error.filename2))
        if ours or error.errno in (*FULL, errno.EROFS):
            raise unwritable(folder, error) from None
        raise


def make_folder(folder: Path) -> None:
    """Make a folder with those above it.

    Raises:
        InputError: it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise unwritable(folder, error) from None


def _in_use() -> Iterator[tuple[str, Path]]:
    # The current directory may be gone, and a user may have no home.
    with suppress(OSError):
        yield "the current directory", Path.cwd().resolve()
    with suppress(OSError, RuntimeError):
        yield "the home folder", Path.home().resolve()
