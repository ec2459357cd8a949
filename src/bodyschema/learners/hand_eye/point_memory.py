"""What a stream of tracked points leaves behind: four small sums, of fixed size for ever.

    C += A^T A            whitened rows over forty monomials, see `stereo_points`
    N += 3 k_Z k_Z^T / Z_w^2    what pixel noise adds to C on average
    C1 += A_t^T A_(t-1)   of consecutive samples: x^T C1 x / x^T C x is the lag-1 correlation of
                          the residuals at any x, afterwards
    D += A16^T A16        the paper's rows, for a start from nothing

Sums of two stretches add up to the sum of both; multiplied by a number below 1 they forget.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.learners.hand_eye.chart import CameraAndPoints, misfit
from bodyschema.learners.hand_eye.stereo_points import MONOMIALS, depth_row, monomial_rows
from bodyschema.model.kernels import kernel

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]


@kernel
def remember(
    T: Array, pixels: Array, depth: Array, keep: Flags, stereo: Array,
    C: Array, N: Array, C1: Array, D: Array, last: Array, linked: Flags,
) -> int:  # fmt: skip
    """Add moments to the sums, in place; returns the number of points that were added.

    T (n, 4, 4), pixels (n, K, 3), depth (n, K) for the weights, keep (n, K). `last` (K, 3, 40) are
    the rows of the moment before, valid where `linked` (K,).
    """
    A, k_Z, P = np.empty((3, MONOMIALS)), np.empty(MONOMIALS), np.empty((3, 16))
    count = 0
    for n in range(T.shape[0]):
        for k in range(pixels.shape[1]):
            if not keep[n, k]:
                linked[k] = False
                continue
            count += 1
            monomial_rows(T[n], pixels[n, k], depth[n, k], stereo, A)
            for m in range(3):
                for i in range(MONOMIALS):
                    a = A[m, i]
                    if a == 0.0:
                        continue
                    for j in range(MONOMIALS):
                        C[k, i, j] += a * A[m, j]
                    if linked[k]:
                        for j in range(MONOMIALS):
                            C1[k, i, j] += a * last[k, m, j]
            depth_row(T[n], k_Z)
            share = 3.0 / depth[n, k] ** 2
            for i in range(MONOMIALS):
                if k_Z[i] != 0.0:
                    for j in range(MONOMIALS):
                        N[k, i, j] += share * k_Z[i] * k_Z[j]
            plain_rows(T[n], pixels[n, k], stereo, P)
            for m in range(3):
                for i in range(16):
                    if P[m, i] != 0.0:
                        for j in range(16):
                            D[k, i, j] += P[m, i] * P[m, j]
            last[k] = A
            linked[k] = True
    return count


@kernel
def plain_rows(T: Array, pixel: Array, stereo: Array, A: Array) -> None:
    """A of Eq. 34 into (3, 16), the point triangulated from its own pixels."""
    z = stereo[0] * stereo[3] / max(pixel[0] - pixel[2], 1e-6)
    x = (pixel[0] - stereo[1]) / stereo[0] * z
    y = (pixel[1] - stereo[2]) / stereo[0] * z
    A[:] = 0.0
    for i in range(3):
        A[i, i], A[i, 3 + i], A[i, 6 + i], A[i, 9 + i] = x, y, z, 1.0
        for j in range(3):
            A[i, 12 + j] = -T[i, j]
        A[i, 15] = -T[i, 3]


@dataclass(frozen=True)
class PointMemory:
    """The sums, one set a tracked point."""

    C: Array
    """(K, 40, 40)."""
    N: Array
    """(K, 40, 40)."""
    C1: Array
    """(K, 40, 40)."""
    D: Array
    """(K, 16, 16)."""
    last: Array
    """(K, 3, 40) rows of the newest moment."""
    linked: Flags
    """(K,) whether those rows are from the moment just before the next one."""
    count: float = 0.0
    """Points seen, all tracks together; less than whole where some was forgotten."""

    @classmethod
    def empty(cls, points: int) -> PointMemory:
        """Of nothing."""
        square = np.zeros((points, MONOMIALS, MONOMIALS))
        rows = np.zeros((points, 3, MONOMIALS))
        return cls(square, square, square, np.zeros((points, 16, 16)), rows, rows[:, 0, 0] > 0)

    def add(self, T: Array, pixels: Array, depth: Array, keep: Flags, stereo: Array) -> PointMemory:
        """With more moments; arguments as for `remember`."""
        C, N, C1, D = self.C.copy(), self.N.copy(), self.C1.copy(), self.D.copy()
        last, linked = self.last.copy(), self.linked.copy()
        more = remember(T, pixels, depth, keep, stereo, C, N, C1, D, last, linked)
        return PointMemory(C, N, C1, D, last, linked, self.count + more)

    def fade(self, share: float) -> PointMemory:
        """With only a share of everything left."""
        sums = (share * self.C, share * self.N, share * self.C1, share * self.D)
        return PointMemory(*sums, self.last, self.linked, share * self.count)

    def merge(self, later: PointMemory) -> PointMemory:
        """Of this stretch and a later one."""
        sums = (self.C + later.C, self.N + later.N, self.C1 + later.C1, self.D + later.D)
        return PointMemory(*sums, later.last, later.linked, self.count + later.count)

    def cost(self, theta: CameraAndPoints) -> float:
        """x^T C x: 3 a point when all is well."""
        return float(misfit(theta.M, theta.u, theta.points, self.C))

    def correlation(self, theta: CameraAndPoints) -> float:
        """Lag-1 correlation of the residuals at theta, kept within 0 .. 0.98."""
        together = float(misfit(theta.M, theta.u, theta.points, self.C1))
        return float(np.clip(together / max(self.cost(theta), 1e-300), 0.0, 0.98))
