"""How a lens bends rays, in three models: OpenCV's and ROS's plumb_bob, rational and fisheye.

A ray (a, b, 1) with q = a^2 + b^2 becomes (a', b'), and the pixel is K (a', b', 1). Of the first
two, with N = 1 + k1 q + k2 q^2 + k3 q^3 and D = 1 + k4 q + k5 q^2 + k6 q^3 (1 for plumb_bob),

    s  = N / D                                             s' = ds/dq = (N' - s D') / D
    a' = s a + 2 p1 a b + p2 (q + 2 a^2)                   ds/dk = q^i / D,  -s q^i / D
    b' = s b + p1 (q + 2 b^2) + 2 p2 a b

    da'/da = s + 2 a^2 s' + 2 p1 b + 6 p2 a                da'/db = 2 a b s' + 2 p1 a + 2 p2 b
    db'/db = s + 2 b^2 s' + 6 p1 b + 2 p2 a                db'/da = da'/db

and of a fisheye, equidistant (Kannala and Brandt 2006), with r^2 = q and theta = atan r,

    s = t / r,  t = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)
    a' = s a,  b' = s b
    s' = (t' / (1 + q) - s) / (2 q),  t' = dt/dtheta;  s' = k1 - 1/3 in the middle
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MIDDLE = 1e-8
"""q below which a fisheye is its own limit: differences of s cancel there."""

WIDEST_THETA = 1.48
"""rad, 85 degrees: what a pixel outside the image circle is taken for."""

ROUNDS = 20
"""Newton steps of theta; lenses in use need about five."""


class Distortion(Protocol):
    """One model."""

    @property
    def names(self) -> tuple[str, ...]:
        """Of the coefficients, in OpenCV's order."""

    @property
    def priors(self) -> tuple[float, ...]:
        """How wrong each may be where a lens is known roughly."""

    @property
    def widest(self) -> float:
        """q at the edge of all views: farther off the axis nothing is seen."""

    def bend(self, k: Array, plane: Array) -> Array:
        """a' and b' of a and b, (n, 2) -> (n, 2)."""

    def slope(self, k: Array, plane: Array) -> Array:
        """d(a', b') / d(a, b), (n, 2, 2), symmetric."""

    def by_coefficient(self, k: Array, plane: Array) -> Array:
        """d(a', b') / dk, (n, 2, len(names))."""

    def straightened(self, k: Array, bent: Array) -> Array:
        """About the (a, b) that become (a', b'), for Newton's method to begin at, (n, 2)."""


@dataclass(frozen=True)
class Polynomial:
    """plumb_bob and rational."""

    names: tuple[str, ...]
    priors: tuple[float, ...]
    widest: float

    def bend(self, k: Array, plane: Array) -> Array:
        """See `Distortion`."""
        a, b = plane.T
        q, s = a * a + b * b, self._radial(k, plane)[0]
        bent_a = s * a + 2 * k[2] * a * b + k[3] * (q + 2 * a * a)
        bent_b = s * b + k[2] * (q + 2 * b * b) + 2 * k[3] * a * b
        return np.stack([bent_a, bent_b], axis=1)

    def slope(self, k: Array, plane: Array) -> Array:
        """See `Distortion`."""
        a, b = plane.T
        s, rise, _ = self._radial(k, plane)
        slope = np.empty((len(plane), 2, 2))
        slope[:, 0, 0] = s + 2 * a * a * rise + 2 * k[2] * b + 6 * k[3] * a
        slope[:, 1, 1] = s + 2 * b * b * rise + 6 * k[2] * b + 2 * k[3] * a
        slope[:, 0, 1] = slope[:, 1, 0] = 2 * a * b * rise + 2 * k[2] * a + 2 * k[3] * b
        return slope

    def by_coefficient(self, k: Array, plane: Array) -> Array:
        """See `Distortion`."""
        a, b = plane.T
        q, cross = a * a + b * b, 2 * a * b
        s, _, below = self._radial(k, plane)
        by = np.zeros((len(plane), 2, len(self.names)))
        for column, power in ((0, 1), (1, 2), (4, 3)):
            by[:, :, column] = plane * (q**power / below)[:, None]
        for column in range(5, len(self.names)):
            by[:, :, column] = -plane * (s * q ** (column - 4) / below)[:, None]
        by[:, 0, 2], by[:, 1, 2] = cross, q + 2 * b * b
        by[:, 0, 3], by[:, 1, 3] = q + 2 * a * a, cross
        return by

    def straightened(self, k: Array, bent: Array) -> Array:
        """See `Distortion`."""
        return bent.copy()

    def _radial(self, k: Array, plane: Array) -> tuple[Array, Array, Array]:
        """s, ds/dq and D, (n,) each."""
        q = np.sum(plane**2, axis=1)
        k4, k5, k6 = k[5:] if len(k) > 5 else np.zeros(3)
        below = 1 + q * (k4 + q * (k5 + q * k6))
        s = (1 + q * (k[0] + q * (k[1] + q * k[4]))) / below
        rise = k[0] + q * (2 * k[1] + 3 * q * k[4]) - s * (k4 + q * (2 * k5 + 3 * q * k6))
        return s, rise / below, below


