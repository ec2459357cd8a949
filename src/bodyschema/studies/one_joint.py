"""What one joint's online gradient descends on average, and where it can stay.

A known v of the segment is seen at l + R(a, theta) v. Average E = 1/2 |e|^2 over a symmetric
distribution of theta and put the best l in; with a* the true axis, g = a . a*, |v| = 1,

    s = <sin^2 theta>,   c = var(cos theta),   k = <(1 - cos theta)^2>

    one fixed v     E(a) = 1/2 (s |(a - a*) x v|^2 + c |(v . a) a - (v . a*) a*|^2)
    v on a sphere   E(g) = 2/3 s (1 - g) + 1/3 k (1 - g^2)

The first follows from Eq. A.7 to A.10 of Hersch et al. (2008), the second by averaging the same
terms over v, whose mean is zero, so that l = l* is best. dE/dg = -2/3 (s + k g) is negative for all
g > -1 if and only if k <= s: then a* is the only minimum. Otherwise -a* is one too, and catches
what begins with g < -s/k.

Theorem 1 of the paper asks for c <= 2 s with v fixed. That is not enough: where c is small the
first term alone counts, and it is zero as well at the mirror image a* - 2 (v . a*) v.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import kernel

Array = NDArray[np.float64]

STILL = 1e-9
"""Length of the gradient, in units of s + c, below which a descent has ended."""

MOST_STEPS = 200_000


@dataclass(frozen=True)
class Swing:
    """How a joint moves: the averages that decide what one sample after the other teaches."""

    s: float
    """<sin^2 theta>."""
    c: float
    """var(cos theta)."""
    k: float
    """<(1 - cos theta)^2>."""

    @classmethod
    def uniform(cls, reach: float) -> Swing:
        """theta uniform in +-reach (rad)."""
        mean, square = np.sin(reach) / reach, 0.5 + np.sin(2 * reach) / (4 * reach)
        return cls(1 - square, square - mean**2, 1 - 2 * mean + square)

    @property
    def as_printed(self) -> bool:
        """The condition of Theorem 1."""
        return self.c <= 2 * self.s

    @property
    def single(self) -> bool:
        """Whether a* is the only minimum for v on a sphere."""
        return self.k <= self.s

    @property
    def caught(self) -> float:
        """Share of random axes from which the descent ends in -a*, v on a sphere."""
        return 0.0 if self.single else (1 - self.s / self.k) / 2


def fixed_energy(a: Array, true: Array, v: Array, swing: Swing) -> Array:
    """E(a) for one fixed v: (n, 3), (3,), (3,) -> (n,)."""
    across = np.cross(a - true, v)
    along = (a @ v)[:, None] * a - (v @ true) * true
    sums = swing.s * np.sum(across**2, axis=1) + swing.c * np.sum(along**2, axis=1)
    return np.asarray(0.5 * sums)


def varied_energy(g: Array, swing: Swing) -> Array:
    """E(g) for v uniform on the unit sphere."""
    return np.asarray(2 / 3 * swing.s * (1 - g) + 1 / 3 * swing.k * (1 - g**2))


@kernel
def settle(true: Array, v: Array, s: float, c: float, a: Array) -> bool:
    """Move the unit vector a down E(a) until it rests; False if it still moves at the end."""
    vt = v[0] * true[0] + v[1] * true[1] + v[2] * true[2]
    slope, rate = np.empty(3), 0.5 / (s + 2.0 * c)
    for _ in range(MOST_STEPS):
        va = v[0] * a[0] + v[1] * a[1] + v[2] * a[2]
        ad = va - vt * (a[0] * true[0] + a[1] * true[1] + a[2] * true[2])
        for j in range(3):
            d = va * a[j] - vt * true[j]
            slope[j] = s * (a[j] - true[j] - (va - vt) * v[j]) + c * (ad * v[j] + va * d)
        up = slope[0] * a[0] + slope[1] * a[1] + slope[2] * a[2]
        steep = 0.0
        for j in range(3):
            slope[j] -= up * a[j]
            steep += slope[j] ** 2
            a[j] -= rate * slope[j]
        a /= np.sqrt(a[0] ** 2 + a[1] ** 2 + a[2] ** 2)
        if steep < (STILL * (s + c)) ** 2:
            return True
    return False


def bowl(a: Array, true: Array, v: Array, swing: Swing, h: float = 1e-3) -> float:
    """Smallest curvature of E(a) at a, (3,), over great circles; a strict minimum's is positive."""
    b1, b2 = np.linalg.svd(a[None])[2][1:]
    around = [b1, b2, (b1 + b2) / np.sqrt(2)]
    places = np.array(
        [a, *(np.cos(h) * a + sign * np.sin(h) * d for d in around for sign in (1, -1))]
    )
    E = fixed_energy(places, true, v, swing)
    along = (E[1::2] + E[2::2] - 2 * E[0]) / h**2
    mixed = along[2] - (along[0] + along[1]) / 2
    return float(np.linalg.eigvalsh([[along[0], mixed], [mixed, along[1]]])[0])
