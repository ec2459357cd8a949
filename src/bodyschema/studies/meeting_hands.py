"""Both hands of the iCub on their way to each other, as in Fig. 12-13 of Vicente et al. 2016.

In the paper's experiment the hands end palm to palm, 12 cm apart. With the torso straight the arms
are mirror images: the same readings put both hands at the same distance from the plane through the
robot's middle, which is y = 0 of the root link. An end is a posture in which the palms face that
plane and the tips of the index fingers are 6 cm from it; beginnings are postures whose hands are
60 to 120 mm away from there. Everything follows from one fixed seed.

A meeting counts if both eyes see both hands on all of the way, truly and as believed, if the hands
do not touch, and if no part of the robot but hands, wrists and forearms shows.
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
from bodyschema.simulation.seeing_icub import LEFT_LINKS, SEEN_LINKS, SeeingIcub
from bodyschema.simulation.world import PAPER_OFFSETS_DEG

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

ENDS, BEGINNINGS = 5, 2
SEED = 2016
APART = 0.12
"""m between the tips of the index fingers, section 5.3."""
NEAR, FAR = 0.2, 0.42
"""m from either eye; all marks of the hands lie between."""
SHORTEST, LONGEST = 0.06, 0.12
"""m that each hand has to go."""
SPREAD = float(np.deg2rad(10))
"""Standard deviation of the arms' joints at a beginning round those at the end."""
CLEAR = 0.03
"""m; marks of one hand stay at least so far from those of the other."""
MARGIN = 4.0
"""pixels; marks are at least as far from the border of the image."""
FACING = 0.85
"""Cosine between the normal of a palm and the plane's, of postures that are made exact."""
NECK_PITCH = float(np.deg2rad(-20))
PLACES = 5
"""Places on the way where a meeting is looked at."""
DRAWS = 60_000

LEFT_OFFSETS_DEG = dict(zip(icub.LEFT_ARM, (-4.0, 3.0, -5.0, 3.0, -4.0, 6.0, -3.0), strict=True))
"""The paper tells none of its real robot; these are as large as those of its simulated arm."""


@dataclass(frozen=True)
class Arm:
    """One side of the robot."""

    joints: tuple[str, ...]
    hand: str
    links: tuple[str, ...]
    """What shows of it."""
    side: float
    """x of the hand's frame points away from its fingers on the right (1), along them on the left
    (-1)."""

    @property
    def marks(self) -> Array:
        """(4, 3) m in the hand: thumb, index finger, little finger, edge of the wrist."""
        return np.array(list(icub.LANDMARKS.values())) * [self.side, 1.0, 1.0]

    @property
    def fingertip(self) -> Array:
        """(3,) m in the hand, the tip of the index finger."""
        return np.asarray(self.marks[1])


ARMS = (
    Arm(icub.RIGHT_ARM, icub.HAND, SEEN_LINKS, 1.0),
    Arm(icub.LEFT_ARM, icub.LEFT_HAND, LEFT_LINKS, -1.0),
)
"""Right, left."""


@dataclass(frozen=True)
class Meeting:
    """From one posture to two aims."""

    q_i: Array
    """(n_joints,) encoder readings at the beginning."""
    q_d: Array
    """(n_joints,) where the uncorrected body sends the joints."""
    T_d: Array
    """(2, 4, 4) x_d, poses of the right and of the left hand in the left eye."""

    @property
    def aims(self) -> list[Aim]:
        """Both x_d as aims."""
        return [
            Aim(icub.LEFT_EYE, arm.hand, T[:3, 3], T[:3, :3])
            for arm, T in zip(ARMS, self.T_d, strict=True)
        ]


def both_offsets() -> dict[str, float]:
    """True joint angle minus reading of both arms, rad."""
    return {
        name: float(np.deg2rad(d)) for name, d in (PAPER_OFFSETS_DEG | LEFT_OFFSETS_DEG).items()
    }


