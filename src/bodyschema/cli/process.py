"""The process when it is the command's own: its environment, streams, signals and log.

None of this is done to the process of somebody who imports bodyschema.
"""

from __future__ import annotations

import logging
import os
import signal
import sys
from types import FrameType

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""That BLAS libraries read when they are loaded; worker processes inherit them."""


class Terminated(BaseException):
    """SIGTERM has come; passes through what is under way, so that it clears up behind itself."""


def own_process() -> None:
    """Set what only the owner of a process may set."""
    for variable in THREADS:
        os.environ.setdefault(variable, "1")
    _open_streams()
    signal.signal(signal.SIGTERM, _terminate)
    log = logging.getLogger("bodyschema")
    log.addHandler(logging.StreamHandler(sys.stderr))
    log.setLevel(logging.INFO)
    log.propagate = False
    # It makes do with a temporary folder where it cannot write at home, and need not say so.
    logging.getLogger("matplotlib").setLevel(logging.ERROR)


def said_after() -> None:
    """Say how long it took to compile, if it did and the next call need not."""
    module = sys.modules.get("bodyschema.model.compiled")
    if module is not None and module.COMPILING.folder is not None:
        seconds = module.COMPILING.seconds
        logging.getLogger("bodyschema").info(
            "Compiling took %.1f s; it is kept for the next call.", seconds
        )


def _open_streams() -> None:
    """Streams that take any text, also where the caller has closed them or has no UTF-8."""
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            # Else the next file that is opened would become the standard stream.
            null = os.open(os.devnull, os.O_RDWR)
            if null != number:
                os.dup2(null, number)
                os.close(null)
    if sys.stdin is None:
        sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115
    if sys.stdout is None:
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    if sys.stderr is None:
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        # As in JSON: "\\u0394" for a letter that the stream does not have.
        stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]


def _terminate(number: int, frame: FrameType | None) -> None:
    """Stop the workers, then what is under way here; a second signal changes nothing."""
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    processes = sys.modules.get("multiprocessing")
    if processes is not None:
        for worker in processes.active_children():
            worker.terminate()
    raise Terminated
