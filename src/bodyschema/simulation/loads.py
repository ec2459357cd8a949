"""An arm with a force/torque sensor in its wrist moves something that it holds.

The arm is that of `katana`; random way points are joined by minimum-jerk moves, 100 samples a
second. The sensor has the noise of a small six-axis one (0.02, 0.02, 0.04 N and 0.5 mNm, read in
steps of that size), an offset, and sits a little turned on its mount. Encoders are noisy: all that
the learner knows of the motion comes from them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.inertia import Inertia
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.wrenches import load_regressor
from bodyschema.senses.wrist_samples import WristSamples
from bodyschema.simulation.katana import CENTRE, REACH, SPEED, katana

Array = NDArray[np.float64]

RATE = 100.0
"""samples a second"""

NOISE = np.array([0.02, 0.02, 0.04, 5e-4, 5e-4, 5e-4])
"""N and Nm."""

ENCODER = 1.2e-4
"""rad"""

DOWN = np.array([0.0, 0.0, -9.81])
"""m/s^2"""


@dataclass(frozen=True)
class Sensor:
    """What is wrong with the sensor."""

    bias: Array
    """(6,) N and Nm along its own axes."""
    R_mount_sensor: Array
    """(3, 3)."""
    noise: Array = field(default_factory=lambda: NOISE.copy())
    """(6,) N and Nm."""
    gain: float = 0.0
    """Relative error of its scale."""


@dataclass(frozen=True)
class Held:
    """From a time on, what hangs on the sensor."""

    since: float
    """s"""
    load: Inertia
    """In the mount's frame, all of it."""


def wire_box() -> Inertia:
    """The object of the paper: 0.594 kg with the printed centre of mass, as a thin-walled box."""
    mass, com, size = 0.594, np.array([0.016, -0.021, 0.092]), np.array([0.10, 0.12, 0.18])
    square = float(size @ size) - size**2
    return Inertia(mass, com, np.diag(1.5 * mass / 12 * square))


def draw_sensor(
    rng: np.random.Generator,
    turn: float,
    bias: tuple[float, float] = (0.5, 0.02),
    gain: float = 0.0,
) -> Sensor:
    """A sensor with random offset and turn.

    Args:
        rng: of both.
        turn: rad, standard deviation about each axis.
        bias: N and Nm, standard deviations of the offset.
        gain: relative error of the scale.
    """
    offset = rng.normal(size=6) * np.repeat(bias, 3)
    return Sensor(offset, lie.exp_so3(turn * rng.normal(size=3)), gain=gain)


def draw_load(rng: np.random.Generator, mass: float) -> Inertia:
    """A box of a random shape, centre and attitude; larger if it is heavier."""
    size = (mass / 800) ** (1 / 3) * rng.uniform(0.6, 2.0, 3)
    axes = lie.exp_so3(rng.normal(size=3))
    square = float(size @ size) - size**2
    com = np.array([0.0, 0.0, 0.08]) + rng.uniform(-0.03, 0.03, 3)
    return Inertia(mass, com, axes @ np.diag(mass / 12 * square) @ axes.T)


def joined(one: Inertia, other: Inertia) -> Inertia:
    """Both as one body."""
    return Inertia.from_phi(one.phi + other.phi)


@dataclass(frozen=True)
class Path:
    """Joint angles as a function of time: minimum-jerk moves with rests between them."""

    start: Array
    """(moves,) s"""
    length: Array
    """(moves,) s"""
    ways: Array
    """(moves + 1, 5) rad"""

    def at(self, time: Array) -> Array:
        """(n, 5) rad."""
        k = np.clip(np.searchsorted(self.start, time, side="right") - 1, 0, len(self.start) - 1)
        s = np.clip((time - self.start[k]) / self.length[k], 0.0, 1.0)[:, None]
        rise = s**3 * (10 - 15 * s + 6 * s * s)
        return np.asarray(self.ways[k] + (self.ways[k + 1] - self.ways[k]) * rise)


def draw_path(rng: np.random.Generator, seconds: float, speed: float) -> Path:
    """Random moves; `speed` is the peak joint speed as a share of the limits."""
    body = katana()
    starts, lengths, now = [], [], 0.0
    ways = [np.clip(CENTRE + rng.uniform(-1, 1, 5) * REACH, body.lower, body.upper)]
    while now < seconds:
        there = np.clip(CENTRE + rng.uniform(-1, 1, 5) * REACH, body.lower, body.upper)
        # A minimum-jerk move peaks at 15/8 of its mean speed.
        length = max(0.4, float(np.max(np.abs(there - ways[-1]) * 1.875 / (speed * SPEED))))
        starts.append(now)
        lengths.append(length)
        ways.append(there)
        now += length + rng.uniform(0.0, 0.3)
    return Path(np.array(starts), np.array(lengths), np.array(ways))


@dataclass(frozen=True)
class Motion:
    """The true motion of the mount."""

    time: Array
    """(n,) s"""
    q: Array
    """(n, 5) rad, true."""
    R: Array
    """(n, 3, 3) R_world_mount."""
    a_g: Array
    """(n, 3) m/s^2 along the mount's axes, as are the next two."""
    w: Array
    dw: Array


def draw_motion(rng: np.random.Generator, seconds: float, speed: float, rate: float) -> Motion:
    """A random motion, its derivatives by differences of the exact path."""
    body, path, h = katana(), draw_path(rng, seconds, speed), 1e-3
    time = np.arange(round(seconds * rate)) / rate
    q = [path.at(time + shift) for shift in (-h, 0.0, h)]
    before, T, after = (relative_pose(body, angles, "base", "hand") for angles in q)
    R, R_t = T[:, :3, :3], np.swapaxes(T[:, :3, :3], 1, 2)
    back = lie.log_so3(R_t @ before[:, :3, :3])
    forth = lie.log_so3(R_t @ after[:, :3, :3])
    a = (before[:, :3, 3] - 2 * T[:, :3, 3] + after[:, :3, 3]) / h**2
    a_g = np.einsum("nji,nj->ni", R, a - DOWN)
    return Motion(time, q[1], R, a_g, (forth - back) / (2 * h), (forth + back) / h**2)


def feel(motion: Motion, held: Sequence[Held], sensor: Sensor, rng: np.random.Generator) -> Array:
    """(n, 6) N and Nm: what the sensor reads, by it on the load, along its own axes."""
    Y = load_regressor(motion.a_g, motion.w, motion.dw)
    phi = np.array([h.load.phi for h in held])
    which = np.searchsorted([h.since for h in held], motion.time, side="right") - 1
    y = np.einsum("nij,nj->ni", Y, phi[np.maximum(which, 0)])
    R = sensor.R_mount_sensor
    y = (1 + sensor.gain) * np.hstack([y[:, :3] @ R, y[:, 3:] @ R])
    y = y + sensor.bias + rng.normal(size=y.shape) * sensor.noise
    return np.asarray(np.round(y / sensor.noise) * sensor.noise)


def record(
    motion: Motion,
    held: Sequence[Held],
    sensor: Sensor,
    rng: np.random.Generator,
    encoder: float = ENCODER,
) -> WristSamples:
    """What the robot gets to know: wrenches, and poses from noisy encoders."""
    wrench = feel(motion, held, sensor, rng)
    q = motion.q + encoder * rng.normal(size=motion.q.shape)
    T = relative_pose(katana(), q, "base", "hand")
    return WristSamples(motion.time, wrench, rotation=T[:, :3, :3], position=T[:, :3, 3])
