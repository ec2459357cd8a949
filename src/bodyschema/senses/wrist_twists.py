"""Velocity and angular velocity of a wrist sensor, recorded or read from its poses.

Round each sample position and turn are polynomials of fourth order in time, fitted to the samples
nearby; their slopes at the sample are the velocities. Turns are rotation vectors relative to the
sample's own orientation, where the slope is the angular velocity itself. No polynomial reaches
over a gap, where the wrist may have gone anywhere; a short stretch gets one of lower order.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.model.kernels import kernel
from bodyschema.senses.even_samples import GAP
from bodyschema.senses.wrist_samples import WristSamples

Array = NDArray[np.float64]

STENCIL = 0.02
"""s: a velocity is read from the samples this near, or from two on each side."""

SHORT = 0.1
"""s without a sample that are no gap yet, however quick the samples."""


def twists(samples: WristSamples) -> tuple[Array, Array]:
    """Velocity and angular velocity (n, 3) along the sensor's axes; recorded, or from poses."""
    n = len(samples.time)
    v = w = np.zeros((n, 3))
    if samples.rotation is not None and n >= 5:
        p = np.zeros((n, 3)) if samples.position is None else samples.position
        R = np.ascontiguousarray(samples.rotation)
        gap = max(GAP * float(np.median(np.diff(samples.time))), SHORT)
        v, w = _twists(samples.time, R, np.ascontiguousarray(p), STENCIL, gap)
    if samples.velocity is not None:
        v = samples.to_sensor(samples.velocity)
    if samples.angular_velocity is not None:
        w = samples.angular_velocity
    return v, w


@kernel
def _twists(time: Array, R: Array, p: Array, reach: float, gap: float) -> tuple[Array, Array]:
    """Slopes at 0 of local polynomials of fourth order through p and the turns from R_k."""
    n = time.shape[0]
    v, w = np.zeros((n, 3)), np.zeros((n, 3))
    low, high = 0, -1
    for k in range(n):
        if k > high:
            low = high = k
            while high < n - 1 and time[high + 1] - time[high] <= gap:
                high += 1
        if high == low:
            continue
        a, b = k, k
        while a > low and (k - a < 2 or time[k] - time[a - 1] <= reach):
            a -= 1
        while b < high and (b - k < 2 or time[b + 1] - time[k] <= reach):
            b += 1
        if b - a < 4:
            a, b = max(low, min(a, b - 4)), min(high, max(b, a + 4))
        order = min(4, b - a)
        scale = max(time[k] - time[a], time[b] - time[k])
        V, s = np.empty((b - a + 1, order + 1)), np.empty((b - a + 1, 6))
        for j in range(a, b + 1):
            u, power = (time[j] - time[k]) / scale, 1.0
            for m in range(order + 1):
                V[j - a, m] = power
                power *= u
            T = R[k].T @ R[j]
            x, y, z = T[2, 1] - T[1, 2], T[0, 2] - T[2, 0], T[1, 0] - T[0, 1]
            sine = 0.5 * np.sqrt(x * x + y * y + z * z)
            angle = np.arctan2(sine, 0.5 * (T[0, 0] + T[1, 1] + T[2, 2] - 1))
            turn = 0.5 * (angle / sine if sine > 1e-9 else 1.0)
            s[j - a, 3], s[j - a, 4], s[j - a, 5] = turn * x, turn * y, turn * z
            for m in range(3):
                s[j - a, m] = p[j, m] - p[k, m]
        c = np.linalg.solve(V.T @ V, V.T @ s)[1] / scale
        for m in range(3):
            w[k, m] = c[3 + m]
            for i in range(3):
                v[k, m] += R[k, i, m] * c[i]
    return v, w
