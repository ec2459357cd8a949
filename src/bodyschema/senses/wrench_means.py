"""Wrenches averaged over short windows, with the regressor of the load averaged alike.

The regressor Y(a_g, w, dw) of `wrenches` holds accelerations, which encoders tell badly. Under a
mean over a smooth bump psi(t) that is zero at both ends of a window, derivatives move over to the
bump. With the twist (v, w) of the sensor along its own axes, a = dv/dt + w x v, and since
Y(a, 0, dw) is linear,

    mean y = (mean Y) phi + bias,
    mean Y = int psi Y(w x v - g, w, 0) dt - int psi' Y(v, 0, w) dt,        int psi dt = 1.

No second derivative of a pose is taken, wrench and motion pass through one and the same filter, so
neither is late against the other and none is damped against the other; noise of the encoders above
the bump's band, about 0.9 / window, is gone. psi = (1 - u^2)^4 on the window. Where an
accelerometer rides on the sensor, a_g is its reading and only dw is moved over.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.model.kernels import kernel
from bodyschema.senses.even_samples import evenly
from bodyschema.senses.wrenches import FORCE_STD, TORQUE_STD, Wrenches, load_regressor
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.senses.wrist_twists import twists

Array = NDArray[np.float64]

FAITH, LITTLE = 6.0, 0.5
"""Samples that a noise level counts for that was seen in the samples' scatter, or only assumed."""

FEWEST = 7
"""Samples of a window, at least."""

WIDTH = 0.5513
"""int psi dt squared over int psi^2 dt, for a window of 1."""


@dataclass(frozen=True)
class WrenchMeans:
    """Means of wrench and regressor; the bias enters each mean with weight 1."""

    time: Array
    """(n,) s, middle of each window."""
    y: Array
    """(n, 6) N and Nm, by the sensor on the object, along the sensor's axes."""
    Y: Array
    """(n, 6, 10) along the axes in which the motion is known."""
    std: Array
    """(6,) noise that the sensor alone gives a mean."""
    memory: float = 1.0
    """Of white noise in the samples: long-run variance of neighbouring means over their own."""
    faith: float = FAITH
    """Samples that `std` counts for."""

    def __len__(self) -> int:
        return len(self.time)

    def take(self, rows: Any) -> Self:
        """Some of the means, by slice, index or mask."""
        return replace(self, time=self.time[rows], y=self.y[rows], Y=self.Y[rows])

    @property
    def rows(self) -> Array:
        """(n, 6, 14) of `learners.payload.sums`: [y (3), -Y (10), -1] for each component."""
        a = np.empty((len(self), 6, 14))
        a[:, :3, :3], a[:, 3:, :3] = self.y[:, None, :3], self.y[:, None, 3:]
        a[:, :, 3:13], a[:, :, 13] = -self.Y, -1.0
        return a


def postures(samples: WristSamples) -> WrenchMeans:
    """Each row on its own, the sensor at rest."""
    y = samples.wrench
    Y = load_regressor(-samples.downward(), np.zeros((len(y), 3)), np.zeros((len(y), 3)))
    std = np.array([FORCE_STD] * 3 + [TORQUE_STD] * 3)
    return WrenchMeans(samples.time, y, Y, std, faith=LITTLE)


def at_moments(wrenches: Wrenches) -> WrenchMeans:
    """Wrenches whose accelerations are known, one by one."""
    return WrenchMeans(wrenches.time, wrenches.y, wrenches.regressor(), wrenches.std)


