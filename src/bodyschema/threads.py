"""One BLAS thread while small matrices are solved; what the user had set holds again afterwards.

Threads cost more than they bring at the sizes of kinematics, many times over. Their number belongs
to the process, so it is changed only while something is under way here, and not at all where the
user has chosen one in the environment.
"""

from __future__ import annotations

import os
import threading
from contextlib import ContextDecorator, nullcontext
from typing import Any

CHOICES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables by which the user chooses, read by the libraries when they are loaded."""


class OneThread(ContextDecorator):
    """Limits BLAS while the caller is within; for `with`, or above a function.

    Of callers in several threads the first limits for all; when it leaves, the user's number holds
    again for those that stay, which costs them time and nothing else.
    """

    def __init__(self) -> None:
        self._here = threading.local()
        self._controller: Any = None

    def __enter__(self) -> OneThread:
        """Limit, unless this thread has."""
        depth = getattr(self._here, "depth", 0)
        self._here.depth = depth + 1
        if depth == 0:
            self._here.limit = nullcontext() if chosen() else self._one()
            self._here.limit.__enter__()
        return self

    def __exit__(self, *error: object) -> None:
        """Give back what was."""
        self._here.depth -= 1
        if self._here.depth == 0:
            self._here.limit.__exit__(None, None, None)

    def _one(self) -> Any:
        return self._libraries().limit(limits=1, user_api="blas")

    def _libraries(self) -> Any:
        """Found once: that takes a millisecond, to limit them a hundredth of it."""
        if self._controller is None:
            # SciPy brings a library of its own, which must be loaded to be found.
            import scipy.linalg  # noqa: F401
            from threadpoolctl import ThreadpoolController

            self._controller = ThreadpoolController()
        return self._controller


one_thread = OneThread()
"""Of this process."""


def chosen() -> bool:
    """Whether the user has said how many threads BLAS shall have."""
    return any(variable in os.environ for variable in CHOICES)
