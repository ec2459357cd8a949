"""Watched hands of a simulated iCub: how far off, how honest, and is a lost hand told?

The movements and the robot are those of the studies of Vicente et al. 2016, the models those of
`studies.watched_hand`: the robot's own, or one with coarser meshes and wrong eyes.

reaching   error of the hand's pose at the end of a movement before a cluttered background without
           masks, by the tracker
trust      normalised squared error of that pose, with masks, mean and share of movements within the
           central 95 % of chi-square with 6 degrees of freedom: the robot's own model, taken at its
           word; the same with the default doubts; the fixed wrong model; and wrong models drawn for
           every movement from what is doubted
lost       a hand is fitted in 8 postures, then looked at in others; "told" of "trials" pictures in
           which it is covered, out of view, replaced by another thing, or elsewhere than the
           encoders say, and "false_alarms" of "good" ones in which it is there
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

import bodyschema as bs
from bodyschema import lie
from bodyschema.acting.servoing import pose_error
from bodyschema.learners.images.doubts import Doubts
from bodyschema.learners.images.hand_track import HandTracker, hand_pose
from bodyschema.learners.images.markerless import Markerless
from bodyschema.senses.images import Images, Picture
from bodyschema.simulation import icub
from bodyschema.simulation.seeing_icub import Scene, SeeingIcub
from bodyschema.studies.hand_movements import true_offsets
from bodyschema.studies.hand_summary import within_band
from bodyschema.studies.watched_hand import Believed, Seen, believed, distance, open_loop
from bodyschema.vision.contours import silhouette
from bodyschema.vision.poses import piece_poses

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

FRAMES = 40
"""Of a movement; the studies have 120 of the same way."""
REACHES = 10
"""Movements before the cluttered background."""
FITTED = 8
GOOD, BAD = 20, 5
"""Pictures of each movement that are looked at as they are, and in each bad way."""


def reaching() -> dict[str, Any]:
    """Error before the cluttered background, with the robot's own model and with the wrong one."""
    own, wrong = replace(believed("identical"), doubts=Doubts()), believed("mismatched")
    return compared({"own": lambda i: own, "wrong": lambda i: wrong}, REACHES, "cluttered")


def trust(movements: int = 40) -> dict[str, Any]:
    """Normalised squared errors, with masks."""
    own, wrong = believed("identical"), believed("mismatched")
    doubted = replace(own, doubts=Doubts())
    models = {"own": lambda i: own, "own_doubted": lambda i: doubted, "wrong": lambda i: wrong}
    return compared(models | {"drawn": drawn}, movements, "plain")


def compared(
    models: dict[str, Callable[[int], Believed]], movements: int, scene: Scene
) -> dict[str, Any]:
    """The same pictures for all models."""
    ends = [
        {name: followed(model(i), i, scene) for name, model in models.items()}
        for i in range(movements)
    ]
    return {name: summary([end[name] for end in ends]) for name in models}


@lru_cache(maxsize=2)
def shown(number: int, scene: Scene) -> Seen:
    """A movement as the eyes see it."""
    return open_loop(number, FRAMES, scene)


def drawn(number: int) -> Believed:
    """The coarse meshes, and eyes as wrong as is doubted."""
    rng, mine, doubts = np.random.default_rng([77, number]), believed("identical"), Doubts()
    body, cameras = mine.body, []
    for camera in mine.cameras:
        K = camera.matrix.copy()
        K[[0, 1], [0, 1]] *= 1 + doubts.focal * rng.normal()
        K[:2, 2] += doubts.centre * rng.normal(size=2)
        cameras.append(replace(camera, matrix=K))
        turn = lie.transform(lie.exp_so3(doubts.turn * rng.normal(size=3)), np.zeros(3))
        body = body.with_placement(camera.frame, icub.eye_mounting(camera.frame) @ turn)
    return Believed(body, tuple(cameras), believed("mismatched").surface, doubts)


def followed(mine: Believed, number: int, scene: Scene) -> tuple[Array, float]:
    """Error (mm, degrees) at the end of a movement, and normalised squared error."""
    tracker = bs.ContourTracker(mine.surface, doubts=mine.doubts)
    state, way = tracker.start(mine.body, icub.RIGHT_ARM), shown(number, scene)
    for seen in way.images:
        state, (info,) = tracker.step(state, (replace(seen, cameras=mine.cameras),))
    T, P = hand_pose(info.whole, seen.q, icub.LEFT_EYE, icub.HAND)
    e = pose_error(way.poses[-1], T)
    return distance(way.poses[-1], T), float(e @ np.linalg.solve(P, e))


def summary(ends: list[tuple[Array, float]]) -> dict[str, Any]:
    """Over movements."""
    error, nees = np.array([end[0] for end in ends]), np.array([end[1] for end in ends])
    return {
        "movements": len(ends),
        "position_mm": float(error[:, 0].mean()),
        "orientation_deg": float(error[:, 1].mean()),
        "worst_mm": float(error[:, 0].max()),
        "worst_deg": float(error[:, 1].max()),
        "nees": float(nees.mean()),
        "nees_median": float(np.median(nees)),
        "nees_within": within_band(nees),
    }


