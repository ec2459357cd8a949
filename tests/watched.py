"""A tracked point in a short stream, shared by the tests of hand, eye and monitor."""

from __future__ import annotations

import numpy as np

from bodyschema.learners.hand_eye.chart import CameraAndPoints, from_transform
from bodyschema.learners.hand_eye.points import HandEyePoints
from bodyschema.simulation.katana import Noise, Scene, Stream, draw_scene, stereo, stream


def seen(seed: int, seconds: float, noise: float = 0.5, points: int = 1, speed: float = 0.5,
         wrong: Noise | None = None) -> tuple[Scene, Stream]:  # fmt: skip
    """A scene and what the camera sees of it."""
    rng = np.random.default_rng(seed)
    scene = draw_scene(rng, points)
    return scene, stream(scene, seconds, stereo(noise), rng, speed, wrong)


def truth(scene: Scene) -> CameraAndPoints:
    """The unknowns of a scene."""
    return from_transform(scene.T_world_cam, scene.points)


def errors(theta: CameraAndPoints, scene: Scene) -> tuple[float, float, float]:
    """Degrees, mm of the camera, mm of the worst point."""
    away = theta.T_world_cam[:3, 3] - scene.T_world_cam[:3, 3]
    turn = np.linalg.norm(theta.away_from(truth(scene))[:3])
    tips = np.linalg.norm(theta.points - scene.points, axis=1)
    return (
        float(np.degrees(turn)),
        1e3 * float(np.linalg.norm(away)),
        1e3 * float(tips.max()),
    )


def learned(learner: HandEyePoints, seen_stream: Stream, first: int = 0):
    """The learner's state after a stream."""
    state = learner.start()
    for i in range(first, len(seen_stream)):
        state, _ = learner.step(state, (seen_stream.sample(i),))
    return state
