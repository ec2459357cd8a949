"""Files and folders that appear whole or not at all: written aside, then renamed."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bodyschema.errors import InputError


@contextmanager
def new_file(path: Path) -> Iterator[Path]:
    """Yield a temporary path beside `path`; rename it to `path` when the block succeeds.

    Raises:
        InputError: the folder cannot be written, or `path` is one.
    """
    target = path.resolve()
    folder = target.parent
    if target.is_dir():
        raise InputError(f"'{path}' is a folder; name a file.")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(prefix=f".{path.name}.", suffix=path.suffix, dir=folder)
    except OSError as error:
        raise _unwritable(folder, error) from None
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o644)
        temporary.replace(target)
    finally:
        temporary.unlink(missing_ok=True)


def check_new_folder(path: Path, overwrite: bool = False) -> None:
    """Refuse a place where `new_folder` would fail, before any work is spent; writes nothing.

    Raises:
        InputError: the place cannot be written, or holds something already.
    """
    target = path.resolve()
    if target.exists() and not target.is_dir():
        raise InputError(f"'{path}' is a file; name a folder for the results.")
    if target.is_dir() and any(target.iterdir()) and not overwrite:
        raise InputError(f"'{path}' is not empty; name another folder or pass --overwrite.")
    above = next(folder for folder in (target, *target.parents) if folder.exists())
    if not above.is_dir():
        raise _unwritable(above, NotADirectoryError(20, "it is a file"))
    if not os.access(above, os.W_OK | os.X_OK):
        raise _unwritable(above, PermissionError(13, "Permission denied"))


@contextmanager
def new_folder(path: Path, overwrite: bool = False) -> Iterator[Path]:
    """Yield a temporary folder beside `path`; rename it to `path` when the block succeeds.

    Args:
        path: where the folder is to appear.
        overwrite: replace what is there; otherwise a folder with anything in it is refused.

    Raises:
        InputError: the place cannot be written, or holds something already.
    """
    check_new_folder(path, overwrite)
    target = path.resolve()
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        temporary = Path(tempfile.mkdtemp(prefix=f".{target.name}.", dir=target.parent))
    except OSError as error:
        raise _unwritable(target.parent, error) from None
    old = temporary.with_name(temporary.name + ".old")
    try:
        yield temporary
        temporary.chmod(0o755)
        _exchange(temporary, target, old)
    finally:
        shutil.rmtree(temporary, ignore_errors=True)
        shutil.rmtree(old, ignore_errors=True)


def _exchange(new: Path, target: Path, old: Path) -> None:
    """Put `new` in the place of `target`, which goes to `old`; if that fails, leave `target`."""
    if target.is_dir():
        target.rename(old)
    try:
        new.rename(target)
    except OSError:
        if old.is_dir():
            old.rename(target)
        raise


def _unwritable(folder: Path, error: OSError) -> InputError:
    reason = error.strerror or str(error)
    return InputError(f"cannot write to '{folder}' ({reason}); choose a folder that you may write.")
