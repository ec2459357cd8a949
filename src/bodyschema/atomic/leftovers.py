"""Names for what is being written, and what becomes of it when its writer was killed.

    .NAME.bodyschema-1a2b3c4d.new    a folder that is being written, or an old one on its way out
    .NAME.bodyschema-1a2b3c4d.old    an earlier result, where it cannot be swapped in one step
    .NAME.bodyschema-1a2b3c4d.csv    a file that is being written; its own suffix

A writer holds a lock on what it writes, which the system drops when it dies, however it dies. What
has such a name and no lock is left over: the next run of the same name puts an old result back
whose place is empty, and clears the rest away. Where there are no such locks (Windows, folders on
NFS) nothing is cleared away.
"""

from __future__ import annotations

import hashlib
import os
import re
import secrets
import shutil
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from bodyschema.atomic.manifest import MANIFEST, read_manifest, strangers

NEW, OLD = ".new", ".old"

SIGN = ".bodyschema-"
"""Part of each such name."""

OURS = re.compile(rf"\..+{re.escape(SIGN)}[0-9a-f]{{8}}(\..*)?", re.DOTALL)
"""Any such name."""

LONGEST = 80
"""Bytes of a name that are kept in the names made from it: 255 is what most disks take."""

EARLIER = r"[a-z0-9_]{8}\.old"
"""How versions up to 0.1 named a result that they were about to replace."""


def aside(target: Path, suffix: str) -> Path:
    """A new name beside a path for what is being written or replaced there."""
    return target.with_name(f".{_stem(target)}{SIGN}{secrets.token_hex(4)}{suffix}")


@contextmanager
def temporary_folder(target: Path) -> Iterator[Path]:
    """A locked empty folder beside `target`; what is under its name at the end is discarded."""
    while True:
        path = aside(target, NEW)
        os.mkdir(path)
        handle = _locked(path, wait=True)
        if path.is_dir():  # nobody took it for left over before it was locked
            break
        _release(handle)
    try:
        yield path
    finally:
        discard(path)
        _release(handle)


@contextmanager
def temporary_file(target: Path) -> Iterator[Path]:
    """A locked empty file beside `target` with its suffix, which is gone at the end."""
    while True:
        path = aside(target, target.suffix)
        os.close(os.open(path, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        handle = _locked(path, wait=True)
        if path.is_file():
            break
        _release(handle)
    try:
        yield path
    finally:
        path.unlink(missing_ok=True)
        _release(handle)


@contextmanager
def held(path: Path) -> Iterator[None]:
    """Hold the lock of something that is being moved."""
    handle = _locked(path, wait=True)
    try:
        yield
    finally:
        _release(handle)


def found_again(target: Path) -> bool:
    """Put back an earlier result whose writer was killed between taking it away and replacing it.

    Args:
        target: where it was; left alone if anything is there.

    Returns:
        Whether it was put back.
    """
    if os.path.lexists(target):
        return False
    old = [p for p, end in _beside(target, f"|{EARLIER}") if end.endswith(OLD) and p.is_dir()]
    for path in sorted(old, key=os.path.getmtime, reverse=True):
        with _unheld(path) as free, suppress(OSError):
            if free and not os.path.lexists(target):
                path.rename(target)
                return True
    return False


def tidy(target: Path) -> None:
    """Clear away what killed writers of the same name left, after putting back what they took."""
    found_again(target)
    for path, _ in _beside(target):
        with _unheld(path) as free:
            if free:
                discard(path)


def tidy_within(folder: Path) -> None:
    """Clear away what killed writers left inside a result, of whatever name."""
    for name in os.listdir(folder):
        if OURS.fullmatch(name):
            with _unheld(folder / name) as free:
                if free:
                    discard(folder / name)


def discard(path: Path) -> None:
    """Remove a file or folder with a name of ours; not one that holds what we did not write."""
    if not path.is_dir():
        with suppress(OSError):
            path.unlink(missing_ok=True)
        return
    with suppress(OSError):
        if path.suffix == OLD:  # half removed it must not be put back
            path = path.rename(path.with_suffix(NEW))
        if read_manifest(path) is None:
            shutil.rmtree(path, ignore_errors=True)
        elif not any(strangers(path)):
            for name in sorted(os.listdir(path), key=MANIFEST.__eq__):  # the list last
                (path / name).unlink()
            path.rmdir()


def _beside(target: Path, more: str = "") -> Iterator[tuple[Path, str]]:
    """What has a name of ours made from that of `target`, and how the name ends."""
    ours = re.compile(rf"\.{re.escape(_stem(target))}\.(bodyschema-[0-9a-f]{{8}}(?:\..*)?{more})")
    with suppress(OSError, ValueError):
        for name in sorted(os.listdir(target.parent)):
            match = ours.fullmatch(name)
            if match:
                yield target.parent / name, match[1]


def _stem(target: Path) -> str:
    """The name, or what stands for a long one."""
    name = os.fsencode(target.name)
    if len(name) <= LONGEST:
        return target.name
    return target.name[: LONGEST // 4] + "~" + hashlib.sha256(name).hexdigest()[:12]


def _locked(path: Path, wait: bool = False) -> int | None:
    """A handle that holds the lock; None if another has it, or there are no locks."""
    if sys.platform == "win32":
        return None
    import fcntl

    try:
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC)
    except OSError:
        return None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except OSError:
        os.close(handle)
        return None
    return handle


def _release(handle: int | None) -> None:
    if handle is not None:
        os.close(handle)


@contextmanager
def _unheld(path: Path) -> Iterator[bool]:
    """Whether nobody holds the lock of a path; it is held meanwhile."""
    handle = _locked(path)
    try:
        yield handle is not None
    finally:
        _release(handle)