def lost(scene: Scene, movements: int = 10) -> dict[str, Any]:
    """How often a lost hand is told, by what was done to it."""
    told: dict[str, list[bool]] = {}
    for number in range(movements):
        for name, flag in looks(scene, number):
            told.setdefault(name, []).append(flag)
    bad = {name: flags for name, flags in told.items() if name != "good"}
    return {
        "trials": sum(map(len, bad.values())),
        "told": sum(map(sum, bad.values())),
        "by_kind": {name: f"{sum(flags)} of {len(flags)}" for name, flags in bad.items()},
        "good": len(told["good"]),
        "false_alarms": sum(told["good"]),
    }


def looks(scene: Scene, number: int) -> Iterator[tuple[str, bool]]:
    """What is seen in a movement, and whether the hand is said to be lost."""
    rng, mine = np.random.default_rng([5, number]), believed("identical")
    frames, other = shown(number, scene).images, shown(number + 1, scene).images
    keys = np.linspace(0, FRAMES - 1, FITTED).round().astype(int)
    free = bs.free_joints(mine.body, ["offsets"], icub.RIGHT_ARM)
    free = free.with_prior(np.full(len(free), np.deg2rad(5)))
    some = [frames[k] for k in keys]
    fit = Markerless(mine.surface, seeds=256).fit(mine.body, free, some)
    tracker = HandTracker.of(fit, some, icub.HAND)
    left = rng.permutation(np.setdiff1d(np.arange(FRAMES), keys))
    for k in left[:GOOD]:
        yield "good", tracker.look(frames[k]).lost
    for k in left[:BAD]:
        for name, pictures in spoiled(tracker, frames[k], other[k], scene, rng).items():
            yield name, tracker.look(replace(frames[k], pictures=pictures)).lost


def spoiled(
    tracker: HandTracker, seen: Images, other: Images, scene: Scene, rng: np.random.Generator
) -> dict[str, tuple[Picture, ...]]:
    """The pictures of a moment in which the hand is not to be seen where it should be."""
    empty = without_arm(seen.q, scene)
    hands, pairs = hand_masks(tracker, seen), list(zip(seen.pictures, empty, strict=True))
    covered, thing = [], []
    for (picture, bare), hand in zip(pairs, hands, strict=True):
        around = cv2.dilate(hand.astype(np.uint8), np.ones((5, 5), np.uint8)) > 0
        covered.append(painted(picture, box(hand), False, rng))
        thing.append(painted(np.where(shaped(around, bare), bare, picture), blob(hand, rng), True,
                             rng))  # fmt: skip
    return {
        "covered": tuple(covered),
        "out of view": empty,
        "another thing": tuple(thing),
        "elsewhere": other.pictures,
    }


def without_arm(q: Array, scene: Scene) -> tuple[Picture, ...]:
    """What the eyes see when the arm hangs down."""
    body, robot = icub.nominal_icub(), SeeingIcub(true_offsets(), scene)
    posture = q.copy()
    for name in icub.RIGHT_ARM:
        j = body.joint_index(name)
        posture[j] = np.clip(0.0, body.lower[j], body.upper[j])
    robot.command(posture)
    return robot.look().pictures


def hand_masks(tracker: HandTracker, seen: Images) -> list[Mask]:
    """Where the hand should be in each picture."""
    model, z = tracker.fit.model, tracker.fit.z
    hand, cameras = bs.Surface.of(model.body, ["r_hand"], 0), model.cameras(seen.cameras, z)
    T = piece_poses(model.posed(z), seen.q, cameras, hand.frames)[0]
    return [silhouette(hand, pose, camera) for pose, camera in zip(T, cameras, strict=True)]


def box(hand: Mask) -> Mask:
    """A rectangle that covers the hand."""
    v, u = np.nonzero(hand)
    cover = np.zeros_like(hand)
    cover[max(v.min() - 3, 0) : v.max() + 4, max(u.min() - 3, 0) : u.max() + 4] = True
    return cover


def blob(hand: Mask, rng: np.random.Generator) -> Mask:
    """An ellipse of the hand's size at its place."""
    v, u = np.nonzero(hand)
    r, a = np.sqrt(hand.sum() / np.pi), rng.uniform(0.7, 1.4)
    drawn_in = np.zeros(hand.shape, dtype=np.uint8)
    axes = int(r * a), int(r / a)
    cv2.ellipse(drawn_in, (int(u.mean()), int(v.mean())), axes, rng.uniform(0, 180), 0, 360, 1, -1)
    return drawn_in > 0


def painted(picture: Picture, where: Mask, body: bool, rng: np.random.Generator) -> Picture:
    """A mask in which that is the body or not, or an image with a pattern there."""
    if picture.dtype == np.bool_:
        return np.where(where, body, picture)
    coarse = rng.integers(0, 256, (24, 32, 3)).astype(np.uint8)
    pattern = cv2.resize(coarse, picture.shape[1::-1], interpolation=cv2.INTER_NEAREST)
    return np.where(where[..., None], pattern, picture)


def shaped(where: Mask, picture: Picture) -> Mask:
    """A mask that selects in pictures with or without channels."""
    return where if picture.ndim == 2 else where[..., None]


def measure() -> dict[str, Any]:
    """All figures."""
    return {
        "reaching": reaching(),
        "trust": trust(),
        "lost": {"masks": lost("plain"), "no_masks": lost("cluttered")},
    }
