"""A folder of results that appears whole or not at all, and replaces only an earlier result."""

from __future__ import annotations

import errno
import stat
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path

from bodyschema.atomic.durable import sync_file, sync_folder
from bodyschema.atomic.leftovers import (
    OLD,
    SIGN,
    aside,
    discard,
    found_again,
    held,
    temporary_folder,
    tidy,
    tidy_within,
)
from bodyschema.atomic.manifest import (
    MANIFEST,
    Earlier,
    entries,
    listed,
    manifest_text,
    never,
    read_manifest,
    refuse_strangers,
    strangers,
)
from bodyschema.atomic.places import (
    kind_of,
    make_folder,
    place_of,
    refuse_in_use,
    refuse_unwritable,
    told,
    unwritable,
)
from bodyschema.atomic.swap import swapped
from bodyschema.errors import InputError

TRIES = 5
"""How often a place that others write at the same time is tried."""


def check_new_folder(path: Path, overwrite: bool = False, earlier: Earlier = never) -> None:
    """Refuse a place where `new_folder` would fail, before any work is spent; writes nothing.

    But an earlier result that a killed run took away is put back, and what such a run left in it
    is cleared away.

    Raises:
        InputError: the place cannot be written, or holds something already.
    """
    _place(path, overwrite, earlier)


@contextmanager
def new_folder(
    path: Path, overwrite: bool = False, earlier: Earlier = never, growing: Collection[str] = ()
) -> Iterator[Path]:
    """Yield a temporary folder beside `path`; when the block succeeds, put it in its place.

    The files in it are listed with their hashes, see `manifest`.

    Args:
        path: where the folder is to appear.
        overwrite: replace a folder that holds what was written by us, unchanged; otherwise one
            with anything in it is refused.
        earlier: knows folders of earlier versions, which have no list.
        growing: names of files that will be added to.

    Raises:
        InputError: the place cannot be written, is full, or holds something already.
    """
    target = _place(path, overwrite, earlier)
    make_folder(target.parent)
    with told(target.parent, SIGN):
        tidy(target)
        with temporary_folder(target) as fresh:
            yield fresh
            _seal(fresh, growing)
            _put(fresh, path, overwrite, earlier)


def _place(path: Path, overwrite: bool, earlier: Earlier) -> Path:
    """The absolute path of a folder that may be written."""
    target = place_of(path)
    found_again(target)
    kind = kind_of(target)
    if kind not in ("", "a folder"):
        raise InputError(f"'{path}' is {kind}; name a folder for the results.")
    if kind:
        refuse_in_use(target)
    refuse_unwritable(target)
    try:
        if kind and any(target.iterdir()):
            _refuse_full(path, target, overwrite, earlier)
    except OSError as error:
        raise unwritable(target, error) from None
    return target


def _refuse_full(path: Path, target: Path, overwrite: bool, earlier: Earlier) -> None:
    if not overwrite:
        raise InputError(f"'{path}' is not empty; name another folder or pass --overwrite.")
    if read_manifest(target) is not None:
        tidy_within(target)
    refuse_strangers(target, earlier)


def _seal(fresh: Path, growing: Collection[str]) -> None:
    """List what is in the folder, and wait until the disk has it."""
    (fresh / MANIFEST).write_text(manifest_text(listed(fresh, growing)), encoding="utf-8")
    for _, path in entries(fresh):
        sync_folder(path) if path.is_dir() else sync_file(path)
    sync_folder(fresh)


def _put(fresh: Path, path: Path, overwrite: bool, earlier: Earlier) -> None:
    """Put `fresh` in its place; what was there is then under the name of `fresh`, or gone."""
    for _ in range(TRIES):
        # Again: the work may have taken an hour.
        target = _place(path, overwrite, earlier)
        try:
            if not target.is_dir():
                fresh.rename(target)
            else:
                fresh.chmod(stat.S_IMODE(target.stat().st_mode))
                if not swapped(fresh, target):
                    _replace(fresh, target, earlier)
                elif any(strangers(fresh, earlier)):
                    # Somebody came between the look and the swap: back, and look again.
                    swapped(fresh, target)
                    continue
        except OSError as error:
            if error.errno not in (errno.ENOTEMPTY, errno.EEXIST, errno.ENOENT):
                raise
            continue
        sync_folder(target.parent)
        return
    raise InputError(f"'{path}' is being written by other runs; name another folder.")


def _replace(fresh: Path, target: Path, earlier: Earlier) -> None:
    """In two steps; `found_again` puts the old folder back if this is killed between them."""
    old = aside(target, OLD)
    with held(target):
        target.rename(old)
        try:
            if any(strangers(old, earlier)):
                raise FileExistsError(errno.EEXIST, "somebody came between the look and this")
            fresh.rename(target)
        except OSError:
            old.rename(target)
            raise
        sync_folder(target.parent)
        discard(old)
