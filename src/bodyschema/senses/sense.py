"""What every sense has in common: times, joint positions, who looks at whom, noise, residuals.

An `Sense` object holds any number of samples of one sense in one batch; one sample is a
batch of one. A sense adds what was seen, the residual (seen minus predicted) and its derivatives.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema.errors import InputError
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Linearized:
    """A residual and its derivatives at one parameter vector."""

    residual: Array
    """(n, dimension) seen minus predicted."""
    by_parameter: Array
    """(n, dimension, n_parameters) derivative of the residual."""
    by_joint: Array
    """(n, dimension, n_joints) derivative of the residual with respect to the readings q."""


@dataclass(frozen=True)
class Sense:
    """Samples of one sense: frame `seen`, looked at from frame `seen_from`."""

    time: Array
    """(n,) s; rows of one moment share it."""
    q: Array
    """(n, n_joints) encoder readings in the order of `body.joints`."""
    seen_from: str
    seen: str
    covariance: Array
    """(dimension, dimension) believed noise; learners that estimate noise keep only its shape."""
    rows: Ints
    """(n,) row of each sample in its recording, for messages."""

    def __len__(self) -> int:
        return len(self.time)

    @property
    def label(self) -> str:
        """Name for messages and reports."""
        return f"{self.seen} seen from {self.seen_from}"

    @property
    def components(self) -> tuple[tuple[str, str, slice], ...]:
        """(name, unit, rows of the residual) of each part that has a noise level of its own."""
        raise NotImplementedError

    def residual(self, body: Body) -> Array:
        """Seen minus predicted, (n, dimension)."""
        raise NotImplementedError

    def imagined(self, body: Body, q: ArrayLike) -> Self:
        """What this sense would see of a body without noise at postures q, (n, n_joints)."""
        raise NotImplementedError

    def linearize(self, reference: Body, variables: Variables, x: Array) -> Linearized:
        """Residual and derivatives for the body that deviates from the reference by x."""
        raise NotImplementedError

    def take(self, rows: Sequence[int] | NDArray[Any]) -> Self:
        """Some of the samples, by index or mask."""
        chosen: dict[str, Any] = {name: getattr(self, name)[rows] for name in self.arrays}
        return replace(self, **chosen)

    @property
    def arrays(self) -> tuple[str, ...]:
        """Names of the fields that have one row a sample."""
        shared = ("seen_from", "seen", "covariance")
        return tuple(field.name for field in fields(self) if field.name not in shared)


def concatenate(parts: Sequence[Sense]) -> Sense:
    """One batch of several batches of the same sense, seen from and of the same frames.

    Raises:
        InputError: they differ in sense or frames.
    """
    first = parts[0]
    for part in parts[1:]:
        if (type(part), part.seen_from, part.seen) != (type(first), first.seen_from, first.seen):
            raise InputError(
                f"{type(part).__name__} of {part.label} and {type(first).__name__} of "
                f"{first.label} are not one batch; keep them apart."
            )
    joined: dict[str, Any] = {
        name: np.concatenate([getattr(part, name) for part in parts]) for name in first.arrays
    }
    return replace(first, **joined)


def counted(
    q: ArrayLike, time: ArrayLike | None, rows: ArrayLike | None
) -> tuple[Array, Array, Ints]:
    """Readings (n, n_joints), times and row numbers (n,); the latter count from 0 when None."""
    readings = np.atleast_2d(np.asarray(q, dtype=np.float64))
    count = np.arange(len(readings))
    return (
        readings,
        np.asarray(count if time is None else time, dtype=np.float64),
        np.asarray(count if rows is None else rows, dtype=np.int64),
    )


def check_samples(observations: Sense, seen: Array, shape: tuple[int, ...]) -> None:
    """Refuse arrays that do not belong together or are not finite.

    Raises:
        InputError: wrong shape, or a value that is not finite, with the row.
    """
    n = len(observations.time)
    parts = {
        "time": (observations.time, (n,)),
        "q": (observations.q, (n, -1)),
        "seen": (seen, (n, *shape)),
    }
    for name, (array, expected) in parts.items():
        fits = array.ndim == len(expected) and all(
            want in (-1, have) for want, have in zip(expected, array.shape, strict=True)
        )
        if not fits:
            raise InputError(
                f"{observations.label}: {name} should have shape {expected}, it has {array.shape}."
            )
        bad = ~np.isfinite(array).all(axis=tuple(range(1, array.ndim)))
        if bad.any():
            row = observations.rows[np.flatnonzero(bad)[0]]
            raise InputError(
                f"{observations.label}: {name} is not a finite number in row {row}; "
                f"drop the {int(bad.sum())} bad rows or repair them."
            )
