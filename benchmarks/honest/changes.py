"""Changes: what a fault makes of a scene."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from honest import effects, sights
from honest.scene import Scene
from honest.world import Motion

Change = Callable[[Scene, np.random.Generator], Scene]


def unchanged(scene: Scene, rng: np.random.Generator) -> Scene:
    """Nothing is wrong."""
    return scene


def _one(options: Any, rng: np.random.Generator) -> Any:
    return options[int(rng.integers(len(options)))]


def _joint(scene: Scene, rng: np.random.Generator) -> int:
    """One of those that move."""
    return int(rng.choice(np.flatnonzero(np.ptp(scene.motion.q, axis=0) > 1e-6)))


def sight(*options: sights.Sight) -> Change:
    return lambda scene, rng: replace(scene, sights=(_one(options, rng),))


def noise(*options: sights.Noise) -> Change:
    return lambda scene, rng: replace(scene, noises=_one(options, rng))


def late(*seconds: float) -> Change:
    return lambda scene, rng: replace(scene, late=_one(seconds, rng))


def effect(make: Callable[[Scene, np.random.Generator], effects.Effect]) -> Change:
    def changed(scene: Scene, rng: np.random.Generator) -> Scene:
        return replace(scene, world=replace(scene.world, effects=(make(scene, rng),)))

    return changed


def declared(*options: Any) -> Change:
    return lambda scene, rng: replace(scene, declared=(_one(options, rng),))


def bumped(frame: str, *sizes: float) -> Change:
    """The tracker or the tool jumps half way by so many m, and turns by as many rad or more."""

    def changed(scene: Scene, rng: np.random.Generator) -> Scene:
        size = _one(sizes, rng)
        turn = size * (1.0 if frame == "tracker" else 5.0) * effects.direction(rng)
        move = effects.moved(np.concatenate([size * effects.direction(rng), turn]))
        return replace(scene, world=replace(scene.world, **{frame: (move,)}))

    return changed


def reordered(scene: Scene, rng: np.random.Generator) -> Scene:
    """Quaternions in another order; it shows 10 cm from the tool's origin."""
    return replace(scene, declared=(sights.reordered,), tip=0.1)


def slip(*degrees: float) -> Change:
    return effect(
        lambda scene, rng: effects.slip(_joint(scene, rng), np.radians(_one(degrees, rng)))
    )


def gear(*shares: float) -> Change:
    return effect(lambda scene, rng: effects.geared(_joint(scene, rng), _one(shares, rng)))


def sag(scene: Scene, rng: np.random.Generator) -> effects.Effect:
    """0.6 deg at most in one or two joints that carry something."""
    n = len(scene.motion.q.T)
    q = scene.arm.home + rng.uniform(-1.2, 1.2, (200, n))
    among = Motion(q, 0 * q, np.zeros(200), np.zeros(200))
    torque = np.abs(scene.world.torques(among)).max(axis=0)
    loaded = np.argsort(-torque)[:3]
    softness = np.zeros(n)
    softness[rng.choice(loaded, rng.integers(1, 3), replace=False)] = np.radians(0.6)
    return effects.sag(scene.world, softness, among)


def waves(scene: Scene, rng: np.random.Generator) -> effects.Effect:
    n = len(scene.motion.q.T)
    size = np.radians(rng.uniform(0.1, 0.4, n))
    if rng.random() < 0.5:
        size *= np.arange(n) == _joint(scene, rng)
    return effects.waves(size, rng.integers(1, 4, n), rng.uniform(-np.pi, np.pi, n))


def columns(swap: bool) -> Change:
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

    return effect(make)


def in_mm(scene: Scene, rng: np.random.Generator) -> Scene:
    """What was seen in another unit, or the robot."""
    factor = _one((1000.0, 1000.0, 0.001, 100.0, 0.0254), rng)
    if scene.sense == "pixels" or rng.random() < 0.3:
        return scaled_robot(factor)(scene, rng)
    return replace(scene, declared=(sights.scaled(factor),))


def scaled_robot(*factors: float) -> Change:
    """The description's links so many times as long as the robot's."""

    def changed(scene: Scene, rng: np.random.Generator) -> Scene:
        placement = scene.given.placement.copy()
        links = [k for k, name in enumerate(scene.given.frames) if name not in ("tracker", "tool")]
        placement[links, :3, 3] *= _one(factors, rng)
        return replace(scene, given=replace(scene.given, placement=placement))

    return changed


def backlash(scene: Scene, rng: np.random.Generator) -> Scene:
    """Readings a twentieth of a degree to either side of where the joints are."""
    off = np.radians(0.05) * rng.choice([-1.0, 1.0], scene.motion.q.shape)
    return replace(scene, readings=(lambda q: q + off,))


def steps(scene: Scene, rng: np.random.Generator) -> Scene:
    step = np.radians(_one((0.05, 0.1), rng))
    return replace(scene, readings=(lambda q: np.round(q / step) * step,))


def many_mm(scene: Scene, rng: np.random.Generator) -> Scene:
    """10 mm of noise."""
    return replace(scene, noise=0.01)


def bending(scene: Scene, rng: np.random.Generator) -> Scene:
    """Links that give way by 1 to 4 mm at the hand, both ways alike."""
    bent, q = replace(scene.world, bending=1e-3), scene.motion.q
    still = Motion(q, 0 * q, np.zeros(len(q)), np.zeros(len(q)))
    off = bent.poses(still)[:, :3, 3] - scene.world.poses(still)[:, :3, 3]
    size = np.quantile(np.linalg.norm(off, axis=1), 0.95)
    bending = 1e-3 * rng.uniform(1e-3, 4e-3) / size
    return replace(scene, world=replace(scene.world, bending=bending))


def distorted(scene: Scene, rng: np.random.Generator) -> Scene:
    """1 to 4 mm at the edge of the view, or a lens that is not straight."""
    if scene.sense == "pixels":
        return replace(scene, distortion=_one((-0.05, 0.03, 0.08), rng))
    size = rng.uniform(1e-3, 4e-3)
    sight = sights.quadratic(size) if rng.random() < 0.5 else sights.radial(size)
    return replace(scene, sights=(sight,))


def hysteresis(scene: Scene, rng: np.random.Generator) -> effects.Effect:
    return effects.hysteresis(np.radians(rng.uniform(0.1, 0.4, len(scene.motion.q.T))))


def walk(scene: Scene, rng: np.random.Generator) -> Scene:
    """A tracker that wanders by 2 mm or so."""
    steps = rng.normal(size=(40, 6)) / np.sqrt(40)
    path = np.cumsum(steps, axis=0) * np.repeat([2e-3, 1.5e-3], 3)
    return replace(scene, world=replace(scene.world, tracker=(effects.drifting(path),)))


def warming(scene: Scene, rng: np.random.Generator) -> Scene:
    """Joint zeros creep by 0.05 to 0.2 deg, links grow by 0.2 per mille."""
    by = np.radians(rng.uniform(0.05, 0.2)) * rng.normal(size=len(scene.motion.q.T))
    world = replace(scene.world, effects=(effects.warming(by),), growth=2e-4)
    return replace(scene, world=world)


def remembering(scene: Scene, rng: np.random.Generator) -> Scene:
    return replace(scene, noises=sights.remembered(_one((0.9, 0.97), rng)))
