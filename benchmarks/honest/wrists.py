"""Wrists: an arm with a force/torque sensor, what it holds, and what is recorded of both.

The load is a rigid body by the laws of Newton and Euler; the arm is that of `simulation.katana`.
Faults change the truth (`Wrist`), the recording's columns or what is said of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.inertia import Inertia
from bodyschema.model.kinematics import relative_pose
from bodyschema.senses.wrist_columns import WristTable
from bodyschema.senses.wrist_declaration import PoseColumns, WrenchColumns, WristDeclaration
from bodyschema.simulation.katana import katana
from bodyschema.simulation.loads import (
    DOWN,
    ENCODER,
    NOISE,
    RATE,
    Path,
    Sensor,
    draw_load,
    draw_path,
    draw_sensor,
)
from bodyschema.sources.recording import Recording

Array = NDArray[np.float64]

WRENCH = WrenchColumns(("fx", "fy", "fz", "tx", "ty", "tz"), "sensor", "on_object")
POSE = PoseColumns(("x", "y", "z", "qx", "qy", "qz", "qw"))
STEP = 1e-3
"""s, of the differences that motion is made of."""

Push = Callable[[Array, Array, Array], Array]
"""What else acts on the load: (n,) s, (n, 3, 3) R and (n, 3) m of the mount in the base -> (n, 6) N
and Nm about the mount's origin, along its axes."""


@dataclass(frozen=True)
class Wrist:
    """The truth."""

    path: Path
    seconds: float
    load: Inertia
    """In the mount's frame, at the beginning."""
    sensor: Sensor
    still: int = 0
    """Postures at rest, of which it consists; 0 for a recording in motion."""
    pushes: tuple[Push, ...] = ()
    later: Callable[[float], Inertia] | None = None
    """The load at a share of the recording, if it changes."""
    down: Array = field(default_factory=lambda: DOWN.copy())
    """m/s^2, gravity in the base."""
    drift: Array = field(default_factory=lambda: np.zeros(6))
    """N and Nm that the offset gains by the end, slower and slower."""
    mixing: Array = field(default_factory=lambda: np.eye(6))
    """(6, 6) what the channels read, of what acts."""
    late: float = 0.0
    """s, by which the wrench is older than the pose of its row."""
    declared: WristDeclaration = field(default_factory=lambda: WristDeclaration(WRENCH, POSE))
    columns: tuple[Callable[[dict[str, Array]], None], ...] = ()
    """What becomes of the columns as they are written down."""

    def table(self, rng: np.random.Generator) -> WristTable:
        """The recording."""
        n = self.still or round(self.seconds * RATE)
        time = np.linspace(0.0, self.seconds, n, endpoint=False)
        wrench = self.felt(time - self.late)
        share = time / self.seconds
        wrench = wrench @ self.mixing.T + self.sensor.bias
        wrench += np.outer(1 - np.exp(-3 * share), self.drift)
        wrench += self.sensor.noise * rng.normal(size=wrench.shape)
        wrench = np.round(wrench / self.sensor.noise) * self.sensor.noise
        q = self.path.at(time) + ENCODER * rng.normal(size=(n, 5))
        T = relative_pose(katana(), q, "base", "hand")
        turn = lie.quaternion_xyzw(T[:, :3, :3])
        values = np.column_stack([time, wrench, T[:, :3, 3], turn])
        columns = dict(zip(("t", *WRENCH.columns, *POSE.columns), values.T, strict=True))
        for change in self.columns:
            change(columns)
        if self.still:
            del columns["t"]
        return WristTable(Recording("log", columns, {}))

    def felt(self, time: Array) -> Array:
        """(n, 6) what the sensor exerts on the load, along its own axes."""
        body, h = katana(), 0.0 if self.still else STEP
        before, T, after = (
            relative_pose(body, self.path.at(time + shift), "base", "hand")
            for shift in (-h, 0.0, h)
        )
        R, h = T[:, :3, :3], h or 1.0
        back, forth = (
            lie.log_so3(np.swapaxes(R, 1, 2) @ other[:, :3, :3]) for other in (before, after)
        )
        w, dw = (forth - back) / (2 * h), (forth + back) / h**2
        a = (before[:, :3, 3] - 2 * T[:, :3, 3] + after[:, :3, 3]) / h**2
        a_g = np.einsum("nji,nj->ni", R, a - self.down)
        wrench = np.empty((len(time), 6))
        for i, share in enumerate(time / self.seconds):
            load = self.load if self.later is None else self.later(float(share))
            wrench[i] = needed(load, a_g[i], w[i], dw[i])
        for push in self.pushes:
            wrench -= push(time, R, T[:, :3, 3])
        turned = self.sensor.R_mount_sensor
        return np.hstack([wrench[:, :3] @ turned, wrench[:, 3:] @ turned])


def needed(load: Inertia, a_g: Array, w: Array, dw: Array) -> Array:
    """(6,) N and Nm about the mount's origin that move a load so."""
    c = load.com
    f = load.mass * (a_g + np.cross(dw, c) + np.cross(w, np.cross(w, c)))
    t = load.moments @ dw + np.cross(w, load.moments @ w) + np.cross(c, f)
    return np.concatenate([f, t])


def narrowed(path: Path, share: float) -> Path:
    """The same moves, so much smaller."""
    return replace(path, ways=path.ways[0] + share * (path.ways - path.ways[0]))


def draw_wrist(
    rng: np.random.Generator, seconds: tuple[float, ...] = (10.0, 20.0), still: int = 0
) -> Wrist:
    """A load of 0.3 to 3 kg on a small sensor, or on a larger and noisier one."""
    lasts = float(rng.choice(seconds))
    sensor = draw_sensor(rng, np.radians(1))
    load = draw_load(rng, float(rng.uniform(0.3, 3.0)))
    if rng.random() < 0.5:
        sensor = replace(sensor, noise=5 * NOISE, bias=4 * sensor.bias)
    path = draw_path(rng, lasts, float(rng.uniform(0.3, 0.8)))
    if still:
        rests = np.arange(still) * 3.0
        ways = draw_path(rng, 10.0 * still, 0.5).ways[: still + 1]
        # A jump at the beginning of each pause: postures are recorded at rest.
        path, lasts = Path(rests - 1e-3, np.full(still, 1e-6), ways[: still + 1]), 3.0 * still
    return Wrist(path, lasts, load, sensor, still)
