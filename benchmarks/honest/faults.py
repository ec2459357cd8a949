"""Faults of a calibration: the rows of the campaign."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from honest import effects, sights
from honest.scene import Plan, Scene, SenseKind
from honest.world import Motion

Array = NDArray[np.float64]
Change = Callable[[Scene, np.random.Generator], Scene]


def unchanged(scene: Scene, rng: np.random.Generator) -> Scene:
    """Nothing is wrong."""
    return scene


@dataclass(frozen=True)
class Fault:
    """One row of the table."""

    name: str
    plan: Plan = field(default_factory=Plan)
    change: Change = unchanged
    good: bool = False
    apart: bool = False
    """No rival is made for it."""
    weight: int = 1
    """Share of the runs."""


def _one(options: Any, rng: np.random.Generator) -> Any:
    return options[int(rng.integers(len(options)))]


def _joint(scene: Scene, rng: np.random.Generator) -> int:
    """One of those that move."""
    return int(rng.choice(np.flatnonzero(np.ptp(scene.motion.q, axis=0) > 1e-6)))


def _sight(*options: sights.Sight) -> Change:
    return lambda scene, rng: replace(scene, sights=(_one(options, rng),))


def _noise(*options: sights.Noise) -> Change:
    return lambda scene, rng: replace(scene, noises=_one(options, rng))


def _late(*seconds: float) -> Change:
    return lambda scene, rng: replace(scene, late=_one(seconds, rng))


def _effect(make: Callable[[Scene, np.random.Generator], effects.Effect]) -> Change:
    def changed(scene: Scene, rng: np.random.Generator) -> Scene:
        return replace(scene, world=replace(scene.world, effects=(make(scene, rng),)))

    return changed


def _declared(*options: Any) -> Change:
    return lambda scene, rng: replace(scene, declared=(_one(options, rng),))


def _bumped(frame: str, *sizes: float) -> Change:
    """The tracker or the tool jumps half way by so many m, and turns by as many rad or more."""

    def changed(scene: Scene, rng: np.random.Generator) -> Scene:
        size = _one(sizes, rng)
        turn = size * (1.0 if frame == "tracker" else 5.0) * effects.direction(rng)
        move = effects.moved(np.concatenate([size * effects.direction(rng), turn]))
        return replace(scene, world=replace(scene.world, **{frame: (move,)}))

    return changed


def _reordered(scene: Scene, rng: np.random.Generator) -> Scene:
    """Quaternions in another order; it shows 10 cm from the tool's origin."""
    return replace(scene, declared=(sights.reordered,), tip=0.1)


def _slip(*degrees: float) -> Change:
    return _effect(
        lambda scene, rng: effects.slip(_joint(scene, rng), np.radians(_one(degrees, rng)))
    )


def _gear(*shares: float) -> Change:
    return _effect(lambda scene, rng: effects.geared(_joint(scene, rng), _one(shares, rng)))


def _sag(scene: Scene, rng: np.random.Generator) -> effects.Effect:
    """0.6 deg at most in one or two joints that carry something."""
    n = len(scene.motion.q.T)
    q = scene.arm.home + rng.uniform(-1.2, 1.2, (200, n))
    among = Motion(q, 0 * q, np.zeros(200), np.zeros(200))
    torque = np.abs(scene.world.torques(among)).max(axis=0)
    loaded = np.argsort(-torque)[:3]
    softness = np.zeros(n)
    softness[rng.choice(loaded, rng.integers(1, 3), replace=False)] = np.radians(0.6)
    return effects.sag(scene.world, softness, among)


def _waves(scene: Scene, rng: np.random.Generator) -> effects.Effect:
    n = len(scene.motion.q.T)
    size = np.radians(rng.uniform(0.1, 0.4, n))
    if rng.random() < 0.5:
        size *= np.arange(n) == _joint(scene, rng)
    return effects.waves(size, rng.integers(1, 4, n), rng.uniform(-np.pi, np.pi, n))


def _columns(swap: bool) -> Change:
    """Two columns swapped, or one counted the other way."""

    def make(scene: Scene, rng: np.random.Generator) -> effects.Effect:
        n = len(scene.motion.q.T)
        order, sign = np.arange(n), np.ones(n)
        if swap:
            i, j = rng.choice(n, 2, replace=False)
            order[[i, j]] = order[[j, i]]
        else:
            sign[int(rng.integers(n))] = -1.0
        return effects.columns(order, sign)

    return _effect(make)


