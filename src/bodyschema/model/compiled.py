"""How the house compiles its loops with Numba."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

F = TypeVar("F", bound=Callable[..., Any])


def kernel(function: F) -> F:
    """Compile once, cache on disk, and let other Python threads run meanwhile."""
    return cast(F, njit(cache=True, nogil=True, error_model="numpy")(function))


def inlined(function: F) -> F:
    """The same, as a part of its caller: tuples as arguments then stay in registers."""
    return cast(F, njit(cache=True, nogil=True, error_model="numpy", forceinline=True)(function))
