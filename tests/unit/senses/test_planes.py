"""Planes: tips and balls on a table that nobody measured."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.senses.planes import Planes
from simulated import angle, forgotten

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def body() -> Body:
    """An arm with a stylus, and a table that leans a little."""
    arm = Body.random_chain(5, np.random.default_rng(0))
    table = lie.transform(lie.exp_so3([0.1, -0.2, 0.0]), [0.0, 0.0, -0.15])
    arm = arm.attach("table", "base", table)
    return arm.attach("stylus", "tip", lie.transform(np.eye(3), [0.03, 0.02, 0.08]))


def touching(body: Body, n: int, height: float = 0.0, seed: int = 1, std: float = 1e-3) -> Planes:
    """Postures in which the stylus is at a height above the table, found among random ones."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(-2, 2, (400 * n, 5))
    z = relative_pose(body, q, "table", "stylus")[:, 2, 3]
    near = np.argsort(np.abs(z - height))[:n]
    noise = z[near] - height + std * rng.normal(size=n)
    return Planes.make(q[near], "table", "stylus", height + noise, std=std)


def test_the_residual_is_the_height_that_is_missing(body: Body) -> None:
    q = np.random.default_rng(1).uniform(-1, 1, (3, 5))
    v = np.array([0.02, 0.0, 0.05])
    T = relative_pose(body, q, "table", "stylus")
    z = (T[:, :3, :3] @ v + T[:, :3, 3])[:, 2]
    ball = Planes.make(q, "table", "stylus", 0.03, v)
    assert ball.residual(body)[:, 0] == pytest.approx(0.03 - z, abs=1e-14)
    assert ball.shows[0] == ("link_z", "turn_x", "turn_y")


@pytest.mark.parametrize("unknown", [("table",), ("stylus",), ("table", "stylus")], ids="+".join)
@pytest.mark.parametrize("height", [0.0, 0.04])
def test_table_and_stylus_are_placed_from_nothing(
    body: Body, unknown: tuple[str, ...], height: float
) -> None:
    for seed in range(4):
        sense = touching(body, 60, height, seed)
        sense.observed[:6] += 0.05
        found = sense.start(forgotten(body, unknown), unknown)
        assert found is not None
        (tilt, true), (tip, end) = (
            [b.placement[b.frame_index(frame)] for b in (found, body)]
            for frame in ("table", "stylus")
        )
        assert angle(tilt, true) < 0.02
        assert true[:3, 2] @ (tilt[:3, 3] - true[:3, 3]) == pytest.approx(0, abs=5e-3)
        assert np.linalg.norm(tip[:3, 3] - end[:3, 3]) < 0.01
        # What a plane cannot show stays as attached.
        assert (tilt[:2, 3] == 0).all()


def test_a_wall_hangs_on_a_frame_that_faces_it(body: Body) -> None:
    wall = lie.transform(lie.exp_so3([0.0, np.pi / 2, 0.0]), [0.1, 0.0, 0.0])
    upright = body.with_placement("table", wall)
    sense = touching(upright, 40)
    with pytest.raises(InputError, match=r"stands upright in frame 'base'.*Body.attach"):
        sense.start(forgotten(upright, ["table"]), ["table"])