@dataclass(frozen=True)
class Equidistant:
    """A fisheye."""

    names: tuple[str, ...] = ("k1", "k2", "k3", "k4")
    priors: tuple[float, ...] = (0.05,) * 4
    widest: float = float(np.tan(WIDEST_THETA) ** 2)

    def bend(self, k: Array, plane: Array) -> Array:
        """See `Distortion`."""
        return plane * self._radial(k, plane)[0][:, None]

    def slope(self, k: Array, plane: Array) -> Array:
        """See `Distortion`."""
        s, rise = self._radial(k, plane)
        outer = plane[:, :, None] * plane[:, None, :]
        return np.asarray(s[:, None, None] * np.eye(2) + 2 * rise[:, None, None] * outer)

    def by_coefficient(self, k: Array, plane: Array) -> Array:
        """See `Distortion`."""
        r = np.sqrt(np.sum(plane**2, axis=1))
        theta, ahead = np.arctan(r), r**2 > MIDDLE
        powers = theta[:, None] ** (3, 5, 7, 9) / np.where(ahead, r, 1.0)[:, None]
        return np.asarray(plane[:, :, None] * np.where(ahead[:, None], powers, 0.0)[:, None])

    def straightened(self, k: Array, bent: Array) -> Array:
        """See `Distortion`."""
        t = np.sqrt(np.sum(bent**2, axis=1))
        theta = np.minimum(t, WIDEST_THETA)
        for _ in range(ROUNDS):
            value, rise = _odd(k, theta)
            theta = np.clip(theta - (value - t) / rise, 0.0, WIDEST_THETA)
        far = np.where(t > 0, np.tan(theta) / np.where(t > 0, t, 1.0), 1.0)
        return np.asarray(bent * far[:, None])

    def _radial(self, k: Array, plane: Array) -> tuple[Array, Array]:
        """s and ds/dq, (n,) each."""
        q = np.sum(plane**2, axis=1)
        ahead = q > MIDDLE
        r = np.sqrt(np.where(ahead, q, 1.0))
        t, rise = _odd(k, np.arctan(r))
        s = t / r
        steep = (rise / (1 + r**2) - s) / (2 * r**2)
        first = k[0] - 1 / 3
        return np.where(ahead, s, 1 + first * q), np.where(ahead, steep, first)


def _odd(k: Array, theta: Array) -> tuple[Array, Array]:
    """t of theta and dt/dtheta, (n,) each."""
    p = theta**2
    t = theta * (1 + p * (k[0] + p * (k[1] + p * (k[2] + p * k[3]))))
    return t, 1 + p * (3 * k[0] + p * (5 * k[1] + p * (7 * k[2] + 9 * p * k[3])))


PLUMB_BOB, RATIONAL, FISHEYE = "plumb_bob", "rational", "fisheye"
MODELS: dict[str, Distortion] = {
    PLUMB_BOB: Polynomial(("k1", "k2", "p1", "p2", "k3"), (0.1, 0.1, 0.01, 0.01, 0.1), 4.0),
    RATIONAL: Polynomial(
        ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"),
        (0.1, 0.1, 0.01, 0.01, 0.1, 0.1, 0.1, 0.1),
        16.0,
    ),
    FISHEYE: Equidistant(),
}
"""By the names that ROS and the run file have for them; 63, 76 and 85 degrees wide off the axis."""

OF_COUNT = {len(model.names): name for name, model in MODELS.items()}
"""Each has a number of coefficients of its own."""