@dataclass(frozen=True)
class Averaging:
    """The windows."""

    window: float = 0.5
    """s"""
    overlap: float = 1 / 3
    """Share of a window from one middle to the next: close enough to lose nothing."""

    def means(self, samples: WristSamples) -> WrenchMeans:
        """All windows of a recording that are filled without a gap.

        Raises:
            InputError: there is none.
        """
        noise = sensor_noise(samples.wrench)
        samples = evenly(samples)
        time = samples.time
        half, span = self.window / 2, self.overlap * self.window
        middles = np.arange(time[0] + half, time[-1] - half + 1e-9, span)
        first = np.searchsorted(time, middles - half - 1e-9)
        last = np.searchsorted(time, middles + half + 1e-9)
        gap = np.concatenate([[0.0], np.diff(time)])
        filled = [
            k
            for k, (a, b) in enumerate(zip(first, last, strict=True))
            if b - a >= FEWEST
            and gap[a + 1 : b].max() <= self.window / 4
            and max(time[a] - middles[k] + half, middles[k] + half - time[b - 1]) <= self.window / 8
        ]
        if not filled:
            step = float(np.median(gap[1:])) if len(time) > 1 else np.inf
            raise InputError(
                f"no {self.window:g} s of the recording hold {FEWEST} samples without a gap "
                f"(samples are {step:g} s apart); give a longer window under [motion], or "
                'kind = "postures" if every row is a posture at rest.'
            )
        whole, moved = _parts(samples)
        y, Y, share = _average(
            time, samples.wrench, whole, moved, middles[filled], half, first[filled], last[filled]
        )
        std = np.sqrt(share.mean()) * noise
        return WrenchMeans(middles[filled], y, Y, std, max(1.0, self._width / span))

    @property
    def _width(self) -> float:
        """s of plain averaging that damps white noise as the bump does: 1 / int psi^2 dt."""
        return self.window * WIDTH


def sensor_noise(wrench: Array) -> Array:
    """(6,) standard deviation of white noise, from third differences, which motion hardly moves."""
    differences = np.diff(wrench, 3, axis=0) if len(wrench) > 3 else np.zeros((1, 6))
    noise = np.sqrt(np.mean(differences**2, axis=0) / 20)
    floor = 1e-5 * np.maximum(np.abs(wrench).max(axis=0), 1e-2)
    return np.asarray(np.maximum(noise, floor))


def _parts(samples: WristSamples) -> tuple[Array, Array]:
    """Of every sample, the regressor under psi and the one under -psi', (n, 6, 10) each."""
    still = np.zeros((len(samples.time), 3))
    v, w = twists(samples)
    g = samples.downward()
    dw, spin = samples.angular_acceleration, w
    if dw is None:
        dw = still
    else:
        spin = still
    if samples.carried:
        return load_regressor(-g, w, dw), load_regressor(still, still, spin)
    if samples.acceleration is not None:
        a = samples.to_sensor(samples.acceleration)
        return load_regressor(a - g, w, dw), load_regressor(still, still, spin)
    return load_regressor(np.cross(w, v) - g, w, dw), load_regressor(v, still, spin)


@kernel
def _average(
    time: Array,
    wrench: Array,
    whole: Array,
    moved: Array,
    middles: Array,
    half: float,
    first: NDArray[np.int64],
    last: NDArray[np.int64],
) -> tuple[Array, Array, Array]:
    """Means of wrench and regressor, and the share of white noise's variance that is left."""
    m = middles.shape[0]
    y, Y, share = np.zeros((m, 6)), np.zeros((m, 6, 10)), np.zeros(m)
    for c in range(m):
        total = 0.0
        for k in range(first[c], last[c]):
            before = time[max(k - 1, first[c])]
            after = time[min(k + 1, last[c] - 1)]
            step = 0.5 * (after - before)
            u = (time[k] - middles[c]) / half
            bump = max(1 - u * u, 0.0)
            psi = step * bump**4
            slope = step * -8 * u * bump**3 / half
            total += psi
            share[c] += psi * psi
            for i in range(6):
                y[c, i] += psi * wrench[k, i]
                for j in range(10):
                    Y[c, i, j] += psi * whole[k, i, j] - slope * moved[k, i, j]
        y[c] /= total
        Y[c] /= total
        share[c] /= total * total
    return y, Y, share
