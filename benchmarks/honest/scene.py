"""Scene: one robot, one recording of it, and what is true of both.

A `Plan` says what may be drawn; a fault changes the scene that was drawn; `Scene.senses` is what
the user gets, `Scene.error` what the answer is worth.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import lie
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from honest.arms import TURN, Arm
from honest.paths import Path
from honest.sights import Noise, Sight, white
from honest.world import Motion, World

Array = NDArray[np.float64]
SenseKind = Literal["points", "poses", "pixels"]

PIXEL = 600.0
"""px/m, of noise: that of a tracker as a camera has it from a metre or so."""

FRESH = 200
"""Postures that an answer is measured on."""


@dataclass(frozen=True)
class Scene:
    """What was drawn."""

    arm: Arm
    given: Body
    """The robot as the user has it, frames attached."""
    frames: Mapping[str, Literal["roughly", "no"]]
    world: World
    path: Path
    motion: Motion
    sense: SenseKind
    stated: bool
    noise: float
    """m."""
    about: str
    with_rate: bool = True
    """Whether the user has the speeds of the joints too."""
    late: float = 0.0
    """s, by which what was seen is older than what was read."""
    sights: tuple[Sight, ...] = ()
    noises: Noise = white
    readings: tuple[Callable[[Array], Array], ...] = ()
    """What becomes of the readings before they are written down."""
    declared: tuple[Callable[[Array], Array], ...] = ()
    """What becomes of the observations as they are written down, (n, ...)."""
    distortion: float = 0.0
    """k1 of the true lens; the given one is straight."""
    corners: Array = field(default_factory=lambda: np.zeros((1, 3)))
    """(m, 3) m, of what a camera sees of the tool."""
    tip: float = 0.0
    """m from the tool's origin to the point whose error counts."""

    def seen(self, rng: np.random.Generator) -> Array:
        """What the recording says was seen: (n, 3), (n, 4, 4) or (n, 2)."""
        then = self.path.motion(self.motion.time - self.late) if self.late else self.motion
        then = replace(then, when=self.motion.when)
        T = self.world.poses(then)
        for sight in self.sights:
            T = sight(T, self.motion, rng)
        observed = self._noisy(T, rng)
        for declare in self.declared:
            observed = declare(observed)
        return observed

    def _noisy(self, T: Array, rng: np.random.Generator) -> Array:
        n = len(T)
        if self.sense == "pixels":
            m = len(self.corners)
            p = np.einsum("nij,mj->nmi", T[:, :3, :3], self.corners) + T[:, None, :3, 3]
            noise = self.noises(rng, n, 2 * m).reshape(n * m, 2)
            return self.project(p.reshape(n * m, 3)) + PIXEL * self.noise * noise
        T = T.copy()
        noise = self.noises(rng, n, 6 if self.sense == "poses" else 3)
        T[:, :3, 3] += self.noise * noise[:, :3]
        if self.sense == "points":
            return T[:, :3, 3]
        T[:, :3, :3] = lie.exp_so3(TURN * self.noise * noise[:, 3:]) @ T[:, :3, :3]
        return T

    def project(self, p: Array) -> Array:
        """Pixels (n, 2) of points before the true camera, (n, 3) m."""
        a = p[:, :2] / p[:, 2:]
        bent = a * (1 + self.distortion * (a**2).sum(axis=1, keepdims=True))
        return bent * [500.0, 500.0] + [320.0, 240.0]

    def senses(self, rng: np.random.Generator) -> tuple[bs.Sense, ...]:
        """What the user gives to the product."""
        observed = self.seen(rng)
        q, time, ends = self.motion.q, self.motion.time, ("tracker", "tool")
        for read in self.readings:
            q = read(q)
        rate = self.motion.dq if self.with_rate and self.motion.dq.any() else None
        more: dict[str, Any] = {"time": time, "rate": rate, "stated": self.stated}
        if self.sense == "pixels":
            return (self._pixels(q, observed, **more),)
        if self.sense == "points":
            return (bs.Points.make(q, observed, *ends, self.noise, **more),)
        return (bs.Poses.make(q, observed, *ends, (self.noise, TURN * self.noise), **more),)

    def _pixels(self, q: Array, image: Array, **more: Any) -> bs.Pixels:
        """Every corner of every picture, a row a picture."""
        m = len(self.corners)
        row = np.repeat(np.arange(len(q)), m)
        rate = None if more["rate"] is None else more["rate"][row]
        more |= {"time": more["time"][row], "rows": row, "rate": rate, "std": PIXEL * self.noise}
        target = np.tile(self.corners, (len(q), 1))
        return bs.Pixels.make(q[row], image, "tracker", "tool", "lens", target, **more)

    def error(self, body: Body, rng: np.random.Generator) -> float:
        """True 95 % error of a body, m, see `errors`."""
        return float(np.quantile(self.errors(body, rng), 0.95))

    def errors(self, body: Body, rng: np.random.Generator) -> Array:
        """True errors of a body, m, on fresh postures in the box of the recorded ones.

        Where something moved, of its beginning, middle and end the one that suits the body best.
        Where nothing but pixels was seen, the robot's own tip in its base counts as well as the
        tool before the camera: a picture has no metres.
        """
        low, high = self.motion.q.min(axis=0), self.motion.q.max(axis=0)
        q = rng.uniform(low, high, (20 * FRESH, len(low)))
        q = q[self.visible(q)][:FRESH] if self.sense == "pixels" else q[:FRESH]
        speed = np.abs(self.motion.dq).mean() * rng.choice([-1.0, 1.0], q.shape)
        motion = Motion(q, speed, np.zeros(len(q)), np.zeros(len(q)))
        off = [self._off(body, motion.at(when)) for when in (0.0, 0.5, 1.0)]
        return min(off, key=lambda one: float(np.quantile(one, 0.95)))

    def _off(self, body: Body, motion: Motion) -> Array:
        pairs = [("tracker", "tool")]
        pairs += [("base", "tip")] if self.sense == "pixels" else []
        off = []
        for a, b in pairs:
            there = relative_pose(body, motion.q, a, b)
            here = self.world.poses(motion) if a == "tracker" else self.world.chain(motion)[-1]
            away = there[:, :3, 3] - here[:, :3, 3]
            if self.tip:
                away = away + self.tip * (there[:, :3, 2] - here[:, :3, 2])
            off.append(np.linalg.norm(away, axis=1))
        return max(off, key=lambda one: float(np.quantile(one, 0.95)))

    def visible(self, q: Array) -> NDArray[np.bool_]:
        """(n,) whether the camera sees the tool at these readings."""
        n = len(q)
        return in_view(self.world.poses(Motion(q, 0 * q, np.zeros(n), np.zeros(n))))


def in_view(T: Array) -> NDArray[np.bool_]:
    """(n,) whether the origin of a frame is in the picture."""
    p = T[:, :3, 3]
    wide = np.abs(p[:, :2]) < 0.95 * np.array([320.0, 240.0]) / 500 * p[:, 2:]
    return np.asarray(wide.all(axis=1) & (p[:, 2] > 0.3))
