"""How the command ends: with a code that tells what happened, and never with a page of code."""

from __future__ import annotations

import errno
import os
import sys
import traceback
from collections.abc import Callable

from bodyschema.cli.process import Terminated

UNUSABLE, FAULT, INTERRUPTED, UNREAD, TERMINATED = 2, 70, 130, 141, 143
"""Exit codes; those from 128 on are of a signal, as shells count them."""


def ended(work: Callable[[], int], whole: bool) -> int:
    """Do the work and return the exit code of the command.

    Args:
        work: that returns a code.
        whole: whether the process is the command's own; otherwise what is unforeseen is raised.
    """
    try:
        try:
            return work()
        finally:
            sys.stdout.flush()
    except BrokenPipeError:
        # The reader (`head`, `less`) has gone; there is nobody left to tell.
        _drop_output()
        return UNREAD
    except SystemExit as error:
        # So rich ends when it finds the reader gone.
        if isinstance(error.__context__, BrokenPipeError):
            return UNREAD
        raise
    except KeyboardInterrupt:
        return _stopped("Ctrl-C", INTERRUPTED)
    except Terminated:
        return _stopped("SIGTERM", TERMINATED)
    except MemoryError:
        return _told("there is not enough memory for this; give fewer or smaller inputs.")
    except OSError as error:
        if error.filename is None and error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EIO):
            _drop_output()
        return _told(_words(error))
    except Exception:
        if not whole:
            raise
        traceback.print_exc()
        _told("this is a fault of bodyschema. Please report it with the lines above.")
        return FAULT


def _words(error: OSError) -> str:
    reason = error.strerror or str(error)
    if error.filename is None:
        return f"standard output cannot be written ({reason})." if error.errno else f"{reason}."
    return f"cannot use {os.fsdecode(error.filename)} ({reason})."


def _told(sentence: str) -> int:
    print(f"bodyschema: {sentence}", file=sys.stderr)
    return UNUSABLE


def _stopped(by: str, code: int) -> int:
    _told(f"stopped by {by}.")
    return code


def _drop_output() -> None:
    """Let what is left in the buffer go nowhere, else Python fails on it once more at its end."""
    try:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (OSError, ValueError):
        return
