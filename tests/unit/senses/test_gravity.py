"""Gravity: mountings and tilts from readings at rest, gains and offsets, and readings in g."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model import parts
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.senses.gravity import G, Gravity
from simulated import angle, forgotten


@pytest.fixture(scope="module")
def body() -> Body:
    """An arm with an accelerometer on its last link, on a base that leans."""
    arm = Body.random_chain(4, np.random.default_rng(0))
    arm = arm.attach("world", "base", lie.transform(lie.exp_so3([0.1, -0.2, 0.0]), np.zeros(3)))
    mount = lie.transform(lie.exp_so3([1.0, -2.0, 0.5]), [0.1, 0.2, 0.3])
    return arm.attach("imu", "tip", mount).with_part("feel", parts.accelerometer())


def felt(body: Body, n: int, seed: int = 1, std: float = 0.02, **more: str) -> Gravity:
    rng = np.random.default_rng(seed)
    q = rng.uniform(-2, 2, (n, 4))
    up = relative_pose(body, q, "imu", "world")[:, :3, 2]
    noise = std * rng.normal(size=(n, 3))
    return Gravity.make(q, G * up + noise, "imu", "world", std=std, **more)


def test_a_sensor_at_rest_reads_up(body: Body) -> None:
    level = body.attach("level", "base")
    one = Gravity.make(np.zeros((1, 4)), [0.0, 0.0, 9.81], "base", "level")
    assert one.predict(level).tolist() == [[0.0, 0.0, 9.81]]
    assert one.shows == (("turn_x", "turn_y", "turn_z"), ("turn_x", "turn_y"))


def test_offsets_and_gains(body: Body) -> None:
    true = felt(body, 3, std=1e-12, sensor="feel")
    values = np.array([0.1, 0.2, -0.1, 0.01, -0.02, 0.03])
    off = body.with_part("feel", replace(body.parts["feel"], values=values))
    read = replace(true, observed=(1 + values[3:]) * true.observed + values[:3])
    assert np.abs(read.residual(off)).max() < 1e-9


@pytest.mark.parametrize("unknown", [("imu",), ("world",), ("imu", "world")], ids="+".join)
def test_mounting_and_tilt_are_found_from_nothing(body: Body, unknown: tuple[str, ...]) -> None:
    for seed in range(4):
        sense = felt(body, 40, seed)
        sense.observed[:4] *= -1
        blind = body
        for frame in unknown:
            blind = blind.with_placement(frame, lie.transform(np.eye(3), [0.1, 0.2, 0.3]))
        found = sense.start(blind, unknown)
        assert found is not None
        for frame in unknown:
            T, true = (b.placement[b.frame_index(frame)] for b in (found, body))
            assert T[:3, 3].tolist() == [0.1, 0.2, 0.3]
            assert angle(T, true) < 0.01


def test_one_joint_that_turns_about_a_level_axis_is_enough_for_the_mounting(body: Body) -> None:
    sense = felt(body, 40)
    q = sense.q * [0, 1, 0, 0]
    sense = replace(sense, q=q, observed=G * relative_pose(body, q, "imu", "world")[:, :3, 2])
    found = sense.start(forgotten(body, ["imu"]), ["imu"])
    assert found is not None
    assert angle(*(b.placement[b.frame_index("imu")] for b in (found, body))) < 1e-6


def test_refusals(body: Body) -> None:
    with pytest.raises(InputError, match=r"1 long in the middle.*give m/s\^2 \(not g\)"):
        Gravity.make(np.zeros((2, 4)), [[0.0, 0.0, 1.0]] * 2, "imu", "world")
    odd = body.with_part("odd", parts.clock())
    with pytest.raises(InputError, match="'odd' is no sensor of three channels"):
        felt(body, 2, sensor="odd").predict(odd)
