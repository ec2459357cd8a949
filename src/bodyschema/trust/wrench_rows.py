"""Whitened rows of a load's fit: what each mean wrench still says, once the fit is made.

    z = e / s                  residual wrenches in units of their noise, along the mount's axes
    A = (d e / d theta) / s    theta = (turn w, offset b, phi_1 .. phi_K) as in `learners.payload`
    C = (A^T A + P)^-1         posterior covariance of theta; P is that of the prior, diagonal

Neighbouring windows share samples, so only every so many-th mean is taken: those are measurements
of their own, and what is left correlated among them is error that remembers.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.estimation.loads import com_slope
from bodyschema.learners.payload.chart import SHARED, open_information
from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.payload.recorded import PayloadFit

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Flags = NDArray[np.bool_]

CELLS = 3
"""Times that the directions of gravity are cut in two: eight cells of postures."""

BLOCKS = 10
"""Stretches of time: few enough that a slow error fills one, enough that they can be averaged."""

MOMENTS = slice(4, 10)
"""Of phi."""


@dataclass(frozen=True)
class WrenchRows:
    """n means of six components, and p numbers of theta."""

    z: Array
    """(n, 6)."""
    A: Array
    """(n, 6, p)."""
    sigma: Array
    """(6,) N and Nm that z and A are told in."""
    precision: Array
    """(p,) inverse variances of the prior."""
    time: Array
    """(n,) s."""
    part: Ints
    """(n,) of the recording."""
    wrench: Array
    """(n, 6) N and Nm: as read, offset removed, along the mount's axes."""
    Y: Array
    """(n, 6, 10) regressor of the motion."""
    carried: Array
    """(n, 10) phi of all that hangs on the sensor then."""

    time_span: tuple[float, float]
    """s, of the whole recording."""
    counts: Flags
    """(n,) whether a mean is a measurement of its own and was not left out as wild."""

    @classmethod
    def of(cls, fit: PayloadFit, learner: LoadLearner) -> WrenchRows:
        """Linearise where the fit has come to rest, all means.

        Args:
            fit: of a recording.
            learner: with the priors of the sensor.
        """
        guess, sigma = fit.solution.guess, np.sqrt(fit.solution.levels.variance)
        found = [_rows(fit, k) for k in range(len(fit.parts))]
        e, J, time, part, wrench, Y, carried, counts = map(np.concatenate, zip(*found, strict=True))
        turn = np.full(3, min(learner.turn_std, 10.0) ** -2.0)
        bias = np.repeat([learner.force_bias_std, learner.torque_bias_std], 3) ** -2.0
        precision = np.concatenate([turn, bias, *(open_information(p) for p in guess.phi)])
        span = (float(time.min()), float(time.max()))
        return cls(
            e / sigma, J / sigma[:, None], sigma, precision, time, part.astype(np.int64), wrench, Y,
            carried, span, counts.astype(bool),
        )  # fmt: skip

    def take(self, rows: Flags | Ints) -> WrenchRows:
        """Some of the means."""
        kept = {name: getattr(self, name)[rows] for name in BY_MEAN}
        return replace(self, **kept)

    def told_in(self, sigma: Array) -> WrenchRows:
        """The same in units of another noise (6,)."""
        ratio = self.sigma / sigma
        return replace(self, z=self.z * ratio, A=self.A * ratio[:, None], sigma=sigma)

    def __len__(self) -> int:
        return len(self.time)

    @cached_property
    def root(self) -> Array:
        """(p, p) L with C = L L^T; balanced, since numbers differ by many powers of ten."""
        A = self.A.reshape(-1, self.A.shape[2])
        H = A.T @ A + np.diag(self.precision)
        scale = 1 / np.sqrt(np.diag(H))
        values, vectors = np.linalg.eigh(H * np.outer(scale, scale))
        return np.asarray(scale[:, None] * vectors / np.sqrt(np.maximum(values, 1e-13)))

    @cached_property
    def B(self) -> Array:
        """(n, 6, p) A L."""
        return np.asarray(self.A @ self.root)

    @cached_property
    def span_of_theta(self) -> Array:
        """(6 n + p, p) orthonormal: what theta can do to the rows, those of the prior below."""
        A = np.vstack([self.A.reshape(-1, self.A.shape[2]), np.diag(np.sqrt(self.precision))])
        return np.asarray(np.linalg.qr(A / np.linalg.norm(A, axis=0))[0])

    def left_of(self, Z: Array) -> Array:
        """(6 n + p, k) what theta leaves of columns (n, 6, k); projected twice, to keep digits."""
        Q, k = self.span_of_theta, Z.shape[2]
        left = np.vstack([Z.reshape(-1, k), np.zeros((self.A.shape[2], k))])
        for _ in range(2):
            left = left - Q @ (Q.T @ left)
        return left

    @cached_property
    def freedom(self) -> float:
        """Numbers seen, less those that theta has absorbed."""
        return max(self.z.size - float(np.sum(self.B**2)), 1.0)

    @cached_property
    def squared(self) -> float:
        """|z|^2 that no theta can take away."""
        return float(np.sum(self.left_of(self.z[:, :, None]) ** 2))

    def clusters(self) -> Iterator[Ints]:
        """Label of each mean (n,): its stretch of time, its posture."""
        yield np.arange(len(self)) * min(BLOCKS, len(self)) // len(self)
        yield self.postures()

    def postures(self) -> Ints:
        """(n,) cell of the direction of gravity, cut at the median of its widest component."""
        g = self.Y[:, :3, 0]
        cells = [np.arange(len(g))]
        for _ in range(CELLS):
            cells = [half for cell in cells for half in _halved(g, cell)]
        label = np.empty(len(g), dtype=np.int64)
        for i, cell in enumerate(cells):
            label[cell] = i
        return label

    @property
    def span(self) -> float:
        """Spread of gravity less acceleration along the sensor's axes, as a share of itself."""
        g = self.Y[:, :3, 0]
        size = float(np.median(np.linalg.norm(g, axis=1)))
        return float(np.sqrt(np.sum(np.var(g, axis=0)))) / max(size, 1e-9)

    def smooth(self) -> Array:
        """(n,) time from -1 to 1 over the whole recording."""
        low, high = self.time_span
        return np.asarray(2 * (self.time - low) / max(high - low, 1e-9) - 1)


