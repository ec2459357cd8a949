"""The movements of Vicente et al. 2016: ten beginnings for each of four ends, 60 to 120 mm apart.

The postures are not published. Here an end x_d is the pose that the uncorrected body gives a random
posture; beginnings are postures whose hand is 60 to 120 mm and at most 45 deg away. The posture of
the end is K^-1(x_d), found from the beginning, by the uncorrected body (Eq. 26). A movement counts
if both eyes see the whole hand on all of its way, truly and as believed, and no other part of the
robot. All of it follows from one fixed seed, so that every study and method has the same movements.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.acting.inverse_kinematics import Aim, InverseKinematics
from bodyschema.acting.trajectory import joint_trajectory
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.simulation import eyes, icub
from bodyschema.simulation.seeing_icub import SeeingIcub
from bodyschema.simulation.world import PAPER_OFFSETS_DEG

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

FINALS, INITIALS = 4, 10
SEED = 2016
NEAR, FAR = 0.2, 0.42
"""m from either eye; all marks of the hand lie between."""
SHORTEST, LONGEST = 0.06, 0.12
"""m between the hand at the beginning and at the end, section 5.1.1."""
MOST_TURN = float(np.deg2rad(45))
SPREAD = float(np.deg2rad(14))
"""Standard deviation of the arm's joints at a beginning round those at the end."""
LEAST_ERROR = 0.033
"""m that the offsets move the hand at an end: the largest fifth; the paper's is 44 mm."""
MARGIN = 4.0
"""pixels; marks are at least as far from the border of the image."""
CHEST = 0.12
"""m that every mark stays before the chest."""
HEAD = {"neck_pitch": float(np.deg2rad(-20)), "neck_yaw": float(np.deg2rad(-20))}
"""The head stands still, turned to where the right hand works."""
PLACES = 7
"""Places on the way where a movement is looked at."""


@dataclass(frozen=True)
class Movement:
    """From one posture to an aim."""

    q_i: Array
    """(n_joints,) encoder readings at the beginning."""
    q_d: Array
    """(n_joints,) where the uncorrected body sends the joints."""
    T_d: Array
    """(4, 4) x_d, pose of the hand in the left eye."""

    @property
    def aim(self) -> Aim:
        """x_d as an aim."""
        return Aim(icub.LEFT_EYE, icub.HAND, self.T_d[:3, 3], self.T_d[:3, :3])


def true_offsets() -> dict[str, float]:
    """beta of the paper's simulations by joint, rad."""
    return {name: float(np.deg2rad(deg)) for name, deg in PAPER_OFFSETS_DEG.items()}