def meeting(number: int) -> Meeting:
    """Meeting 0 to 9; the ends take turns."""
    return _meetings_at(number % ENDS)[number // ENDS]


def fingertips(T_eye_hand: Array) -> Array:
    """(2, 3) m in the eye, of poses (2, 4, 4) of the right and of the left hand."""
    return np.array(
        [T[:3, :3] @ arm.fingertip + T[:3, 3] for arm, T in zip(ARMS, T_eye_hand, strict=True)]
    )


@cache
def _meetings_at(end: int) -> tuple[Meeting, ...]:
    """The meetings at one end."""
    body, robot = icub.nominal_icub(), _robot()
    q_d = _ends()[end]
    T_d = np.array([relative_pose(body, q_d, icub.LEFT_EYE, arm.hand) for arm in ARMS])
    found: list[Meeting] = []
    for q_i in _beginnings(body, q_d, np.random.default_rng([SEED, 13, end])):
        way = joint_trajectory(q_i, q_d, PLACES)
        if _shows(body, way).all() and _alone(robot, way):
            found.append(Meeting(q_i, q_d, T_d))
        if len(found) == BEGINNINGS:
            break
    return tuple(found)


@cache
def _ends() -> Array:
    """(ENDS, n_joints) postures with palm to palm."""
    body, robot = icub.nominal_icub(), _robot()
    rng = np.random.default_rng([SEED, 12])
    found: list[Array] = []
    for q in _nearly_facing(body, rng):
        exact = _made_exact(body, q)
        if exact is not None and _shows(body, exact[None]).all() and _alone(robot, exact[None]):
            found.append(exact)
        if len(found) == ENDS:
            break
    return np.array(found)


def _nearly_facing(body: Body, rng: np.random.Generator) -> Array:
    """Random mirrored postures (n, n_joints) near to what an end is."""
    q = np.tile(np.clip(0.0, body.lower, body.upper), (DRAWS, 1))
    q[:, body.joint_index("neck_pitch")] = NECK_PITCH
    columns = [[body.joint_index(name) for name in arm.joints] for arm in ARMS]
    low, high = body.lower[columns[0]], body.upper[columns[0]]
    margin = 0.1 * (high - low)
    q[:, columns[0]] = q[:, columns[1]] = rng.uniform(low + margin, high - margin, (DRAWS, 7))
    T = relative_pose(body, q, body.frames[0], icub.HAND)
    tip = T[:, :3, :3] @ ARMS[0].fingertip + T[:, :3, 3]
    return np.asarray(q[(np.abs(tip[:, 1] - APART / 2) < 0.03) & (T[:, 1, 1] > FACING)])


def _made_exact(body: Body, q: Array) -> Array | None:
    """The nearest posture (n_joints,) that is an end; None if there is none within the limits."""
    root = body.frames[0]
    for arm in ARMS:
        T = relative_pose(body, q, root, arm.hand)
        outward = np.array([0.0, arm.side, 0.0])  # y of a hand's frame points out of its back
        R = _turned_onto(T[:3, 1], outward) @ T[:3, :3]
        tip = T[:3, :3] @ arm.fingertip + T[:3, 3]
        tip[1] = arm.side * APART / 2
        aim = Aim(root, arm.hand, tip - R @ arm.fingertip, R)
        reached = InverseKinematics(starts=0).solve(body, aim, q, arm.joints)
        if not reached.converged:
            return None
        q = reached.q
    return q


def _turned_onto(a: Array, b: Array) -> Array:
    """The smallest rotation (3, 3) that takes one unit vector to another."""
    axis = np.cross(a, b)
    sine = np.linalg.norm(axis)
    angle = np.arctan2(sine, a @ b)
    return lie.exp_so3(axis * (angle / max(float(sine), 1e-12)))


def _beginnings(body: Body, q_d: Array, rng: np.random.Generator) -> Iterator[Array]:
    """Postures with both hands as far from the end as a beginning's should be, for ever."""
    columns = [body.joint_index(name) for arm in ARMS for name in arm.joints]
    while True:
        q = np.tile(q_d, (200, 1))
        q[:, columns] += SPREAD * rng.normal(size=(len(q), len(columns)))
        q = np.clip(q, body.lower, body.upper)
        for arm in ARMS:
            p_d = relative_pose(body, q_d, icub.LEFT_EYE, arm.hand)[:3, 3]
            p = relative_pose(body, q, icub.LEFT_EYE, arm.hand)[:, :3, 3]
            away = np.linalg.norm(p - p_d, axis=1)
            q = q[(away > SHORTEST) & (away < LONGEST)]
        yield from q[_shows(body, q)]


def _shows(body: Body, q: Array) -> Flags:
    """Whether both eyes see all marks of both hands, which are apart; (n,)."""
    good = np.ones(len(q), dtype=bool)
    for beta in ({}, both_offsets()):
        shifted = _with_offsets(body, q, beta)
        for eye in (icub.LEFT_EYE, icub.RIGHT_EYE):
            right, left = (_marks(body, shifted, eye, arm) for arm in ARMS)
            for p in (right, left):
                good &= eyes.in_view(p, NEAR, FAR, MARGIN).all(axis=1)
        between = np.linalg.norm(right[:, :, None] - left[:, None], axis=3)
        good &= between.min(axis=(1, 2)) > CLEAR
    return good


def _marks(body: Body, q: Array, eye: str, arm: Arm) -> Array:
    """(n, 4, 3) m in the eye."""
    T = relative_pose(body, q, eye, arm.hand)
    return np.asarray(np.einsum("nij,kj->nki", T[:, :3, :3], arm.marks) + T[:, None, :3, 3])


def _with_offsets(body: Body, q: Array, beta: Mapping[str, float]) -> Array:
    """The readings of some joints moved by their offsets, (n, n_joints)."""
    shifted = q.copy()
    for name, angle in beta.items():
        shifted[:, body.joint_index(name)] += angle
    return shifted


def _robot() -> SeeingIcub:
    return SeeingIcub(both_offsets(), links=[link for arm in ARMS for link in arm.links])


def _alone(robot: SeeingIcub, way: Array) -> bool:
    """Whether nothing of the robot but hands, wrists and forearms shows on the way."""
    for q in way:
        robot.command(q)
        if robot.hidden_share() > 0:
            return False
    return True
