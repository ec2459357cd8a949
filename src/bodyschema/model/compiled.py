"""How the house compiles its loops with Numba, and keeps what was compiled.

What is compiled is kept where NUMBA_CACHE_DIR says, or beside the source, or in the user's cache
folder. Where none of them can be written (a read-only container, a user without a home) loops are
compiled without being kept, and this is said once. A cache that is damaged or has no room left
costs time, never the answer.

Numba compiles a loop at its first call. That it begins is logged under the name `bodyschema`, at
level INFO, or WARNING where nothing can be kept.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar, cast

from numba import njit
from numba.core.caching import FunctionCache, NullCache

F = TypeVar("F", bound=Callable[..., Any])

LOG = logging.getLogger("bodyschema")

SECONDS = 5
"""That the kinematics take to compile on a laptop of 2020; told before it begins."""


SETTINGS: dict[str, Any] = {"nogil": True, "error_model": "numpy", "no_cfunc_wrapper": True}
"""Nothing calls these loops through a C pointer; a wrapper for that takes a tenth of the time."""


def kernel(function: F) -> F:
    """Compile once, cache on disk, and let other Python threads run meanwhile."""
    return _compiled(function)


def step(function: F) -> F:
    """The same for a step of other loops, which Python itself never calls: quicker to compile."""
    return _compiled(function, no_cpython_wrapper=True)


def inlined(function: F) -> F:
    """A step that becomes a part of its caller: tuples as arguments then stay in registers."""
    return _compiled(function, no_cpython_wrapper=True, forceinline=True)


def _compiled(function: F, **options: Any) -> F:
    dispatcher = njit(**SETTINGS, **options)(function)
    if hasattr(dispatcher, "_cache"):  # with NUMBA_DISABLE_JIT it is the function itself
        dispatcher._cache = _cache(function)
    return cast(F, dispatcher)


def _cache(function: Callable[..., Any]) -> Kept | Unkept:
    try:
        return Kept(function)
    except (RuntimeError, OSError):  # Numba has found no folder that it could write
        return Unkept()


@dataclass
class Compiling:
    """What this process has compiled itself, rather than read from the cache."""

    seconds: float = 0.0
    """On the clock, so far."""
    folder: str | None = None
    """Where it is kept; None before the first loop, or where there is no such place."""
    told: bool = False
    """Whether it has been logged."""
    depth: int = 0
    """How many loops are under way: the compiler compiles the steps of a loop on the way."""
    since: float = 0.0
    """When the outermost of them began."""

    def begin(self, keeps: bool) -> None:
        """Called before a loop is compiled; says so the first time."""
        if not self.told:
            self.told = True
            if keeps:
                LOG.info("Compiling for this machine (once, about %d s) ...", SECONDS)
            else:
                LOG.warning(
                    "Compiling for this machine (about %d s at each start, as no folder can be "
                    "written to keep it in; set NUMBA_CACHE_DIR to one that can) ...",
                    SECONDS,
                )
        if self.depth == 0:
            self.since = time.perf_counter()
        self.depth += 1

    def end(self, folder: str | None) -> None:
        """Called when it is compiled, and kept if it can be."""
        self.depth -= 1
        self.folder = folder
        if self.depth == 0:
            self.seconds += time.perf_counter() - self.since


COMPILING = Compiling()
"""Of this process; Numba's own lock lets one thread at a time compile."""


class Kept(FunctionCache):
    """Numba's cache on disk; whatever is wrong with its files, the loop is compiled anew."""

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """A loop as it was kept, or None."""
        found = None
        try:
            found = super().load_overload(sig, target_context)
        except Exception:  # unpickling a damaged file may raise anything
            self._forget()
        if found is None:
            COMPILING.begin(True)
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a loop if there is room."""
        folder = None
        try:
            super().save_overload(sig, data)
            folder = str(self.cache_path)
        except Exception as error:  # no room, no rights any more, a damaged index
            LOG.debug("cannot keep %s: %s", self._name, error)
        finally:
            COMPILING.end(folder)

    def _forget(self) -> None:
        """Write an empty index in the place of a damaged one."""
        try:
            self.flush()
        except OSError as error:
            LOG.debug("cannot renew the cache of %s: %s", self._name, error)


class Unkept(NullCache):
    """No place for a cache: every process compiles for itself."""

    def load_overload(self, sig: Any, target_context: Any) -> None:
        """Nothing was kept."""
        COMPILING.begin(False)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Nothing is kept."""
        COMPILING.end(None)
