"""One file that appears whole or not at all."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bodyschema.atomic.durable import sync_file, sync_folder
from bodyschema.atomic.leftovers import SIGN, temporary_file, tidy
from bodyschema.atomic.manifest import read_manifest
from bodyschema.atomic.places import (
    kind_of,
    make_folder,
    place_of,
    refuse_unwritable,
    told,
)
from bodyschema.errors import InputError

LINKLESS = (errno.EPERM, errno.ENOTSUP, errno.ENOSYS, errno.EMLINK)
"""Errors of disks on which a file cannot have a second name."""


def check_new_file(path: Path, overwrite: bool = False) -> None:
    """Refuse a place where a verb may not write its file, before any work; writes nothing.

    With `overwrite` the one file that was named is replaced, whoever wrote it; what was not named,
    and what belongs to a result, never is.

    Raises:
        InputError: the place cannot be written, or holds something already.
    """
    target = _place(path, overwrite)
    if target.name in (read_manifest(target.parent) or {}):
        raise InputError(
            f"'{path}' belongs to the result in '{target.parent}', which stays as it is; name "
            "another file."
        )


@contextmanager
def new_file(path: Path, overwrite: bool = True) -> Iterator[Path]:
    """Yield a temporary path beside `path`; put it in the place of `path` when the block succeeds.

    Args:
        path: where the file is to appear. A file that it replaces hands on its permissions.
        overwrite: replace a regular file that is there; otherwise it is refused.

    Raises:
        InputError: the folder cannot be written, is full, or `path` is no place for a file.
    """
    target = _place(path, overwrite)
    folder = target.parent
    make_folder(folder)
    with told(folder, SIGN):
        tidy(target)
        with temporary_file(target) as temporary:
            yield temporary
            _put(temporary, _place(path, overwrite), overwrite)
            sync_folder(folder)


def _place(path: Path, overwrite: bool) -> Path:
    """The absolute path of a file that may be written."""
    target = place_of(path)
    kind = kind_of(target)
    if kind not in ("", "a file"):
        raise InputError(f"'{path}' is {kind}; name a file.")
    if kind and not overwrite:
        raise InputError(f"'{path}' exists; name another file or pass --overwrite.")
    refuse_unwritable(target)
    return target


def _put(temporary: Path, target: Path, overwrite: bool) -> None:
    if target.is_file():
        os.chmod(temporary, stat.S_IMODE(target.stat().st_mode))
    sync_file(temporary)
    if not overwrite:
        try:
            os.link(temporary, target)
        except FileExistsError:
            raise InputError(
                f"'{target}' was written by another run meanwhile; name another file."
            ) from None
        except OSError as error:
            if error.errno not in LINKLESS:
                raise
        else:
            return
    os.replace(temporary, target)
