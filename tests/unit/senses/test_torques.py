"""Torques: derivatives, a known case, and a linear start."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model import parts
from bodyschema.model.inertia import Inertia
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, free_part, join
from bodyschema.senses.torques import Torques

Array = NDArray[np.float64]

LINKS = {"link_2": "upper", "tip": "load"}
COUPLED = np.array([[1.0, 0, 0], [0, 1, 0], [0, 1, 1]])
N = 5


def arm() -> Body:
    """Three joints, two links that weigh something, motors, and a frame whose z points up."""
    body = Body.random_chain(3, np.random.default_rng(0))
    body = body.attach("up", "base", lie.transform(lie.exp_so3([0.1, 0.2, 0.0]), [0.0] * 3))
    heavy = Inertia(2.0, np.array([0.01, 0.05, 0.1]), np.diag([2e-2, 2e-2, 1e-2]))
    body = body.with_part("upper", parts.load(heavy)).with_part("load", parts.load())
    motors = parts.drive(body.joints)
    values = np.tile([0.1, 0.5, 0.3, 0.2, 0.01], 3)
    return body.with_part("motors", replace(motors, values=values))


def felt(n: int = N) -> tuple[Torques, Body]:
    """Exact samples."""
    body = arm()
    q, dq, ddq = np.random.default_rng(1).uniform(-1, 1, (3, n, 3)) * [[[1]], [[2]], [[5]]]
    sense = Torques.make(
        q, np.zeros((n, 3)), LINKS, "base", "up", dq=dq, ddq=ddq, drive="motors", motors=COUPLED
    )
    return replace(sense, observed=sense.predict(body)), body


def variables(body: Body) -> Variables:
    held = [free_part(body, part) for part in ("upper", "load", "motors")]
    return join(free_joints(body), free_frame(body, "up"), *held)


def test_derivatives_agree_with_differences() -> None:
    sense, body = felt()
    free, step = variables(body), 1e-6
    x = 0.1 * np.random.default_rng(2).uniform(-1, 1, len(free)) * np.minimum(free.scale, 1.0)
    L, there = sense.linearize(body, free, x), body.with_variables(free, x)
    assert L.residual == pytest.approx(sense.residual(there), abs=1e-12)
    for i, d in enumerate(step * np.eye(len(free))):
        ends = [sense.residual(body.with_variables(free, x + s * d)) for s in (1, -1)]
        assert L.by_parameter[:, :, i] == pytest.approx((ends[0] - ends[1]) / (2 * step), abs=1e-6)
    for j, d in enumerate(step * np.eye(3)):
        ends = [replace(sense, q=sense.q + s * d).residual(there) for s in (1, -1)]
        assert L.by_joint[:, :, j] == pytest.approx((ends[0] - ends[1]) / (2 * step), abs=1e-6)


def test_a_hanging_pendulum_and_a_held_one() -> None:
    body = Body.random_chain(1, np.random.default_rng(0))
    body = replace(body, axis=np.tile([0.0, 1.0, 0.0], (3, 1)))
    bob = Inertia(2.0, np.array([0.0, 0.0, -0.3]), np.diag([1e-3] * 3))
    body = body.with_part("bob", parts.load(bob))
    quarter = np.array([[0.0], [np.pi / 2]])
    sense = Torques.make(quarter, np.zeros((2, 1)), {"link_1": "bob"}, "base", "base")
    torque = sense.predict(body)[:, 0]
    assert torque[0] == pytest.approx(0.0, abs=1e-9)
    assert abs(torque[1]) == pytest.approx(2.0 * 9.81 * 0.3)


def test_the_linear_start_explains_exact_samples() -> None:
    sense, body = felt(60)
    plain = body.with_part("load", parts.load()).with_part("upper", parts.load())
    zero = replace(body.part("motors"), values=np.tile([0.0, 0, 0, 0, 0.01], 3))
    blank = plain.with_part("motors", zero)
    found = sense.start(blank, ("upper", "load", "motors"))
    assert found is not None
    left, whole = sense.residual(found), sense.residual(blank)
    assert np.sqrt(np.mean(left**2)) < 0.2 * np.sqrt(np.mean(whole**2))
    only = sense.start(body.with_part("motors", zero), ("motors",))
    assert only is not None
    assert only.part("motors").values == pytest.approx(body.part("motors").values, abs=1e-4)
    assert sense.start(body, ()) is None


def test_one_noise_level_a_joint_and_no_arm_without_weight() -> None:
    sense, _ = felt()
    assert [part for _, _, part in sense.components] == [slice(j, j + 1) for j in range(3)]
    with pytest.raises(InputError, match="at least one link"):
        replace(sense, loads=())


@pytest.mark.parametrize(
    ("sign", "says"),
    [
        ([-1.0, -1.0, -1.0], "torque of all joints turned round"),
        ([1.0, -1.0, 1.0], "torque of joint_2 turned round"),
    ],
)
def test_a_torque_of_the_other_sign_is_refused(sign: list[float], says: str) -> None:
    sense, body = felt(60)
    noise = 0.02 * np.random.default_rng(3).normal(size=sense.observed.shape)
    right = replace(sense, observed=sense.observed + noise, covariance=0.02**2 * np.eye(3))
    assert right.start(body, {"upper", "load"}) is not None
    with pytest.raises(InputError, match=says):
        replace(right, observed=right.observed * sign).start(body, {"upper", "load"})
