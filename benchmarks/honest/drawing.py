"""Drawing: scenes without a fault, from what a plan allows."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import lie
from bodyschema.model.parts import lens
from bodyschema.model.tree import Body
from honest.arms import Arm, arms
from honest.effects import direction
from honest.paths import Path, Smooth, Stops
from honest.scene import Scene, SenseKind, in_view
from honest.world import Motion, World

Array = NDArray[np.float64]

CAMERA = bs.Camera(
    "eye", "tracker", 640, 480, np.array([[500.0, 0, 320], [0, 500, 240], [0, 0, 1]])
)
BOARD = 0.03 * np.array([[1.0, 1, 0], [1, -1, 0], [-1, -1, 0], [-1, 1, 0]])
"""(4, 3) m, corners of a tag on the tool."""


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
    # The tip sits on the last link as said: a fixed joint is nothing that could be calibrated.
    placement[1 : n + 1, :3, 3] += links * rng.normal(size=(n + 1, 3))[:n]
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
