"""Arms: the robots of the campaign, as their makers would describe them.

Four random chains of four to seven joints, and two that are in use, from their published DH tables
(Universal Robots UR5, standard form; Franka Emika Panda, Craig's form). Two of the eight are looked
at with a precise tracker.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.kernels import FIXED, REVOLUTE
from bodyschema.model.tree import Body

Array = NDArray[np.float64]

UR5 = np.array(
    [
        [0.0, 0.089159, np.pi / 2],
        [-0.425, 0.0, 0.0],
        [-0.39225, 0.0, 0.0],
        [0.0, 0.10915, np.pi / 2],
        [0.0, 0.09465, -np.pi / 2],
        [0.0, 0.0823, 0.0],
    ]
)
"""a (m), d (m), alpha (rad) behind each joint."""

PANDA = np.array(
    [
        [0.0, 0.333, 0.0],
        [0.0, 0.0, -np.pi / 2],
        [0.0, 0.316, np.pi / 2],
        [0.0825, 0.0, np.pi / 2],
        [-0.0825, 0.384, -np.pi / 2],
        [0.0, 0.0, np.pi / 2],
        [0.088, 0.0, np.pi / 2],
    ]
)
"""a (m), d (m), alpha (rad) before each joint."""


@dataclass(frozen=True)
class Arm:
    """A robot and the sensor that looks at its tool."""

    name: str
    body: Body
    """Frames "base", "link_1" .., "tip"."""
    home: Array
    """(n_joints,) rad, round which it is moved."""
    noise: float
    """m, of positions; rotations have `TURN` times as much in rad."""


TURN = 4.0
"""rad/m: a marker of 25 cm seen at both ends."""


def arms() -> tuple[Arm, ...]:
    """Six arms before a tracker of half a millimetre, two before one of a twentieth."""
    chains = [Body.random_chain(n, np.random.default_rng(40 + n)) for n in (4, 5, 6, 7)]
    bodies = [*chains, _serial("ur5", _behind(UR5)), _serial("panda", _before(PANDA))]
    common = [Arm(body.name, body, _home(body), 5e-4) for body in bodies]
    return (*common, *(replace(common[i], noise=5e-5) for i in (2, 5)))


def _home(body: Body) -> Array:
    known = {"ur5": [0, -1.2, 1.4, -1.0, -1.5, 0], "panda": [0, -0.3, 0, -1.9, 0, 1.8, 0.7]}
    return np.array(known.get(body.name, [0.0] * len(body.joints)), dtype=np.float64)


def _behind(table: Array) -> Array:
    """Placements of n joints and the tip, (n + 1, 4, 4), from a standard DH table."""
    a, d, alpha = table.T
    steps = [_step(alpha[i], [a[i], 0.0, d[i]]) for i in range(len(table))]
    return np.stack([np.eye(4), *steps])


def _before(table: Array) -> Array:
    """The same from a table in Craig's form; the flange is 107 mm behind the last joint."""
    a, d, alpha = table.T
    turned = [lie.exp_so3(np.array([angle, 0.0, 0.0])) for angle in alpha]
    steps = [lie.transform(R, R @ np.array([a[i], 0.0, d[i]])) for i, R in enumerate(turned)]
    return np.stack([*steps, _step(0.0, [0.0, 0.0, 0.107])])


def _step(alpha: float, away: list[float]) -> Array:
    return lie.transform(lie.exp_so3(np.array([alpha, 0.0, 0.0])), np.array(away))


def _serial(name: str, placement: Array) -> Body:
    n = len(placement) - 1
    numbers = [str(i) for i in range(1, n + 1)]
    return Body.build(
        name=name,
        frames=["base", *("link_" + i for i in numbers), "tip"],
        carriers=["", *("joint_" + i for i in numbers), "tip_joint"],
        parent=range(-1, n + 1),
        kind=[FIXED, *[REVOLUTE] * n, FIXED],
        axis=np.tile([0.0, 0.0, 1.0], (n + 2, 1)),
        placement=np.concatenate([np.eye(4)[None], placement]),
        limits={f"joint_{i}": (-3.2, 3.2) for i in numbers},
    )
