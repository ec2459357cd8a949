"""One meeting of both hands: an open loop that is watched, then a closed loop of both arms.

Each arm has a learner of its own, as in the paper; the eyes tell them apart before a plain
background. With x^r, x^d, x^e the poses of a hand in the left eye as in `watched_hand`, and t the
tips of the index fingers, a frame notes

    gap      |t_right - t_left|, true
    between  d(x^d_left^-1 x^d_right, x^r_left^-1 x^r_right): how the hands stand to each other
    reaching, estimation    d(x^d, x^r) and d(x^r, x^e) of each hand
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.acting.servoing import Servoing
from bodyschema.acting.trajectory import joint_trajectory
from bodyschema.learners.images.contour_tracker import TrackInfo
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.simulation import icub
from bodyschema.simulation.seeing_icub import Scene, SeeingIcub
from bodyschema.studies.hand_methods import Method, OffsetInfo
from bodyschema.studies.meeting_hands import (
    ARMS,
    Arm,
    Meeting,
    both_offsets,
    fingertips,
    meeting,
)
from bodyschema.studies.watched_hand import COARSE, Believed, Model, believed, distance
from bodyschema.vision.surface import Surface

Array = NDArray[np.float64]


@dataclass
class MeetingTrace:
    """What a study keeps of every frame."""

    gap: list[float]
    """mm"""
    between: list[Array]
    """(2,) mm and degrees."""
    reaching: list[Array]
    """(2 arms, 2) mm and degrees."""
    estimation: list[Array]
    """(2 arms, 2) mm and degrees."""
    q: list[Array]
    """(n_joints,) rad, encoder readings."""


@dataclass
class _Watcher:
    """The learner of one arm."""

    arm: Arm
    learner: Any
    state: Any
    body: Body
    """What it believes by now; the turns of the eyes are its own too, where it learns them."""
    info: OffsetInfo | None = None

    def look(self, robot: SeeingIcub, mine: Believed) -> None:
        """Learn from one frame."""
        seen = replace(robot.look(self.arm.links), cameras=mine.cameras)
        self.state, (self.info,) = self.learner.step(self.state, (seen,))
        if isinstance(self.info, TrackInfo):
            self.body = self.info.whole.body
        elif self.info is not None:
            self.body = _adapted(mine.body, self.arm, self.info.offsets)


def watch_meeting(
    method: Method,
    number: int,
    scene: Scene,
    model: Model,
    particles: int,
    seed: int,
    frames: int,
    closed_frames: int,
    servoing: Servoing,
) -> MeetingTrace:
    """Learn both arms during the open loop of a meeting, then go on by what is learned.

    Args:
        method: who learns.
        number: of the meeting.
        scene: what is behind the hands.
        model: what the robot imagines with.
        particles: of each learner.
        seed: of the first learner; the second has the next.
        frames: of the open loop.
        closed_frames: of the closed loop.
        servoing: settings of the closed loop.
    """
    mine, way, surfaces = believed(model), meeting(number), _surfaces(model)
    robot, trace = SeeingIcub(both_offsets(), scene), MeetingTrace([], [], [], [], [])
    watchers = []
    for i, (arm, surface) in enumerate(zip(ARMS, surfaces, strict=True)):
        learner = method.build(surface, scene, particles, seed + i, mine.doubts)
        watchers.append(_Watcher(arm, learner, learner.start(mine.body, arm.joints), mine.body))
    for q in joint_trajectory(way.q_i, way.q_d, frames):
        robot.command(q)
        _look(robot, watchers, mine, way, trace)
    for _ in range(closed_frames):
        robot.command(_next(robot.read(), watchers, way, servoing, method.gated))
        _look(robot, watchers, mine, way, trace)
    return trace


def _next(
    q: Array, watchers: Sequence[_Watcher], way: Meeting, servoing: Servoing, gated: bool
) -> Array:
    """The next command (n_joints,): each arm by what its own learner knows."""
    there = q.copy()
    for watcher, aim in zip(watchers, way.aims, strict=True):
        joints = watcher.arm.joints
        sure = watcher.info.covariance if gated and watcher.info is not None else None
        columns = [watcher.body.joint_index(name) for name in joints]
        there[columns] = servoing.step(watcher.body, q, [aim], joints, sure).q[columns]
    return there


def _look(
    robot: SeeingIcub,
    watchers: Sequence[_Watcher],
    mine: Believed,
    way: Meeting,
    trace: MeetingTrace,
) -> None:
    """One frame: both learners see it, its errors are noted."""
    q, x_e = robot.read(), []
    for watcher in watchers:
        watcher.look(robot, mine)
        x_e.append(relative_pose(watcher.body, q, icub.LEFT_EYE, watcher.arm.hand))
    x_r = np.array([robot.true_pose(icub.LEFT_EYE, arm.hand) for arm in ARMS])
    tips = fingertips(x_r)
    trace.gap.append(1e3 * float(np.linalg.norm(tips[0] - tips[1])))
    trace.between.append(distance(_right_in_left(way.T_d), _right_in_left(x_r)))
    trace.reaching.append(distance(way.T_d, x_r))
    trace.estimation.append(distance(x_r, np.array(x_e)))
    trace.q.append(q)


def _right_in_left(T_eye_hand: Array) -> Array:
    """(4, 4) pose of the right hand in the left one."""
    return np.asarray(lie.inverse(T_eye_hand[1]) @ T_eye_hand[0])


def _adapted(body: Body, arm: Arm, offsets: Array) -> Body:
    """The body with the offsets of an arm, (7,) rad, added."""
    beta = body.offset.copy()
    beta[[body.joint_index(name) for name in arm.joints]] += offsets
    return replace(body, offset=beta)


@lru_cache(maxsize=2)
def _surfaces(model: Model) -> tuple[Surface, ...]:
    """What shows of each arm, as imagined."""
    body = believed(model).body
    return tuple(Surface.of(body, arm.links, _faces(model, arm.links)) for arm in ARMS)


def _faces(model: Model, links: tuple[str, ...]) -> int | Mapping[str, int]:
    """Of a mismatched model as many as on the right side; otherwise those of the robot."""
    return 0 if model == "identical" else {link: COARSE["r" + link[1:]] for link in links}
