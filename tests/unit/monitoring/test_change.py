"""The change test: what it finds, whom it blames, and how often it cries wolf."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from bodyschema import (
    Body,
    Filter,
    Poses,
    Solver,
    free_frame,
    free_joints,
    join,
    lie,
)
from bodyschema.estimation.discrepancy import Field
from bodyschema.estimation.estimate import Estimate
from bodyschema.model.kinematics import relative_pose
from bodyschema.monitoring.change import detect_change


@dataclass(frozen=True)
class Robot:
    """A calibrated robot and the truth behind it."""

    truth: Body
    fit: Estimate


def record(body: Body, n: int, rng: np.random.Generator, outliers: int = 0) -> Poses:
    q = rng.uniform(-1.5, 1.5, size=(n, len(body.joints)))
    T = relative_pose(body, q, "tracker", "hand").copy()
    T[:, :3, 3] += 1e-3 * rng.normal(size=(n, 3))
    T[:, :3, :3] = lie.exp_so3(5e-3 * rng.normal(size=(n, 3))) @ T[:, :3, :3]
    T[:outliers, :3, 3] += rng.uniform(-0.1, 0.1, size=(outliers, 3))
    return Poses.make(q, T, "tracker", "hand")


def calibrated(seed: int) -> Robot:
    rng = np.random.default_rng(seed)
    nominal = Body.random_chain(5, rng).attach("tracker", "base").attach("hand", "tip")
    offsets = free_joints(nominal, ("offsets",))
    truth = nominal.with_variables(offsets, 0.05 * rng.normal(size=5))
    frames = [free_frame(nominal, name) for name in ("tracker", "hand")]
    variables = join(offsets, *frames)
    return Robot(truth, Solver().fit(nominal, variables, [record(truth, 60, rng)]))


def test_unchanged_bodies_are_left_in_peace() -> None:
    alarms = 0
    for seed in range(60):
        robot = calibrated(seed)
        new = record(robot.truth, 30, np.random.default_rng(1000 + seed), outliers=2)
        alarms += detect_change(robot.fit, [new], false_alarm=0.05).changed
    # 5 % of 60 is 3; more than 8 would happen in less than 1 % of such trials.
    assert alarms <= 8


@pytest.mark.parametrize("seed", range(6))
def test_a_moved_joint_zero_is_found_and_blamed(seed: int) -> None:
    robot, rng = calibrated(seed), np.random.default_rng(50 + seed)
    joint = robot.truth.joints[1 + seed % 3]
    knocked = robot.truth.with_variables(
        free_joints(robot.truth, ("offsets",), [joint]), [np.deg2rad(1.0)]
    )
    answer = detect_change(robot.fit, [record(knocked, 40, rng, outliers=3)])
    assert answer.changed
    assert joint in {suspect.part for suspect in answer.suspects}
    blamed = next(suspect for suspect in answer.suspects if suspect.part == joint)
    assert blamed.change[0] == pytest.approx(np.deg2rad(1.0), abs=np.deg2rad(0.3))


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("number", [0, 4])
def test_a_joint_is_blamed_before_the_frame_beside_it(number: int, seed: int) -> None:
    """The first zero is a turn of the tracker, the last of the hand: each fits as well."""
    robot, rng = calibrated(seed), np.random.default_rng(70 + seed)
    zero = free_joints(robot.truth, ("offsets",), [robot.truth.joints[number]])
    knocked = robot.truth.with_variables(zero, [np.deg2rad(2.0)])
    answer = detect_change(robot.fit, [record(knocked, 40, rng)])
    assert answer.suspects[0].part == robot.truth.joints[number]
    assert answer.alone
    assert answer.suspects[0].share > 0.95


@pytest.mark.parametrize("seed", range(6))
def test_two_joints_at_once_are_no_single_part(seed: int) -> None:
    robot, rng = calibrated(seed), np.random.default_rng(80 + seed)
    zeros = free_joints(robot.truth, ("offsets",), [robot.truth.joints[i] for i in (1, 3)])
    knocked = robot.truth.with_variables(zeros, np.deg2rad([2.0, -1.5]))
    answer = detect_change(robot.fit, [record(knocked, 40, rng)])
    assert answer.changed
    assert not answer.alone
    assert answer.suspects[0].share < 0.9


@pytest.mark.parametrize("frame", ["tracker", "hand"])
def test_a_moved_frame_is_found_and_blamed(frame: str) -> None:
    robot, rng = calibrated(3), np.random.default_rng(9)
    T = robot.truth.placement[robot.truth.frame_index(frame)].copy()
    T[:3, 3] += [0.004, -0.002, 0.003]
    answer = detect_change(robot.fit, [record(robot.truth.with_placement(frame, T), 40, rng)])
    assert answer.changed
    assert answer.suspects[0].part == frame
    assert answer.p_value < 1e-6


def test_a_large_change_is_not_taken_for_outliers() -> None:
    robot, rng = calibrated(4), np.random.default_rng(2)
    T = robot.truth.placement[robot.truth.frame_index("hand")].copy()
    T[:3, 3] += [0.05, 0.0, 0.0]
    answer = detect_change(robot.fit, [record(robot.truth.with_placement("hand", T), 30, rng)])
    assert answer.changed
    assert answer.suspects[0].part == "hand"
    assert np.linalg.norm(answer.suspects[0].change[:3]) == pytest.approx(0.05, rel=0.1)


def test_a_residual_field_makes_the_test_more_careful() -> None:
    robot, rng = calibrated(5), np.random.default_rng(3)
    T = robot.truth.placement[robot.truth.frame_index("hand")].copy()
    T[:3, 3] += [0.001, 0.0, 0.0]
    new = record(robot.truth.with_placement("hand", T), 30, rng)
    plain = detect_change(robot.fit, [new])
    field = Field(length=1.0, amplitude=(0.003, 0.01), noise=(0.001, 0.005))
    careful = detect_change(robot.fit, [new], {new.label: field})
    assert careful.p_value > plain.p_value


def test_it_works_on_the_recursive_learner_too() -> None:
    robot, rng = calibrated(6), np.random.default_rng(4)
    learner = Filter(unknown=("tracker", "hand"))
    estimate = robot.fit
    state = learner.start(estimate.reference, estimate.variables)
    for i, sample in enumerate(record(robot.truth, 60, rng).take([i]) for i in range(60)):
        state, _ = learner.step(state, (sample,))
        assert state.started == (i >= learner.burn_in - 1)
    answer = detect_change(state.estimate, [record(robot.truth, 30, rng)])
    assert not answer.changed
