"""Two names that change places in one step, where the system can (Linux: renameat2)."""

from __future__ import annotations

import errno
import os
import sys
from pathlib import Path

EXCHANGE = 2
"""RENAME_EXCHANGE of linux/fs.h."""

HERE = -100
"""AT_FDCWD of fcntl.h."""

UNABLE = (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP, errno.EPERM)
"""Errors of systems and disks that cannot."""


def swapped(one: Path, other: Path) -> bool:
    """Let two paths of one disk change places; False, and nothing done, where that cannot be.

    Raises:
        OSError: one is not there, or may not be renamed.
    """
    if sys.platform != "linux":
        return False
    import ctypes

    rename = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if rename is None:
        return False
    if rename(HERE, os.fsencode(one), HERE, os.fsencode(other), EXCHANGE) == 0:
        return True
    number = ctypes.get_errno()
    if number in UNABLE:
        return False
    raise OSError(number, os.strerror(number), str(one), None, str(other))
