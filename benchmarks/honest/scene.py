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
from bodyschema.model.parts import lens
from bodyschema.model.tree import Body
from honest.arms import TURN, Arm, arms
from honest.effects import direction
from honest.paths import Path, Smooth, Stops
from honest.sights import Noise, Sight, white
from honest.world import Motion, World

Array = NDArray[np.float64]
SenseKind = Literal["points", "poses", "pixels"]

CAMERA = bs.Camera(
    "eye", "tracker", 640, 480, np.array([[500.0, 0, 320], [0, 500, 240], [0, 0, 1]])
)
PIXEL = 600.0
"""px/m, of noise: that of a tracker as a camera has it from a metre or so."""

BOARD = 0.03 * np.array([[1.0, 1, 0], [1, -1, 0], [-1, -1, 0], [-1, 1, 0]])
"""(4, 3) m, corners of a tag on the tool."""

FRESH = 200
"""Postures that an answer is measured on."""


@dataclass(frozen=True)
class Plan:
    """What may be drawn; of every tuple one."""

    senses: tuple[SenseKind, ...] = ("points", "poses", "points", "poses", "pixels")
    n: tuple[int, ...] = (48,)
    smooth: tuple[bool, ...] = (False,)
    reach: tuple[float, ...] = (1.2,)
    """rad round home, every joint."""
    errors: tuple[str, ...] = ("links", "links", "offsets", "full")
    """Of the robot: see `ERRORS`."""
    moving: tuple[int, ...] = (99,)
    """Joints that move at all; the others stand still at home."""
    repeats: int = 1
    """Frames taken of every posture."""
    stated: bool = False


