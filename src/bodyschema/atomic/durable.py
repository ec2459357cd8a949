"""Contents on the disk before names, so that a power cut leaves the old or the new, never empty."""

from __future__ import annotations

import os
import sys
from contextlib import suppress
from pathlib import Path


def sync_file(path: Path) -> None:
    """Wait until the disk has the content of a file."""
    _sync(path, os.O_RDWR | getattr(os, "O_BINARY", 0))


def sync_folder(path: Path) -> None:
    """Wait until the disk has the names in a folder, where the system can be asked for that."""
    if sys.platform != "win32":
        with suppress(OSError):
            _sync(path, os.O_RDONLY)


def _sync(path: Path, flags: int) -> None:
    handle = os.open(path, flags)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
