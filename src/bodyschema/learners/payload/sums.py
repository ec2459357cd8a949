"""What a wrist sensor's samples say of its load, kept as six small matrices.

With R the rotation from the sensor's axes to those in which its motion is known (the mount), phi
the load and b the bias, each of the six components i of a sample is one linear relation

    a_i^T z_i = 0,   a_i = [y (3), -Y_i (10), -1],   z_i = [R_i, phi, b_i]

where y is the recorded force for the first three components and the torque for the last three, and
R_i the matching row of R. The sums S_i = sum a_i a_i^T (14 x 14) are all that is ever needed: cost,
noise level and derivatives at any R, phi, b are exact on them, and six matrices instead of one
leave every component its own noise level until the end.

Noise that remembers: the same sums over blocks of 2, 4, 8 ... samples in a row, each block added
up before it is squared, tell how much slower than white noise the residuals average out
(Flyvbjerg and Petersen 1989, "Error estimates on averages of correlated data").
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import kernel
from bodyschema.senses.wrench_means import WrenchMeans

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SIZE = 14
"""Entries of a_i."""

LEVELS = 7
"""Blocks of 1, 2, 4 .. 64 samples."""


@dataclass(frozen=True)
class Sums:
    """All samples so far: fixed size, whatever their number."""

    S: Array
    """(LEVELS, 6, 14, 14) sums over the blocks of each length."""
    partial: Array
    """(LEVELS, 6, 14) the unfinished block of each length."""
    blocks: Ints
    """(LEVELS,) finished blocks; the first is the number of samples."""

    @classmethod
    def empty(cls) -> Sums:
        """Of no sample."""
        return cls(
            np.zeros((LEVELS, 6, SIZE, SIZE)),
            np.zeros((LEVELS, 6, SIZE)),
            np.zeros(LEVELS, dtype=np.int64),
        )

    def add(self, samples: WrenchMeans) -> Sums:
        """With more samples, in order of time."""
        S, partial, blocks = self.S.copy(), self.partial.copy(), self.blocks.copy()
        _add(samples.rows, S, partial, blocks)
        return Sums(S, partial, blocks)

    @property
    def count(self) -> int:
        """Number of samples."""
        return int(self.blocks[0])

    def squares(self, z: Array) -> Array:
        """(LEVELS, 6) sums of squared residuals of blocks, for z (6, 14)."""
        return np.asarray(np.einsum("ip,lipq,iq->li", z, self.S, z))


def unknowns(R: Array, phi: Array, bias: Array) -> Array:
    """z (6, 14) of a rotation (3, 3), a load (10,) and a bias (6,) along the mount's axes."""
    z = np.empty((6, SIZE))
    z[:3, :3] = z[3:, :3] = R
    z[:, 3:13] = phi
    z[:, 13] = bias
    return z


@kernel
def _add(rows: Array, S: Array, partial: Array, blocks: Ints) -> None:
    """Add rows (n, 6, 14) one sample after the other; writes into S, partial and blocks."""
    size = rows.shape[2]
    for n in range(rows.shape[0]):
        for level in range(S.shape[0]):
            # A block of this length ends with this sample if 2^level divides their number.
            ends = (blocks[0] + (level > 0)) % (1 << level) == 0 if level else True
            for i in range(6):
                for p in range(size):
                    partial[level, i, p] += rows[n, i, p]
                if ends:
                    for p in range(size):
                        a = partial[level, i, p]
                        for q in range(size):
                            S[level, i, p, q] += a * partial[level, i, q]
                    for p in range(size):
                        partial[level, i, p] = 0.0
            if ends:
                blocks[level] += 1
