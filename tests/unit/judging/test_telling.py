"""Held-out errors vouch for what was seen; where that is no position, the hand must be told too."""

from __future__ import annotations

import numpy as np
import pytest

import bodyschema as bs
from bodyschema.answers.calibrate import calibrate
from bodyschema.errors import InputError
from bodyschema.judging import judgement
from bodyschema.judging.telling import untold
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_joints
from bodyschema.senses.sense import Sense
from self_contained import FRAMES, Tracker
from simulated import points, postures, random_pose
from two_arms import COUNT, SENSES, Robot, arms, draw_robot


def _table(seed: int, errors: float) -> tuple[Robot, list[Sense], Tracker]:
    """A robot that pats a table, and the tracker that the fit never sees."""
    rng = np.random.default_rng(seed)
    robot = draw_robot(rng, errors)
    senses = SENSES["planes"](robot, COUNT["planes"], rng)
    return robot, senses, Tracker.watching(robot, 100, rng)


def _answer(robot: Robot, senses: list[Sense]) -> bs.Answer:
    frames = dict.fromkeys(FRAMES["planes"], "no")
    return calibrate(robot.nominal, senses, frames, joints=arms(robot.nominal))


def test_heights_that_fit_better_do_not_make_a_worse_hand_right(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    robot, senses, tracker = _table(0, 0.1)
    answer = _answer(robot, senses)
    assert answer.verdict == "refused"
    assert "does not tell where" in answer.explanation
    assert tracker.error(answer.body) > tracker.error(robot.nominal)
    # Without the rule the same numbers are called a calibration.
    monkeypatch.setattr(judgement, "untold", lambda *_: None)
    assert _answer(robot, senses).verdict == "calibrated"


def test_a_correction_that_is_larger_than_its_doubt_stands() -> None:
    robot, senses, tracker = _table(0, 1.0)
    answer = _answer(robot, senses)
    assert answer.verdict == "calibrated"
    assert tracker.error(answer.body) < tracker.error(robot.nominal)


def test_positions_speak_for_themselves() -> None:
    rng = np.random.default_rng(0)
    arm = bs.Body.random_chain(3, rng)
    q = rng.uniform(-1, 1, (12, 3))
    seen = bs.Points.make(q, np.zeros((12, 3)), "base", "tip").imagined(arm, q)
    fit = bs.Solver().fit(arm, bs.free_joints(arm, ("offsets",)), [seen])
    assert untold(fit, fit, [seen], q) is None


def test_what_is_wanted_is_what_the_verdict_speaks_of():
    # A marker on the third link is seen; where the gripper is, two joints further, is not told.
    rng = np.random.default_rng(4)
    arm = Body.random_chain(5, rng).attach("tracker", "base", random_pose(rng, 1.0))
    nominal = arm.attach("marker", "link_4", random_pose(rng, 0.1))
    zeros = free_joints(nominal, ("offsets",))
    truth = nominal.with_variables(zeros, 0.05 * rng.normal(size=5))
    seen = points(truth, postures(60, truth, rng), rng, 5e-4, "tracker", "marker")
    frames = {"tracker": "no", "marker": "no"}
    mine = calibrate(nominal, [seen], frames, ["offsets"], folds=3)
    assert (mine.verdict, mine.trust.level) == ("calibrated", "good")
    hand = calibrate(nominal, [seen], frames, ["offsets"], folds=3, wanted=[("base", "tip")])
    assert hand.verdict == "refused"
    assert "what was seen does not tell what is wanted" in hand.explanation
    assert hand.stated_95 > 10 * mine.stated_95
    near = calibrate(nominal, [seen], frames, ["offsets"], folds=3, wanted=[("link_1", "link_4")])
    assert near.verdict == "calibrated"
    with pytest.raises(InputError, match="no frame 'grip'"):
        calibrate(nominal, [seen], frames, ["offsets"], wanted=[("base", "grip")])
