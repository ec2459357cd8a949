"""Problems: what is freed, and what is refused before any time is spent."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.answers.calibrate import calibrate
from bodyschema.errors import InputError
from bodyschema.estimation.problem import ROUGHLY, Problem, check_problem, moved_joints
from bodyschema.model.kernels import PRISMATIC
from bodyschema.model.tree import Body
from bodyschema.senses.sense import Sense
from simulated import points, poses, postures, seen_arm

Array = NDArray[np.float64]


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(0)


@pytest.fixture
def body(rng: np.random.Generator) -> Body:
    return seen_arm(4, rng)


def refused(body: Body, senses: Sequence[Sense], groups: Sequence[str] = ("offsets",)) -> str:
    """The message of `calibrate`, which is the border that users meet."""
    with pytest.raises(InputError) as caught:
        calibrate(body, senses, {"tracker": "no", "tool": "no"}, groups)
    return str(caught.value)


def test_nothing_seen(body: Body) -> None:
    assert "nothing was seen" in refused(body, [])


def test_no_motion(body: Body, rng: np.random.Generator) -> None:
    still = points(body, np.tile(postures(1, body, rng), (30, 1)), rng)
    assert refused(body, [still]).startswith("all samples show one posture: no joint between")


def test_motion_of_another_joint_is_no_motion(body: Body, rng: np.random.Generator) -> None:
    """The camera sits on link 2 and looks at link 4; only joint 1 moves."""
    q = np.zeros((30, 4))
    q[:, 0] = rng.uniform(-1, 1, 30)
    seen = points(body, q, rng, seen_from="link_2", seen="link_4")
    problem = Problem(body, (seen,), {}, moved_joints(body, [seen]))
    with pytest.raises(InputError, match="all samples show one posture"):
        check_problem(problem, ["offsets"], 5)


def test_no_joint_in_between(body: Body, rng: np.random.Generator) -> None:
    seen = points(body, postures(30, body, rng), rng, seen_from="base", seen="tracker")
    assert moved_joints(body, [seen]) == ()
    with pytest.raises(InputError, match="all samples show one posture"):
        check_problem(Problem(body, (seen,), {}, ()), [], 5)


def test_degrees(body: Body, rng: np.random.Generator) -> None:
    seen = points(body, postures(30, body, rng), rng)
    message = refused(body, [replace(seen, q=np.rad2deg(seen.q))])
    assert message.startswith("joint 'joint_1' reads ")
    assert 'set [joints] unit = "deg"' in message


def test_degrees_within_three_turns_are_told_by_the_limits(
    body: Body, rng: np.random.Generator
) -> None:
    limited = replace(body, lower=np.full(4, -1.5), upper=np.full(4, 1.5))
    q = postures(30, body, rng, 0.15)
    message = refused(limited, [replace(points(body, q, rng), q=np.rad2deg(q))])
    assert "where its limits are -1.50 to 1.50 rad" in message


def test_a_prismatic_joint_has_no_degrees(body: Body, rng: np.random.Generator) -> None:
    kind = body.kind.copy()
    kind[body.frame_index("link_1")] = PRISMATIC
    rail = replace(body, kind=kind)
    q = postures(30, body, rng)
    q[:, 0] *= 50
    seen = points(rail, q, rng)
    check_problem(Problem(rail, (seen,), {}, moved_joints(rail, [seen])), ["offsets"], 5)


def test_too_few_samples(body: Body, rng: np.random.Generator) -> None:
    seen = points(body, postures(5, body, rng), rng)
    message = refused(body, [seen])
    assert message.startswith("5 samples hold 15 numbers, too few for 13 parameters in 5 folds")
    assert "record at least 8 postures, or free less" in message
    check_problem(Problem(body, (seen,), {"tool": "no"}, body.joints), ["offsets"], 5)


def test_fewer_samples_than_folds(body: Body, rng: np.random.Generator) -> None:
    seen = poses(body, postures(4, body, rng), rng)
    message = refused(body, [seen], ())
    assert "4 samples hold 24 numbers" in message
    assert "record at least 5 postures" in message


def test_an_unknown_frame_that_nothing_sees(body: Body, rng: np.random.Generator) -> None:
    seen = points(body, postures(30, body, rng), rng)
    lamp = body.attach("lamp", "base")
    with pytest.raises(InputError, match="frame lamp is unknown, but no sense"):
        calibrate(lamp, [seen], {"lamp": "no"})


@pytest.mark.parametrize("sense", [points, poses])
def test_only_a_frame_that_is_seen_to_turn_has_turns(sense, body: Body) -> None:  # type: ignore[no-untyped-def]
    rng = np.random.default_rng(0)
    seen = sense(body, postures(30, body, rng), rng)
    problem = Problem(body, (seen,), {"tracker": "no", "tool": "roughly"}, body.joints)
    free = problem.variables(["offsets"])
    assert problem.unknown == ("tracker",)
    assert len(free.where(["frame:tracker"])) == 6
    assert len(free.where(["frame:tool"])) == (3 if sense is points else 6)
    assert free.where(["frame:tool"]).prior_std[0] == ROUGHLY[0]
    assert len(problem.variables(["offsets"], roughly=False)) == 4 + 6
    assert len(problem.variables([], roughly=False)) == 6


def test_joints_between_the_ends_of_the_senses(body: Body, rng: np.random.Generator) -> None:
    q = postures(3, body, rng)
    low = points(body, q, rng, seen_from="link_1", seen="link_2")
    high = points(body, q, rng, seen_from="link_3", seen="tool")
    assert moved_joints(body, [low]) == ("joint_2",)
    assert moved_joints(body, [low, high]) == ("joint_2", "joint_4")
    assert moved_joints(body, [points(body, q, rng)]) == body.joints


def test_points_and_poses_of_one_frame_go_together_but_not_twice_the_same() -> None:
    rng = np.random.default_rng(0)
    body = seen_arm(4, rng)
    q = postures(30, body, rng)
    senses = [points(body, q, rng), poses(body, q, rng)]
    check_problem(Problem(body, tuple(senses), {}, body.joints), ("offsets",), 5)
    with pytest.raises(InputError, match="two senses are"):
        check_problem(Problem(body, (senses[0], senses[0]), {}, body.joints), ("offsets",), 5)
