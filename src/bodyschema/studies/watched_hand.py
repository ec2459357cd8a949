"""One movement of Vicente et al. 2016: an open loop that is watched, then a closed loop.

Poses of the hand in the left eye, and errors between two of them (Eq. 32-40):

    x^r real, x^d desired, x^e estimated = K(theta + beta^), x^n = K(theta) without adaptation
    d(A, B) = (|P_A - P_B| in mm, rotation angle of R_A^T R_B in degrees)

    estimation d(x^r, x^e)     real reaching d(x^d, x^r)     estimated reaching d(x^d, x^e)

The open loop goes to K^-1(x^d) of the uncorrected body whatever the eyes see, so its images are the
same for every method, particle count and seed. The closed loop goes on from there by the estimate.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.acting.servoing import Servoing, pose_error
from bodyschema.acting.trajectory import joint_trajectory
from bodyschema.learners.images.contour_tracker import TrackInfo
from bodyschema.learners.images.doubts import Doubts
from bodyschema.learners.images.hand_track import hand_pose
from bodyschema.model.camera import Camera
from bodyschema.model.kinematics import frame_jacobian, relative_pose
from bodyschema.model.tree import Body
from bodyschema.senses.images import Images
from bodyschema.simulation import icub
from bodyschema.simulation.seeing_icub import SEEN_LINKS, Scene, SeeingIcub, stereo_eyes
from bodyschema.studies.hand_methods import Method, OffsetInfo
from bodyschema.studies.hand_movements import Movement, movement, true_offsets
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]
Model = Literal["identical", "mismatched"]

COARSE = {"r_hand": 300, "r_forearm": 618, "r_wrist_1": 200}
"""Faces of the mismatched model; the robot has 364, 1033 and 617."""
FOCAL, CENTRE, YAW = 1.005, 1.0, float(np.deg2rad(0.1))
"""Mismatch: factor of the focal length, pixels of the principal point, yaw of each eye in rad."""
EXACT = Doubts(focal=0.0, centre=0.0, turn=0.0, shape=0.0)
"""Where model and robot are the same."""


@dataclass(frozen=True)
class Believed:
    """What the robot imagines with: its body, its cameras, its shape."""

    body: Body
    cameras: tuple[Camera, ...]
    surface: Surface
    doubts: Doubts
    """What it knows that it may have wrong."""


@dataclass(frozen=True)
class Seen:
    """An open loop: what the eyes saw and where the hand truly was."""

    images: Sequence[Images]
    poses: Array
    """(n_frames, 4, 4) x^r."""


@dataclass
class Trace:
    """What a study keeps of every frame."""

    estimation: list[Array]
    without: list[Array]
    reaching: list[Array]
    believed_reaching: list[Array]
    sizes: list[float]
    """Effective sample size over the particle count."""
    nees: list[float]
    seconds: float
    """Processor time of the learner alone; without its first frame, in which it may be compiled."""


@lru_cache(maxsize=2)
def believed(model: Model) -> Believed:
    """The model without a mismatch, as in the paper, or with an honest one."""
    body, cameras = icub.nominal_icub(), stereo_eyes()
    if model == "identical":
        return Believed(body, cameras, Surface.of(body, SEEN_LINKS, 0), EXACT)
    for camera in cameras:
        T = icub.eye_mounting(camera.frame)
        turn = lie.transform(lie.exp_so3([0.0, YAW, 0.0]), np.zeros(3))
        body = body.with_placement(camera.frame, T @ turn)
    wrong = np.diag([FOCAL, FOCAL, 1.0])
    lenses = tuple(
        replace(camera, matrix=wrong @ camera.matrix + _shift(camera)) for camera in cameras
    )
    return Believed(body, lenses, Surface.of(body, SEEN_LINKS, COARSE), Doubts())


def _shift(camera: Camera) -> Array:
    """What is left to add, so that the centre is CENTRE off and not scaled."""
    c_x, c_y = camera.intrinsics[2:]
    shift = np.zeros((3, 3))
    shift[:2, 2] = CENTRE + (1 - FOCAL) * c_x, (1 - FOCAL) * c_y
    return shift


@lru_cache(maxsize=1)
def open_loop(number: int, frames: int, scene: Scene) -> Seen:
    """Movement `number` as the real eyes see it; the last one is kept, for the next learner."""
    way, robot = movement(number), SeeingIcub(true_offsets(), scene)
    images, poses = [], []
    for q in joint_trajectory(way.q_i, way.q_d, frames):
        robot.command(q)
        images.append(robot.look())
        poses.append(robot.true_pose(icub.LEFT_EYE, icub.HAND))
    return Seen(images, np.array(poses))


def watch(
    method: Method,
    number: int,
    scene: Scene,
    model: Model,
    particles: int,
    seed: int,
    frames: int,
    closed_frames: int,
    servoing: Servoing,
) -> Trace:
    """Learn during the open loop of a movement, then go on by what is learned.

    Args:
        method: who learns.
        number: of the movement.
        scene: what is behind the hand.
        model: what the robot imagines with.
        particles: of the method.
        seed: of the method.
        frames: of the open loop.
        closed_frames: of the closed loop.
        servoing: settings of the closed loop.
    """
    mine, way = believed(model), movement(number)
    learner = method.build(mine.surface, scene, particles, seed, mine.doubts)
    state = learner.start(mine.body, icub.RIGHT_ARM)
    trace = Trace([], [], [], [], [], [], 0.0)
    seen = open_loop(number, frames, scene)
    for images, x_r in zip(seen.images, seen.poses, strict=True):
        state, info = _learn(learner, state, images, mine, trace)
        _note(trace, mine.body, way, images.q, info, x_r, particles)
    robot = SeeingIcub(true_offsets(), scene)
    robot.command(seen.images[-1].q)
    for _ in range(closed_frames):
        adapted = hand_belief(mine.body, info, images.q).body
        sure = info.covariance if method.gated else None
        robot.command(servoing.step(adapted, robot.read(), [way.aim], icub.RIGHT_ARM, sure).q)
        images = robot.look()
        state, info = _learn(learner, state, images, mine, trace)
        x_r = robot.true_pose(icub.LEFT_EYE, icub.HAND)
        _note(trace, mine.body, way, images.q, info, x_r, particles)
    return trace


def adapt(body: Body, offsets: Array) -> Body:
    """The body with the offsets of the right arm, (7,) rad, added."""
    beta = body.offset.copy()
    beta[[body.joint_index(name) for name in icub.RIGHT_ARM]] += offsets
    return replace(body, offset=beta)


def distance(T_a: Array, T_b: Array) -> Array:
    """(*batch, 2) mm and degrees between poses (Eq. 33-34)."""
    e = pose_error(T_a, T_b)
    metres, turn = np.linalg.norm(e[..., :3], axis=-1), np.linalg.norm(e[..., 3:], axis=-1)
    return np.stack([1e3 * metres, np.rad2deg(turn)], axis=-1)


def _learn(
    learner: Any, state: Any, images: Images, mine: Believed, trace: Trace
) -> tuple[Any, OffsetInfo]:
    """One step with what the robot believes of its cameras; adds to the learner's time."""
    begin = time.process_time()
    state, (info,) = learner.step(state, (replace(images, cameras=mine.cameras),))
    took = time.process_time() - begin
    trace.seconds = took if len(trace.sizes) == 1 else trace.seconds + took
    return state, info