def movement(number: int) -> Movement:
    """Movement 0 to 39; the ends take turns."""
    return movements_to(number % FINALS)[number // FINALS]


@cache
def movements_to(final: int) -> tuple[Movement, ...]:
    """The ten movements to one end."""
    body, robot = icub.nominal_icub(), SeeingIcub(true_offsets())
    q_f = _ends()[final]
    T_d = relative_pose(body, q_f, icub.LEFT_EYE, icub.HAND)
    found: list[Movement] = []
    for q_i in _beginnings(body, q_f, T_d, np.random.default_rng([SEED, 1 + final])):
        aim = Aim(icub.LEFT_EYE, icub.HAND, T_d[:3, 3], T_d[:3, :3])
        reached = InverseKinematics(starts=0).solve(body, aim, q_i, icub.RIGHT_ARM)
        way = joint_trajectory(q_i, reached.q, PLACES)
        if reached.converged and _shows(body, way).all() and _alone(robot, way):
            found.append(Movement(q_i, reached.q, T_d))
        if len(found) == INITIALS:
            break
    return tuple(found)


@cache
def _ends() -> Array:
    """(4, n_joints) postures, their hands far apart in place and direction."""
    body, robot = icub.nominal_icub(), SeeingIcub(true_offsets())
    rng = np.random.default_rng([SEED, 0])
    q = _arm_at_random(body, 12_000, rng)
    q = q[_shows(body, q)]
    T = relative_pose(body, q, icub.LEFT_EYE, icub.HAND)
    moved = relative_pose(body, _with_offsets(body, q, true_offsets()), icub.LEFT_EYE, icub.HAND)
    far = np.linalg.norm(moved[:, :3, 3] - T[:, :3, 3], axis=1) > LEAST_ERROR
    far[far] = [_alone(robot, posture[None]) for posture in q[far]]
    q, T = q[far], T[far]
    # One metre of distance counts as much as three radians: the hand turns in a space of 0.3 m.
    features = np.concatenate([T[:, :3, 3], 0.3 * T[:, :3, :3].reshape(-1, 9) / np.sqrt(2)], axis=1)
    chosen = [int(np.argmin(np.linalg.norm(features - features.mean(axis=0), axis=1)))]
    while len(chosen) < FINALS:
        apart = np.linalg.norm(features[:, None] - features[chosen], axis=2).min(axis=1)
        # Neither the farthest, which stand at the border of what can be seen, nor a near one.
        chosen.append(int(np.argsort(apart)[int(0.8 * len(apart))]))
    return np.asarray(q[chosen])


@cache
def visible_postures(draws: int, seed: int) -> Array:
    """Postures (n, n_joints) in which the eyes see the whole hand and no other part of the robot.

    Args:
        draws: random arms that are tried; about one in forty passes.
        seed: of the draws.
    """
    robot = SeeingIcub(true_offsets())
    q = _arm_at_random(icub.nominal_icub(), draws, np.random.default_rng([SEED, 9, seed]))
    q = q[_shows(icub.nominal_icub(), q)]
    return np.asarray(q[[_alone(robot, posture[None]) for posture in q]])


def _beginnings(body: Body, q_f: Array, T_d: Array, rng: np.random.Generator) -> Iterator[Array]:
    """Postures whose hand is as far from the end as a beginning's should be, for ever."""
    columns = [body.joint_index(name) for name in icub.RIGHT_ARM]
    while True:
        q = np.tile(q_f, (500, 1))
        q[:, columns] += SPREAD * rng.normal(size=(len(q), len(columns)))
        q = np.clip(q, body.lower, body.upper)
        T = relative_pose(body, q, icub.LEFT_EYE, icub.HAND)
        away = np.linalg.norm(T[:, :3, 3] - T_d[:3, 3], axis=1)
        turned = np.linalg.norm(lie.log_so3(T[:, :3, :3] @ T_d[:3, :3].T), axis=1)
        fits = (away > SHORTEST) & (away < LONGEST) & (turned < MOST_TURN)
        yield from q[fits & _shows(body, q)]


def _arm_at_random(body: Body, n: int, rng: np.random.Generator) -> Array:
    """Postures (n, n_joints) with a random right arm; what else moves but the head is near zero."""
    q = np.tile(np.clip(0.0, body.lower, body.upper), (n, 1))
    for name, angle in HEAD.items():
        q[:, body.joint_index(name)] = angle
    columns = [body.joint_index(name) for name in icub.RIGHT_ARM]
    low, high = body.lower[columns], body.upper[columns]
    margin = 0.1 * (high - low)
    q[:, columns] = rng.uniform(low + margin, high - margin, (n, len(columns)))
    return q


def _shows(body: Body, q: Array) -> Flags:
    """Whether both eyes see all marks of the hand, with and without the offsets; (n,)."""
    left = np.arange(len(q))
    for mark in icub.LANDMARKS:
        for beta in ({}, true_offsets()):
            # Most postures fail at the first mark; only the others are looked at further.
            left = left[_mark_shows(body, q[left], mark, beta)]
    good = np.zeros(len(q), dtype=bool)
    good[left] = True
    return good


def _mark_shows(body: Body, q: Array, mark: str, beta: Mapping[str, float]) -> Flags:
    """Whether both eyes see one mark before the chest, (n,)."""
    shifted = _with_offsets(body, q, beta)
    good = np.asarray(relative_pose(body, shifted, "chest", mark)[:, 2, 3] > CHEST)
    for eye in (icub.LEFT_EYE, icub.RIGHT_EYE):
        p_eye = relative_pose(body, shifted, eye, mark)[:, :3, 3]
        good &= eyes.in_view(p_eye, NEAR, FAR, MARGIN)
    return good


def _with_offsets(body: Body, q: Array, beta: Mapping[str, float]) -> Array:
    """The readings of some joints moved by their offsets, (n, n_joints)."""
    shifted = q.copy()
    for name, angle in beta.items():
        shifted[:, body.joint_index(name)] += angle
    return shifted


def _alone(robot: SeeingIcub, way: Array) -> bool:
    """Whether nothing of the robot but hand, wrist and forearm shows on the way."""
    for q in way:
        robot.command(q)
        if robot.hidden_share() > 0:
            return False
    return True
