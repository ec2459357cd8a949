"""Distances: wires and balls, drums with a zero of their own, starts, and lengths of nothing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model import parts
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_frame
from bodyschema.senses.distances import Distances
from simulated import forgotten

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def body() -> Body:
    """An arm, a drum on the floor, and the wire's hook on the tip."""
    arm = Body.random_chain(5, np.random.default_rng(0))
    arm = arm.attach("drum", "base", lie.transform(np.eye(3), [0.5, -0.4, 0.1]))
    arm = arm.attach("hook", "tip", lie.transform(np.eye(3), [0.03, 0.02, 0.08]))
    return arm.with_part("wire", parts.sensor(("length",), ("m",), 0.5))


def wire(body: Body, n: int, std: float = 1e-3, seed: int = 1, **more: str) -> Distances:
    rng = np.random.default_rng(seed)
    q = rng.uniform(-2, 2, (n, 5))
    length = np.linalg.norm(relative_pose(body, q, "drum", "hook")[:, :3, 3], axis=1)
    return Distances.make(q, length + std * rng.normal(size=n), "drum", "hook", std=std, **more)


def test_the_length_is_that_between_the_points(body: Body) -> None:
    w, v = np.array([0.1, 0.2, 0.3]), np.array([-0.1, 0.1, 0.2])
    q = np.random.default_rng(1).uniform(-1, 1, (4, 5))
    T_base_drum, T_base_hook = (relative_pose(body, q, "base", f) for f in ("drum", "hook"))
    ends = [T[:, :3, :3] @ p + T[:, :3, 3] for T, p in ((T_base_drum, w), (T_base_hook, v))]
    length = np.linalg.norm(ends[0] - ends[1], axis=1)
    made = Distances.make(q, length, "drum", "hook", w, v)
    assert made.predict(body)[:, 0] == pytest.approx(length, abs=1e-14)
    one = Distances.make(q, 0.05, "drum", "hook")
    assert one.observed.tolist() == [[0.05]] * 4


def test_a_drum_has_a_zero_and_a_gain(body: Body) -> None:
    true = wire(body, 3, 1e-12)
    part = replace(body.parts["wire"], values=np.array([0.2, 0.01]))
    read = replace(true, sensor="wire", observed=1.01 * true.observed + 0.2)
    assert np.abs(read.residual(body.with_part("wire", part))).max() < 1e-9


@pytest.mark.parametrize("unknown", [("drum",), ("hook",), ("drum", "hook")], ids="+".join)
@pytest.mark.parametrize("bad", [0.0, 0.1])
def test_open_ends_are_placed_from_nothing(
    body: Body, unknown: tuple[str, ...], bad: float
) -> None:
    for seed in range(4):
        sense = wire(body, 60, seed=seed)
        sense.observed[: int(60 * bad)] += 0.3
        found = sense.start(forgotten(body, unknown), unknown)
        assert found is not None
        for frame in unknown:
            places = [b.placement[b.frame_index(frame)][:3, 3] for b in (found, body)]
            assert np.linalg.norm(places[0] - places[1]) < 0.01


def test_a_zero_that_nobody_knows_does_not_spoil_the_start(body: Body) -> None:
    sense = wire(body, 60, sensor="wire")
    sense = replace(sense, observed=sense.observed + 0.4)
    found = sense.start(forgotten(body, ("drum", "hook")), ("drum", "hook"))
    assert found is not None
    for frame in ("drum", "hook"):
        places = [b.placement[b.frame_index(frame)][:3, 3] for b in (found, body)]
        assert np.linalg.norm(places[0] - places[1]) < 0.01


def test_no_length_has_no_direction(body: Body) -> None:
    q = np.zeros((1, 5))
    with pytest.raises(InputError, match=r"0.004 m in row 0 is within 5 .* use points"):
        Distances.make(q, 0.004, "drum", "hook")
    Distances.make(q, -0.1, "drum", "hook", sensor="wire")
    same = Distances.make(q, 0.1, "hook", "hook")
    linear = same.linearize(body, free_frame(body, "drum"), np.zeros(6))
    assert np.isfinite(linear.by_parameter).all()
    assert linear.residual == pytest.approx(0.1)


def test_refusals(body: Body) -> None:
    q = np.zeros((2, 5))
    with pytest.raises(InputError, match=r"seen should have shape \(2, 1\), it has \(3, 1\)"):
        Distances.make(q, [1.0, 2.0, 3.0], "drum", "hook")
    odd = body.with_part("odd", parts.accelerometer())
    with pytest.raises(InputError, match="'odd' is no sensor of one channel"):
        Distances.make(q, 1.0, "drum", "hook", sensor="odd").predict(odd)