ERRORS = {"links": (1.0, 0.0, 2e-4), "offsets": (1.0, 0.0, 0.0), "full": (1.0, 0.3, 2e-3)}
"""deg of joint zeros, deg of axes, m of links: standard deviations a coordinate."""


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
        """True 95 % error of a body, m, on fresh postures in the box of the recorded ones.

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
        return float(min(off))

    def _off(self, body: Body, motion: Motion) -> float:
        pairs = [("tracker", "tool")]
        pairs += [("base", "tip")] if self.sense == "pixels" else []
        off = []
        for a, b in pairs:
            there = relative_pose(body, motion.q, a, b)
            here = self.world.poses(motion) if a == "tracker" else self.world.chain(motion)[-1]
            away = there[:, :3, 3] - here[:, :3, 3]
            if self.tip:
                away = away + self.tip * (there[:, :3, 2] - here[:, :3, 2])
            off.append(np.quantile(np.linalg.norm(away, axis=1), 0.95))
        return float(max(off))

    def visible(self, q: Array) -> NDArray[np.bool_]:
        """(n,) whether the camera sees the tool at these readings."""
        n = len(q)
        return in_view(self.world.poses(Motion(q, 0 * q, np.zeros(n), np.zeros(n))))


def in_view(T: Array) -> NDArray[np.bool_]:
    """(n,) whether the origin of a frame is in the picture."""
    p = T[:, :3, 3]
    wide = np.abs(p[:, :2]) < 0.95 * np.array([320.0, 240.0]) / 500 * p[:, 2:]
    return np.asarray(wide.all(axis=1) & (p[:, 2] > 0.3))


def draw(plan: Plan, rng: np.random.Generator) -> Scene:
    """A scene without a fault."""
    arm = _one(arms(), rng)
    sense, error = _one(plan.senses, rng), _one(plan.errors, rng)
    n, smooth = int(_one(plan.n, rng)), bool(_one(plan.smooth, rng))
    reach, moving = float(_one(plan.reach, rng)), int(_one(plan.moving, rng))
    corners = np.zeros((1, 3))
    if sense == "pixels" and rng.random() < 0.5:
        corners = BOARD
    elif sense == "pixels":
        n = round(1.5 * n)
    true = off_by(arm.body, rng, *ERRORS[error])
    spread = _spread(arm, reach, moving, rng)
    path: Path = (Smooth if smooth else Stops).draw(arm.home, spread, n, plan.repeats, rng)
    eye = _eye(arm, true, spread, sense, rng)
    hand = lie.transform(lie.exp_so3(rng.normal(size=3)), 0.08 * direction(rng))
    true = true.attach("tracker", "base", eye).attach("tool", "tip", hand)
    world = World(true)
    known = _known(sense, rng)
    given = arm.body.with_part("lens", lens(CAMERA)) if sense == "pixels" else arm.body
    for end, parent, T in (("tracker", "base", eye), ("tool", "tip", hand)):
        turn = lie.exp_so3(rng.normal(scale=0.03, size=3))
        rough = T @ lie.transform(turn, rng.normal(scale=0.007, size=3))
        start = {"no": None, "roughly": rough, "": T}[known.get(end, "")]
        given = given.attach(end, parent, start)
    motion = path.motion(path.times)
    if sense == "pixels":
        motion = _in_view(motion, path, world, n, rng)
    words = (arm.name, f"{1e3 * arm.noise:g} mm", sense, f"n {len(motion)}", f"{error} off")
    free = "+".join(f"{end} {how}" for end, how in known.items())
    about = ", ".join((*words, "smooth" if smooth else "stops", free))
    return Scene(
        arm, given, known, world, path, motion, sense, plan.stated, arm.noise, about,
        with_rate=rng.random() < 2 / 3, corners=corners,
    )  # fmt: skip


def off_by(body: Body, rng: np.random.Generator, zeros: float, tilts: float, links: float) -> Body:
    """A body that differs: degrees of joint zeros and of axes, m of links, standard deviations."""
    n = len(body.joints)
    axis, placement = body.axis.copy(), body.placement.copy()
    turn = lie.exp_so3(np.radians(tilts) * rng.normal(size=(n, 3)))
    axis[1 : n + 1] = np.einsum("nij,nj->ni", turn, axis[1 : n + 1])
    placement[1 : n + 2, :3, 3] += links * rng.normal(size=(n + 1, 3))
    offset = np.radians(zeros) * rng.normal(size=n)
    return replace(body, axis=axis, placement=placement, offset=offset)


def _one(options: Any, rng: np.random.Generator) -> Any:
    return options[int(rng.integers(len(options)))]


def _known(sense: SenseKind, rng: np.random.Generator) -> dict[str, Literal["roughly", "no"]]:
    """Frames that are not known; a camera stands where it was measured, and half of the time the
    place of what it sees on the tool is known too: else pictures alone tell little of the hand."""
    known: dict[str, Literal["roughly", "no"]] = {
        end: "no" if rng.random() < 0.7 else "roughly" for end in ("tracker", "tool")
    }
    if sense == "pixels":
        del known["tracker"]
    if sense == "pixels" and rng.random() < 0.5:
        del known["tool"]
    return known


def _spread(arm: Arm, reach: float, moving: int, rng: np.random.Generator) -> Array:
    """(n_joints,) rad that every joint moves either way."""
    spread = np.full(len(arm.home), reach)
    still = len(spread) - moving
    if still > 0:
        spread[rng.choice(len(spread), still, replace=False)] = 0.0
    return spread


def _eye(arm: Arm, true: Body, spread: Array, sense: SenseKind, rng: np.random.Generator) -> Array:
    """T_base_tracker: anywhere within a metre or so; a camera looks at where the hand is."""
    if sense != "pixels":
        return lie.transform(lie.exp_so3(rng.normal(size=3)), rng.uniform(-1.0, 1.0, 3))
    q = arm.home + spread * rng.uniform(-1, 1, (100, len(arm.home)))
    still = Motion(q, 0 * q, np.zeros(100), np.zeros(100))
    hand = World(true).chain(still)[-1][:, :3, 3]
    centre = hand.mean(axis=0)
    size = np.quantile(np.linalg.norm(hand - centre, axis=1), 0.9)
    z = direction(rng)
    x = np.cross(z, direction(rng))
    x /= np.linalg.norm(x)
    R = np.stack([x, np.cross(z, x), z], axis=1)
    return lie.transform(R, centre - max(2.0 * size, 0.4) * z)


def _in_view(motion: Motion, path: Path, world: World, n: int, rng: np.random.Generator) -> Motion:
    """The samples that the camera sees; a path of stops goes on until there are enough."""
    for _ in range(20):
        kept = in_view(world.poses(motion))
        if isinstance(path, Smooth) or kept.sum() >= n or kept.all():
            break
        motion = path.replaced(motion, ~kept, rng)
    kept = in_view(world.poses(motion))
    return Motion(motion.q[kept], motion.dq[kept], motion.when[kept], motion.time[kept])
