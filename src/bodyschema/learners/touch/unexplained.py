"""What the identified load leaves unexplained: the wrench of anything else on the object.

Each sample w (`KnownLoad.unexplained`) errs by noise, and by what is not known of load, offset,
mounting and gains, of covariance P:

    cov(w) = N + L L^T,     L = J root(P),     root(P) root(P)^T = P.

L changes with the posture, the errors that it multiplies do not.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.touch.known_load import KnownLoad, root_of
from bodyschema.senses.wrench_means import WrenchMeans

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Unexplained:
    """Wrenches on the object by neither sensor nor weight, about the sensor's origin."""

    time: Array
    """(n,) s."""
    wrench: Array
    """(n, 6) N and Nm, along the mount's axes."""
    factor: Array
    """(n, 6, k) L; k may be 0."""

    @classmethod
    def of(cls, means: WrenchMeans, load: KnownLoad) -> Unexplained:
        """What a known load does not explain.

        Args:
            means: of the sensor; `wrench_means.at_moments` makes them of single samples.
            load: what is known.
        """
        wrench, J = load.unexplained(means)
        return cls(means.time, wrench, np.ascontiguousarray(J @ root_of(load.covariance)))

    def __len__(self) -> int:
        return len(self.time)

    @property
    def rate(self) -> float:
        """Samples a second, gaps aside."""
        return 1 / float(np.median(np.diff(self.time))) if len(self) > 1 else np.inf

    def take(self, rows: slice | NDArray[np.bool_]) -> Unexplained:
        """Some of the samples."""
        return Unexplained(self.time[rows], self.wrench[rows], self.factor[rows])

    def moments(self) -> Iterator[tuple[Unexplained]]:
        """The samples one by one, each a batch of one."""
        for i in range(len(self)):
            yield (self.take(slice(i, i + 1)),)