def _in_mm(scene: Scene, rng: np.random.Generator) -> Scene:
    """What was seen in another unit, or the robot."""
    factor = _one((1000.0, 1000.0, 0.001, 100.0, 0.0254), rng)
    if scene.sense == "pixels" or rng.random() < 0.3:
        return _scaled_robot(factor)(scene, rng)
    return replace(scene, declared=(sights.scaled(factor),))


def _scaled_robot(*factors: float) -> Change:
    """The description's links so many times as long as the robot's."""

    def changed(scene: Scene, rng: np.random.Generator) -> Scene:
        placement = scene.given.placement.copy()
        links = [k for k, name in enumerate(scene.given.frames) if name not in ("tracker", "tool")]
        placement[links, :3, 3] *= _one(factors, rng)
        return replace(scene, given=replace(scene.given, placement=placement))

    return changed


def _backlash(scene: Scene, rng: np.random.Generator) -> Scene:
    """Readings a twentieth of a degree to either side of where the joints are."""
    off = np.radians(0.05) * rng.choice([-1.0, 1.0], scene.motion.q.shape)
    return replace(scene, readings=(lambda q: q + off,))


def _steps(scene: Scene, rng: np.random.Generator) -> Scene:
    step = np.radians(_one((0.05, 0.1), rng))
    return replace(scene, readings=(lambda q: np.round(q / step) * step,))


def _many_mm(scene: Scene, rng: np.random.Generator) -> Scene:
    """10 mm of noise."""
    return replace(scene, noise=0.01)


def _bending(scene: Scene, rng: np.random.Generator) -> Scene:
    """Links that give way by 1 to 4 mm at the hand, both ways alike."""
    bent, q = replace(scene.world, bending=1e-3), scene.motion.q
    still = Motion(q, 0 * q, np.zeros(len(q)), np.zeros(len(q)))
    off = bent.poses(still)[:, :3, 3] - scene.world.poses(still)[:, :3, 3]
    size = np.quantile(np.linalg.norm(off, axis=1), 0.95)
    bending = 1e-3 * rng.uniform(1e-3, 4e-3) / size
    return replace(scene, world=replace(scene.world, bending=bending))


def _distorted(scene: Scene, rng: np.random.Generator) -> Scene:
    """1 to 4 mm at the edge of the view, or a lens that is not straight."""
    if scene.sense == "pixels":
        return replace(scene, distortion=_one((-0.05, 0.03, 0.08), rng))
    size = rng.uniform(1e-3, 4e-3)
    sight = sights.quadratic(size) if rng.random() < 0.5 else sights.radial(size)
    return replace(scene, sights=(sight,))


def _hysteresis(scene: Scene, rng: np.random.Generator) -> effects.Effect:
    return effects.hysteresis(np.radians(rng.uniform(0.1, 0.4, len(scene.motion.q.T))))


def _walk(scene: Scene, rng: np.random.Generator) -> Scene:
    """A tracker that wanders by 2 mm or so."""
    steps = rng.normal(size=(40, 6)) / np.sqrt(40)
    path = np.cumsum(steps, axis=0) * np.repeat([2e-3, 1.5e-3], 3)
    return replace(scene, world=replace(scene.world, tracker=(effects.drifting(path),)))


def _warming(scene: Scene, rng: np.random.Generator) -> Scene:
    """Joint zeros creep by 0.05 to 0.2 deg, links grow by 0.2 per mille."""
    by = np.radians(rng.uniform(0.05, 0.2)) * rng.normal(size=len(scene.motion.q.T))
    world = replace(scene.world, effects=(effects.warming(by),), growth=2e-4)
    return replace(scene, world=world)


def _shuffled(scene: Scene, rng: np.random.Generator) -> Scene:
    return replace(scene, noises=sights.remembered(_one((0.9, 0.97), rng)))


THREE_D: tuple[SenseKind, ...] = ("points", "poses")
MOVING = Plan(n=(120,), smooth=(True,))
EITHER = Plan(n=(48, 48, 96), smooth=(False, False, True))