def _note(
    trace: Trace, body: Body, way: Movement, q: Array, info: OffsetInfo, x_r: Array, particles: int
) -> None:
    """Add the errors of one frame."""
    mine = hand_belief(body, info, q)
    x_e, x_n = mine.pose, relative_pose(body, q, icub.LEFT_EYE, icub.HAND)
    trace.estimation.append(distance(x_r, x_e))
    trace.without.append(distance(x_r, x_n))
    trace.reaching.append(distance(way.T_d, x_r))
    trace.believed_reaching.append(distance(way.T_d, x_e))
    trace.sizes.append(info.effective_size / particles)
    e = pose_error(x_r, x_e)
    trace.nees.append(float(e @ np.linalg.solve(mine.covariance, e)))


@dataclass(frozen=True)
class HandBelief:
    """What was learned, at one posture."""

    body: Body
    pose: Array
    """(4, 4) x^e."""
    covariance: Array
    """(6, 6) of its twist (m, rad) in the left eye."""


def hand_belief(body: Body, info: OffsetInfo, q: Array) -> HandBelief:
    """By the offsets, and by the turns of the eyes where those were learned along with them."""
    eye, hand = icub.LEFT_EYE, icub.HAND
    if isinstance(info, TrackInfo):
        return HandBelief(info.whole.body, *hand_pose(info.whole, q, eye, hand))
    adapted = adapt(body, info.offsets)
    columns = [body.joint_index(name) for name in icub.RIGHT_ARM]
    J = frame_jacobian(adapted, q, eye, hand)[:, columns]
    return HandBelief(adapted, relative_pose(adapted, q, eye, hand), J @ info.covariance @ J.T)