BY_MEAN = ("z", "A", "time", "part", "wrench", "Y", "carried", "counts")


def _rows(fit: PayloadFit, k: int) -> tuple[Array, ...]:
    """Of one part: e, its slope, times, number of the part, wrench, Y, phi, and what counts."""
    guess, names, part = fit.solution.guess, fit.names, fit.parts[k]
    means, phi = part.means, fit.solution.guess.phi
    y = np.hstack([means.y[:, :3] @ guess.R.T, means.y[:, 3:] @ guess.R.T])
    J = np.zeros((len(means), 6, SHARED + 10 * len(names)))
    # d (R y) / dw for exp(w) R is -[R y]x.
    J[:, :3, :3], J[:, 3:, :3] = -lie.skew(y[:, :3]), -lie.skew(y[:, 3:])
    J[:, :, 3:SHARED] = -np.eye(6)
    for name in part.loads:
        at = SHARED + 10 * names.index(name)
        J[:, :, at : at + 10] = -means.Y
    carried = np.tile(phi[[names.index(n) for n in part.loads]].sum(axis=0), (len(means), 1))
    counts = np.zeros(len(means))
    counts[np.flatnonzero(fit.kept[k])[:: max(1, round(means.memory))]] = 1.0
    number = np.full(len(means), float(k))
    return (
        fit.residuals(k), J, means.time, number, y - guess.bias, means.Y, carried, counts,
    )  # fmt: skip


def slopes(fit: PayloadFit, k: int) -> dict[str, Array]:
    """Slopes of what is asked of load k by theta: mass (1, p), centre (3, p), moments (6, p)."""
    load = fit.loads[fit.names[k]]
    p, at = SHARED + 10 * len(fit.names), SHARED + 10 * k
    mass, com, moments = np.zeros((1, p)), np.zeros((3, p)), np.zeros((6, p))
    mass[0, at] = 1.0
    com[:, at : at + 4] = com_slope(load)
    moments[:, at : at + 10] = central_slope(load.phi)
    return {"mass": mass, "centre": com, "moments": moments}


def central_slope(phi: Array) -> Array:
    """(6, 10) d (xx, xy, yy, xz, yz, zz about the centre of mass) / d phi.

    I_c = I_o - (|h|^2 1 - h h^T) / m.
    """
    m, h = float(phi[0]), phi[1:4]
    J = np.zeros((6, 10))
    for row, (i, j) in enumerate(((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))):
        J[row, MOMENTS.start + row] = 1.0
        same = float(i == j)
        J[row, 0] = (same * (h @ h) - h[i] * h[j]) / m**2
        for k in range(3):
            J[row, 1 + k] = -(2 * same * h[k] - h[i] * (j == k) - h[j] * (i == k)) / m
    return J


def blocks(label: Ints) -> list[Ints]:
    """Indices of each cluster."""
    order = np.argsort(label, kind="stable")
    ends = np.flatnonzero(np.diff(label[order], prepend=-1, append=-1))
    return [order[a:b] for a, b in pairwise(ends)]


def _halved(g: Array, cell: Ints) -> tuple[Ints, Ints]:
    widest = int(np.argmax(np.ptp(g[cell], axis=0))) if len(cell) else 0
    order = cell[np.argsort(g[cell, widest], kind="stable")]
    return order[: len(order) // 2], order[len(order) // 2 :]
