"""Touches: the sign of the residual, points in the limb's own frame, and refusals."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.senses.points import Points
from bodyschema.senses.touches import Touches
from simulated import angle, forgotten


@pytest.fixture(scope="module")
def body() -> Body:
    """Two fingers on one palm would do: here a chain and a frame that is turned on its base."""
    arm = Body.random_chain(3, np.random.default_rng(0))
    return arm.attach("skin", "base", lie.transform(lie.exp_so3([0.2, -0.5, 1.0]), [0.5, 0.1, 0.3]))


def touched(body: Body, n: int, seed: int = 1) -> Touches:
    rng = np.random.default_rng(seed)
    q, v = rng.uniform(-1, 1, (n, 3)), rng.normal(size=(n, 3))
    T = relative_pose(body, q, "skin", "tip")
    return Touches.make(q, np.einsum("nij,nj->ni", T[:, :3, :3], v) + T[:, :3, 3], v, "skin", "tip")


def test_the_residual_is_felt_minus_predicted(body: Body) -> None:
    touches = touched(body, 5)
    assert np.abs(touches.residual(body)).max() < 1e-14
    felt = Touches.make(
        touches.q, touches.position + np.array([1, 2, 3]), touches.touching, "skin", "tip"
    )
    assert felt.residual(body) == pytest.approx(np.tile([1.0, 2.0, 3.0], (5, 1)), abs=1e-14)
    R = relative_pose(body, touches.q, "skin", "tip")[:, :3, :3]
    other = Touches.make(
        touches.q, touches.position, touches.touching + np.array([0.1, 0, 0]), "skin", "tip"
    )
    assert other.residual(body) == pytest.approx(-0.1 * R[:, :, 0], abs=1e-14)


def test_a_touch_at_the_origin_is_a_point(body: Body) -> None:
    touches = touched(body, 4)
    zero = Touches.make(touches.q, touches.position, [0.0, 0.0, 0.0], "skin", "tip")
    points = Points.make(touches.q, touches.position, "skin", "tip")
    assert zero.residual(body) == pytest.approx(points.residual(body), abs=1e-15)
    assert zero.touching.shape == (4, 3)


def test_imagined_takes_the_touching_points_in_turn(body: Body) -> None:
    touches = touched(body, 2)
    q = np.random.default_rng(3).uniform(-1, 1, (5, 3))
    more = touches.imagined(body, q)
    assert (more.touching == touches.touching[[0, 1, 0, 1, 0]]).all()
    assert np.abs(more.residual(body)).max() < 1e-14
    assert (touches.take([]).imagined(body, q).touching == 0).all()


def test_what_was_touched_must_be_as_many_numbers(body: Body) -> None:
    with pytest.raises(InputError, match=r"seen should have shape \(5, 3\), it has \(4, 3\)"):
        Touches.make(np.zeros((5, 3)), np.zeros((5, 3)), np.zeros((4, 3)), "skin", "tip")
    spoiled = np.zeros((5, 3))
    spoiled[2, 1] = np.nan
    with pytest.raises(InputError, match="not a finite number in row 2"):
        Touches.make(np.zeros((5, 3)), np.zeros((5, 3)), spoiled, "skin", "tip")


@pytest.mark.parametrize("unknown", [("skin",), ("finger",), ("skin", "finger")], ids="+".join)
def test_skin_and_finger_are_placed_from_nothing(body: Body, unknown: tuple[str, ...]) -> None:
    body = body.attach("finger", "tip", lie.transform(lie.exp_so3([1.0, 0.4, -0.2]), [0.1] * 3))
    for seed in range(4):
        rng = np.random.default_rng(seed)
        q, v = rng.uniform(-1, 1, (40, 3)), rng.uniform(-0.1, 0.1, (40, 3))
        blank = Touches.make(q, np.zeros((40, 3)), v, "skin", "finger")
        felt = blank.predict(body) + 1e-3 * rng.normal(size=(40, 3))
        felt[:4] += 0.2
        found = replace(blank, observed=felt).start(forgotten(body, unknown), unknown)
        assert found is not None
        for frame in unknown:
            T, true = (b.placement[b.frame_index(frame)] for b in (found, body))
            assert np.linalg.norm(T[:3, 3] - true[:3, 3]) < 0.01
            assert angle(T, true) < 0.03
