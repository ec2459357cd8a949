"""Discrepancy: what no geometry explains, as a smooth function of the posture.

Real residuals are rarely white: a camera's pose error depends on the view, links bend, encoders
wobble. The residual of the corrected body is modelled as a Gaussian process over the joints
(Kennedy and O'Hagan 2001, "Bayesian calibration of computer models"),

    r(q) = f(q) + noise,    cov f(q), f(q') = A^2 (1 + s) exp(-s),   s = sqrt(3) |q - q'| / l

a Matern-3/2 kernel with one length l for the sense, and an amplitude A and a noise N for each of
its components, all found by maximum marginal likelihood. It corrects predictions between the
postures that were seen and fades to zero far from them; it cannot be written into a URDF.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, lapack
from scipy.optimize import minimize

from bodyschema.model.tree import Body
from bodyschema.senses.sense import Sense

Array = NDArray[np.float64]

MOST_SAMPLES = 400
"""Evenly spaced samples that a field is fitted to; the cost grows with their cube."""

SMALLEST_SIZE = 1e-12
"""m or rad: exact (simulated) samples must not divide by zero."""

IMPOSSIBLE = 1e25
"""Negative log likelihood of a covariance that rounding has made indefinite."""


@dataclass(frozen=True)
class Field:
    """Size and smoothness of a residual field."""

    length: float
    """rad (m for prismatic joints): how far a posture tells about another."""
    amplitude: tuple[float, ...]
    """Size of the field, one for each component of the sense (m, rad)."""
    noise: tuple[float, ...]
    """What is left, one for each component (m, rad)."""


@dataclass(frozen=True)
class Discrepancy(Field):
    """A residual field of one sense, with the samples that it was learned from."""

    q: Array
    """(n, n_joints)."""
    coefficients: Array
    """(n, dimension) K^-1 r."""
    gain: float
    """Log marginal likelihood gained over white noise; without enough of it there is no field."""

    def predict(self, q: Array) -> Array:
        """Expected residual (seen minus predicted) at postures (m, n_joints) -> (m, dimension)."""
        kernel = matern(q, self.q, self.length)
        return np.asarray(kernel @ self.coefficients)


def learn_discrepancy(body: Body, sense: Sense, good: NDArray[np.bool_]) -> Discrepancy:
    """Fit a field to the residuals of a corrected body.

    Args:
        body: the corrected body.
        sense: the samples that it was corrected with.
        good: (n,) samples that are no outliers.
    """
    rows = np.flatnonzero(good)
    rows = rows[np.linspace(0, len(rows) - 1, min(len(rows), MOST_SAMPLES)).astype(int)]
    kept = sense.take(rows)
    residual = kept.residual(body)
    parts = [residual[:, part] for _, _, part in sense.components]
    sizes = np.array([max(np.sqrt(np.mean(part**2)), SMALLEST_SIZE) for part in parts])

    theta, gain = most_likely(
        kept.q, [part / size for part, size in zip(parts, sizes, strict=True)]
    )
    # A field has to pay for its parameters (Schwarz 1978), or there is none.
    found = gain > 0.5 * (1 + len(parts)) * np.log(max(residual.size, 2))
    amplitude, noise = sizes * np.exp(theta[1::2]), sizes * np.exp(theta[2::2])
    coefficients = np.zeros_like(residual)
    if found:
        kernel = matern(kept.q, kept.q, float(np.exp(theta[0])))
        for (_, _, part), a, n in zip(sense.components, amplitude, noise, strict=True):
            K = kernel + (n / a) ** 2 * np.eye(len(kept))
            coefficients[:, part] = cho_solve(cho_factor(K), residual[:, part])
    return Discrepancy(
        length=float(np.exp(theta[0])),
        amplitude=tuple(float(a) if found else 0.0 for a in amplitude),
        noise=tuple(float(n) for n in (noise if found else sizes)),
        q=kept.q,
        coefficients=coefficients,
        gain=gain,
    )


def most_likely(q: Array, parts: Sequence[Array]) -> tuple[Array, float]:
    """Logarithms of l, then A and N of each part (scaled to size 1), and the likelihood gained."""
    start = np.array([0.0, *np.tile(np.log(np.sqrt(0.5)), 2 * len(parts))])
    bounds = [(-3.0, 2.5), *[(-5.0, 2.0)] * (2 * len(parts))]
    told = (distances(q, q), parts)
    best = minimize(unlikelihood, start, told, "L-BFGS-B", jac=True, bounds=bounds)
    white = 0.5 * sum(float(np.sum(part**2)) for part in parts)
    return np.asarray(best.x), float(white - best.fun)


def unlikelihood(theta: Array, gap: Array, parts: Sequence[Array]) -> tuple[float, Array]:
    """Negative log likelihood of all parts, up to a constant, and its slope.

    Args:
        theta: logarithms of l, then A and N of each part.
        gap: (n, n) distances between the postures.
        parts: (n, m) residuals of each component.
    """
    s = np.sqrt(3.0) * np.exp(-theta[0]) * gap
    fading = np.exp(-s)
    by_length = s * fading
    kernel = fading + by_length
    by_length *= s
    total, slope = 0.0, np.zeros_like(theta)
    for i, part in enumerate(parts):
        amplitude, noise = 2 * i + 1, 2 * i + 2
        value, by_log = _of_part(part, kernel, by_length, theta[amplitude], theta[noise])
        total += value
        slope[[0, amplitude, noise]] += by_log
    return total, slope


def _of_part(
    r: Array, kernel: Array, by_length: Array, log_amplitude: float, log_noise: float
) -> tuple[float, Array]:
    """Negative log likelihood of columns r ~ N(0, K), K = A^2 kernel + N^2 1, up to a constant.

    With alpha = K^-1 r and m columns its slope along any change of K is

        (m tr(K^-1 dK) - tr(alpha^T dK alpha)) / 2,

    dK = A^2 `by_length`, 2 A^2 kernel and 2 N^2 1 for the logarithms of l, A and N.

    Returns:
        The value, and its slopes by the logarithms of l, A and N (3,).
    """
    A2, N2 = np.exp(2 * log_amplitude), np.exp(2 * log_noise)
    K = A2 * kernel
    K.flat[:: len(r) + 1] += N2
    # Transposed, a symmetric matrix is in LAPACK's order and is worked on in place.
    L, failed = lapack.dpotrf(K.T, lower=1, overwrite_a=1)
    if failed:
        return IMPOSSIBLE, np.zeros(3)
    n, m = r.shape
    half_logdet = float(np.sum(np.log(np.diag(L))))
    alpha, _ = lapack.dpotrs(L, r, lower=1)
    inverse, _ = lapack.dpotri(L, lower=1, overwrite_c=1)
    explained, trace = float(np.sum(r * alpha)), float(np.trace(inverse))
    # Only the lower triangle of the inverse is filled; the diagonal of `by_length` is zero.
    traced = float(np.vdot(inverse.T, by_length))
    longer = A2 * (m * traced - 0.5 * float(np.sum(alpha * (by_length @ alpha))))
    noisier = N2 * (m * trace - float(np.sum(alpha**2)))
    larger = m * n - explained - noisier  # A^2 kernel = K - N^2 1
    return 0.5 * explained + m * half_logdet, np.array([longer, larger, noisier])


def distances(q: Array, other: Array) -> Array:
    """|q - q'| of postures, (m, n_joints) and (n, n_joints) -> (m, n)."""
    squared = np.zeros((len(q), len(other)))
    for one, two in zip(q.T, other.T, strict=True):
        squared += np.subtract.outer(one, two) ** 2
    return np.asarray(np.sqrt(squared))


def matern(q: Array, other: Array, length: float) -> Array:
    """Matern-3/2 correlation of postures, (m, n_joints) and (n, n_joints) -> (m, n)."""
    s = np.sqrt(3.0) * distances(q, other) / length
    return np.asarray((1 + s) * np.exp(-s))
