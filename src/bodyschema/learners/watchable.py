"""What a learner must offer so that a monitor can watch over it.

A monitor needs no more than white innovations with their slope, the belief's covariance, and the
art of starting again with one block forgotten. The linear relation, a recursive filter or a pool of
hypotheses can all offer that; see `monitoring.machine`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.certificate import Certificate

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

State = TypeVar("State")
Sample = TypeVar("Sample", contravariant=True)


@dataclass(frozen=True)
class WhiteInnovation:
    """A sample against what the belief predicts, in units of the sensor's noise."""

    e: Array
    """(m,) seen less predicted: unit variance when the belief is exact."""
    J: Array
    """(m, k) slope: parameters that differ by d from the belief add J d to e."""
    source: Ints
    """(m,) which measurement a row belongs to: rows of one source are wild together."""


class Doubt(NamedTuple):
    """How far a belief may be off, and what its residuals look like."""

    covariance: Array
    """(k, k) of the parameters."""
    correlation: float
    """Of white residuals from one sample to the next."""
    level: float
    """Their variance, 1 or more: what the declared noise does not explain is noise too."""
    wild: float
    """Upper estimate of the share of outliers."""


class Watchable(Protocol[State, Sample]):
    """A learner that can be watched."""

    @property
    def blocks(self) -> Mapping[str, Ints]:
        """Parts of the body that may change on their own, and their parameters' places."""
        ...

    def start(self) -> State:
        """Nothing known."""
        ...

    def step(self, state: State, sample: Sample) -> State:
        """Learn from one sample."""
        ...

    def innovation(self, state: State, sample: Sample) -> WhiteInnovation:
        """A sample against a belief that has been certified."""
        ...

    def doubt(self, state: State) -> Doubt:
        """How far the belief may be off."""
        ...

    def difference(self, state: State, earlier: State) -> Array:
        """(k,) the step of the parameters from an earlier belief to this one."""
        ...

    def certificate(self, state: State) -> Certificate:
        """Whether the belief is good enough to stop learning."""
        ...

    def forget(self, state: State, block: str) -> State:
        """A new start with all but one block as prior; "" keeps everything as prior."""
        ...

    def evidence(self, state: State) -> tuple[float, float]:
        """Cost of a belief that started from `forget`, prior included, and the independent
        residuals behind it: about equal when all is well."""
        ...

    def astray(self, state: State) -> bool:
        """Whether a belief that is still being learned contradicts its own samples."""
        ...
