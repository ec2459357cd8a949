"""Two results of one robot, side by side: what differs is named, what does not is the same."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import Body, InputError, lie
from bodyschema.answers.comparison import compare
from bodyschema.estimation.estimate import Estimate
from bodyschema.judging.calibration import Calibration
from bodyschema.model.variables import free_frame, free_joints, join
from pose_fits import ARM, BOARD, CAMERA, answer, result

Array = NDArray[np.float64]


@pytest.fixture(scope="module")
def monday() -> Calibration:
    return result(0)


def test_a_result_is_the_same_as_itself(monday: Calibration) -> None:
    found = compare(monday, monday)
    assert found.same
    assert found.p_value == 1.0
    assert found.pairs[0].apart == pytest.approx(0.0, abs=1e-12)
    assert all(np.abs(part.change).max() < 1e-12 for part in found.parts)


def test_other_noise_is_the_same_at_the_stated_rate(monday: Calibration) -> None:
    """Of forty pairs of one robot, at a rate of 5 %, more than seven would be no chance.

    The places of the camera lie within what chance allows as often as is said.
    """
    results = [monday, *(result(seed) for seed in range(1, 41))]
    found = [compare(*pair, 0.05) for pair in pairwise(results)]
    assert sum(not one.same for one in found) <= 7
    within = sum(one.pairs[0].apart < one.pairs[0].chance for one in found)
    assert within >= 33


def test_what_is_placed_apart_stays_below_chance(monday: Calibration) -> None:
    pair = compare(monday, result(5)).pairs[0]
    assert 0.0 < pair.apart < 1.5 * pair.chance
    assert pair.left == pytest.approx(pair.apart, rel=0.2), "nothing differs, so all is left"


@pytest.mark.parametrize(("joint", "by"), [(1, 0.01), (2, -0.008)])
def test_a_joint_that_slipped_is_named(monday: Calibration, joint: int, by: float) -> None:
    zeros = np.array([0.0, 0.02, -0.03, 0.02])
    zeros[joint] += by
    found = compare(monday, result(1, zeros))
    assert not found.same
    first, *others = found.parts
    assert first.part == f"joint_{joint + 1}"
    assert first.differs
    assert not first.alike
    assert not any(part.differs for part in others)
    assert first.change[0] == pytest.approx(by, abs=4 * first.std[0])
    assert first.deviations == pytest.approx(abs(first.change[0]) / first.std[0], rel=0.02)
    assert found.pairs[0].left < 0.5 * found.pairs[0].apart
    assert first.effect_low < first.effect < first.effect_high
    assert not found.unexplained


def test_what_moves_along_is_named_beside_it(monday: Calibration) -> None:
    """The first joint turns about an axis that stands still for the board, too."""
    found = compare(monday, result(1, (0.015, 0.02, -0.03, 0.02)))
    (named,) = [part for part in found.parts if part.differs]
    assert {named.part, *named.alike} == {"joint_1", "board"}


def test_two_that_slipped(monday: Calibration) -> None:
    found = compare(monday, result(1, (0.0, 0.02, -0.04, 0.03)))
    assert {part.part for part in found.parts if part.differs} >= {"joint_3"}
    named = [{part.part, *part.alike} for part in found.parts if part.differs]
    assert any("joint_4" in one or "camera" in one for one in named)


def test_a_board_that_was_moved(monday: Calibration) -> None:
    moved = BOARD.copy()
    moved[2, 3] += 0.005
    found = compare(monday, result(1, board=moved))
    (named,) = [part for part in found.parts if part.differs]
    assert named.part == "board"
    assert dict(zip(named.names, named.change, strict=True))["board.link_z"] == pytest.approx(
        0.005, abs=1e-3
    )


def test_with_the_robot_that_the_first_result_corrected(monday: Calibration) -> None:
    """A zero that went into the description is no difference, and a slip beside it is one."""
    corrected = replace(
        ARM, placement=monday.body.placement[: len(ARM.frames)], offset=monday.body.offset
    )
    placed = corrected.placement.copy()
    for k in np.flatnonzero(corrected.driver >= 0):
        turn = corrected.axis[k] * corrected.offset[corrected.driver[k]]
        placed[k, :3, :3] = placed[k, :3, :3] @ lie.exp_so3(turn)
    corrected = replace(corrected, placement=placed, offset=np.zeros(4))
    assert compare(monday, result(1, described=corrected)).same
    found = compare(monday, result(1, (0.0, 0.02, -0.04, 0.02), described=corrected))
    assert [part.part for part in found.parts if part.differs] == ["joint_3"]


def test_a_result_that_held_its_joints(monday: Calibration) -> None:
    """What one holds as described is compared as it stands, and that is said."""
    held = result(1, groups=())
    found = compare(monday, held)
    assert not found.same
    assert any("holds numbers of joint_1" in note for note in found.notes)
    back = compare(held, monday)
    assert {p.part for p in back.parts} == {p.part for p in found.parts}


def test_axes_and_links_in_one_chart() -> None:
    """Differences are those of the bodies, whatever the fits began with."""
    from bodyschema.answers.common_ground import CommonGround

    rng = np.random.default_rng(2)
    body = ARM.attach("camera", "tip", CAMERA)
    variables = join(free_joints(body), free_frame(body, "camera"))
    x = 1e-4 * rng.normal(size=len(variables))
    H = np.eye(len(x))
    plain = Estimate(body, variables, np.zeros(len(x)), H)
    for moved in (
        Estimate(body, variables, x, H),
        Estimate(body.with_variables(variables, x), variables, np.zeros(len(x)), H),
    ):
        found = CommonGround.of(plain, moved)
        assert found.difference == pytest.approx(x, abs=1e-7)


def test_what_cannot_be_compared_is_said(monday: Calibration) -> None:
    other = Body.random_chain(3, np.random.default_rng(1)).attach("board", "base")
    few = free_joints(other, ("offsets",))
    of_three = answer(Estimate(other, few, np.zeros(3), np.eye(3)))
    with pytest.raises(InputError, match=r"two robots: .*only one has joint_4"):
        compare(monday, of_three)
    tool = ARM.attach("tool", "tip")
    free = free_frame(tool, "tool")
    elsewhere = answer(Estimate(tool, free, np.zeros(6), np.eye(6)))
    board = ARM.attach("board", "base")
    own = answer(Estimate(board, free_frame(board, "board"), np.zeros(6), np.eye(6)))
    with pytest.raises(InputError, match="speak of other things, board and tool"):
        compare(own, elsewhere)
    with pytest.raises(InputError, match="learned from nothing"):
        compare(monday, replace(monday, from_nothing=True))
