"""Points: the sign of the residual, its derivative, selection, and refusals."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_frame
from bodyschema.senses.points import DEFAULT_STD, Points
from bodyschema.senses.poses import Poses
from bodyschema.senses.sense import concatenate

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def body() -> Body:
    arm = Body.random_chain(3, np.random.default_rng(0))
    turned = lie.transform(lie.exp_so3([0.2, -0.5, 1.0]), [0.5, 0.1, 0.3])
    return arm.attach("tracker", "base", turned)


@pytest.fixture(scope="module")
def points(body: Body) -> Points:
    q = np.random.default_rng(1).uniform(-1, 1, (5, 3))
    seen = relative_pose(body, q, "tracker", "tip")[:, :3, 3]
    return Points.make(q, seen, "tracker", "tip", std=2e-3)


def test_the_residual_is_seen_minus_predicted(body: Body, points: Points) -> None:
    off = np.array([0.01, 0.02, 0.03])
    too_far = Points.make(points.q, points.position + off, "tracker", "tip")
    expected = np.tile(off, (5, 1))
    assert too_far.residual(body) == pytest.approx(expected, abs=1e-15)
    longer = body.with_placement("tip", body.placement[4] + np.eye(4, k=3) * 0.1)
    shift = relative_pose(longer, points.q, "tracker", "link_3")[:, :3, 0] * 0.1
    assert points.residual(longer) == pytest.approx(-shift, abs=1e-14)


def test_the_derivative_has_the_sign_of_the_residual(body: Body, points: Points) -> None:
    tip = free_frame(body, "tip", turn_std=None)
    L = points.linearize(body, tip, np.zeros(3))
    R = relative_pose(body, points.q, "tracker", "link_3")[:, :3, :3]
    assert L.by_parameter == pytest.approx(-R, abs=1e-14)


def test_what_make_fills_in(points: Points) -> None:
    assert points.time.tolist() == points.rows.tolist() == [0, 1, 2, 3, 4]
    assert points.covariance == pytest.approx(4e-6 * np.eye(3))
    assert points.label == "tip seen from tracker"
    one = Points.make([0.1, 0.2, 0.3], [1.0, 2.0, 3.0], "base", "tip", time=[7.5], rows=[42])
    assert (len(one), one.q.shape, one.position.shape) == (1, (1, 3), (1, 3))
    assert (one.time[0], one.rows[0]) == (7.5, 42)
    assert one.covariance[0, 0] == DEFAULT_STD**2


def test_take_and_concatenate(body: Body, points: Points) -> None:
    first, last = points.take(np.arange(5) < 2), points.take([4, 2])
    both = concatenate([first, last])
    assert isinstance(both, Points)
    assert both.rows.tolist() == [0, 1, 4, 2]
    assert (both.position == points.position[[0, 1, 4, 2]]).all()
    assert (both.q == points.q[[0, 1, 4, 2]]).all()
    assert (both.covariance == points.covariance).all()
    none = points.take(np.zeros(5, dtype=bool))
    assert len(none) == 0
    assert none.residual(body).shape == (0, 3)
    assert len(concatenate([none, points])) == 5


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"position": (3, 1, np.nan)}, "tip seen from tracker: seen is not a finite .* row 13;"),
        ({"position": (2, 0, np.inf)}, "seen is not a finite number in row 12; drop the 1 bad"),
        ({"q": (1, 2, np.nan)}, "q is not a finite number in row 11"),
    ],
)
def test_values_that_are_no_numbers_are_refused_with_their_row(
    points: Points, change: dict[str, tuple[int, int, float]], message: str
) -> None:
    arrays = {"q": points.q.copy(), "position": points.position.copy()}
    for name, (row, column, value) in change.items():
        arrays[name][row, column] = value
    with pytest.raises(InputError, match=message):
        Points.make(**arrays, seen_from="tracker", seen="tip", rows=np.arange(10, 15))


@pytest.mark.parametrize(
    ("q", "position", "time", "message"),
    [
        ((5, 3), (4, 3), None, r"seen should have shape \(5, 3\), it has \(4, 3\)"),
        ((5, 3), (5, 2), None, r"seen should have shape \(5, 3\), it has \(5, 2\)"),
        ((5, 3), (5, 3), np.zeros(4), r"q should have shape \(4, -1\), it has \(5, 3\)"),
        ((2, 5, 3), (5, 3), None, r"q should have shape"),
    ],
)
def test_arrays_that_do_not_belong_together_are_refused(
    q: tuple[int, ...], position: tuple[int, ...], time: Array | None, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        Points.make(np.zeros(q), np.zeros(position), "base", "tip", time=time)


def test_different_frames_and_senses_are_not_mixed(body: Body, points: Points) -> None:
    based = Points.make(points.q, points.position, "base", "tip")
    posed = Poses.make(points.q, relative_pose(body, points.q, "tracker", "tip"), "tracker", "tip")
    for other in (based, posed):
        with pytest.raises(InputError, match=r"and Points of tip seen from tracker are not one"):
            concatenate([points, other])