FAULTS: tuple[Fault, ...] = (
    Fault("none", Plan(n=(24, 48, 120)), good=True, weight=5),
    Fault("none, smooth path", Plan(n=(48, 120), smooth=(True,)), good=True, weight=2),
    Fault("none, stated noise", Plan(n=(24, 48, 120), stated=True), good=True, weight=2),
    Fault("random outliers 5-35 %", change=lambda s, r: _sight(
        sights.outliers(r.uniform(0.05, 0.35), 0.2))(s, r)),
    Fault("random outliers 50 %", Plan(n=(48, 96)), _sight(sights.outliers(0.5, 0.2))),
    Fault("20-40 % shifted alike", change=lambda s, r: _sight(
        sights.shifted_alike(r.uniform(0.2, 0.4), 10 ** r.uniform(-2.7, -1.5), False))(s, r)),
    Fault("one corner shifted", change=lambda s, r: _sight(
        sights.shifted_alike(r.uniform(0.2, 0.4), 10 ** r.uniform(-2.7, -1.5), True))(s, r)),
    Fault("AR noise, shuffled", change=_shuffled),
    Fault("AR noise, smooth path", Plan(n=(48, 120), smooth=(True,)), _shuffled),
    Fault("late 50 ms", MOVING, _late(0.05)),
    Fault("late 200 ms", MOVING, _late(0.2)),
    Fault("early", MOVING, _late(-0.05, -0.2)),
    Fault("tracker bumped 2 mm", EITHER, _bumped("tracker", 0.002)),
    Fault("tracker bumped 10 / 50 mm", EITHER, _bumped("tracker", 0.01, 0.05)),
    Fault("encoder slips 0.5 deg", EITHER, _slip(0.5, -0.5)),
    Fault("encoder slips 2 / 10 deg", EITHER, _slip(2, -2, 10, -10)),
    Fault("marker slips 3 / 15 mm", EITHER, _bumped("tool", 0.003, 0.015)),
    Fault("locked or planar", Plan(moving=(2, 3)), weight=1),
    Fault("tiny or small region", Plan(reach=(0.1, 0.4))),
    Fault("8-20 rows", Plan(n=tuple(range(8, 21))), weight=2),
    Fault("mm", change=_in_mm),
    Fault("mirror", change=_declared(sights.mirrored)),
    Fault("swapped axes", change=_declared(sights.axes_swapped)),
    Fault("inverse pose", Plan(("poses",)), _declared(sights.inverted)),
    Fault("quaternion order", Plan(("poses",)), _reordered),
    Fault("swapped columns", change=_columns(True)),
    Fault("flipped column", change=_columns(False)),
    Fault("gear 2 %", change=_gear(0.02, -0.02)),
    Fault("gear 30 %", change=_gear(0.3, -0.3)),
    Fault("sag 0.6 deg", EITHER, _effect(_sag)),
    Fault("gear waves", EITHER, _effect(_waves)),
    Fault("12 postures x 7 frames", Plan(THREE_D, n=(84,), repeats=7),
          _noise(sights.white, sights.by_posture(7)), weight=2),
    Fault("backlash", change=_backlash),
    Fault("encoder steps", change=_steps),
    Fault("uneven noise", change=_noise(sights.uneven)),
    Fault("10 mm noise", change=_many_mm),
    Fault("3 % scale of the robot", change=_scaled_robot(1.03, 0.97)),
    Fault("sensor distortion", EITHER, _distorted, apart=True),
    Fault("bending links", EITHER, _bending, apart=True),
    Fault("hysteresis", MOVING, _effect(_hysteresis), apart=True),
    Fault("drifting tracker", EITHER, _walk, apart=True),
    Fault("warming", EITHER, _warming, apart=True),
    Fault("heavy noise", EITHER, _noise(sights.heavy(2.0), sights.heavy(3.0)), apart=True),
    Fault("stated noise, distortion", replace(EITHER, stated=True), _distorted),
    Fault("stated noise, bending", replace(EITHER, stated=True), _bending),
    Fault("stated noise, waves", replace(EITHER, stated=True), _effect(_waves)),
    Fault("stated noise, warming", replace(EITHER, stated=True), _warming),
)  # fmt: skip
"""All that a recording for `calibrate` may have."""
