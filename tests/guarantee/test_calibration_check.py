"""Is a calibration still true? Stated chance of a false alarm, the right part, the right moment."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import Body, Poses, Solver, free_frame, free_joints, join, lie
from bodyschema.answers.answer import Answer
from bodyschema.answers.recheck import recheck_senses
from bodyschema.errors import InputError
from bodyschema.model.kinematics import relative_pose
from bodyschema.monitoring.change import detect_change
from bodyschema.monitoring.stream_check import check_stream

Array = NDArray[np.float64]

STD = np.array([1e-3, 5e-3])


def record(body: Body, q: Array, noise: Array, wild: int = 0) -> Poses:
    """Poses of the hand with (n, 6) noise in units of `STD`; the first few are wild."""
    T = relative_pose(body, q, "tracker", "hand").copy()
    T[:, :3, 3] += STD[0] * noise[:, :3]
    T[:, :3, :3] = lie.exp_so3(STD[1] * noise[:, 3:]) @ T[:, :3, :3]
    T[:wild, :3, 3] += 0.2 * np.random.default_rng(0).normal(size=(wild, 3))
    return Poses.make(q, T, "tracker", "hand", tuple(STD), time=100 + np.arange(len(q)) / 30)


def calibrated(seed: int, samples: int = 25):
    """A robot, its calibration from a few poses, and randomness to go on with."""
    rng = np.random.default_rng(seed)
    nominal = Body.random_chain(4, rng).attach("tracker", "base").attach("hand", "tip")
    offsets = free_joints(nominal, ("offsets",))
    truth = nominal.with_variables(offsets, 0.05 * rng.normal(size=4))
    variables = join(offsets, *(free_frame(nominal, name) for name in ("tracker", "hand")))
    q = rng.uniform(-1.5, 1.5, (samples, 4))
    fit = Solver().fit(nominal, variables, [record(truth, q, rng.normal(size=(samples, 6)))])
    return truth, getattr(fit, "estimate", fit), rng


def test_an_unchanged_body_is_called_changed_no_more_often_than_stated() -> None:
    alarms, runs, chance = 0, 30, 0.2
    for seed in range(runs):
        truth, estimate, rng = calibrated(seed)
        q = rng.uniform(-1.5, 1.5, (20, 4))
        new = record(truth, q, rng.normal(size=(20, 6)), wild=2)
        alarms += detect_change(estimate, [new], false_alarm=chance).changed
    assert alarms <= runs * chance + 2.5 * np.sqrt(runs * chance * (1 - chance))


@pytest.mark.parametrize("joint", [0, 2])
def test_a_moved_joint_is_found_and_suspected_through_outliers(joint: int) -> None:
    truth, estimate, rng = calibrated(joint, 60)
    name = truth.joints[joint]
    knocked = truth.with_variables(free_joints(truth, ("offsets",), [name]), [np.deg2rad(3.0)])
    q = rng.uniform(-1.5, 1.5, (40, 4))
    answer = detect_change(estimate, [record(knocked, q, rng.normal(size=(40, 6)), wild=4)])
    assert answer.changed
    suspect = next(one for one in answer.suspects if one.part == name)
    assert suspect.change[0] == pytest.approx(np.deg2rad(3.0), rel=0.15)


def test_a_large_change_is_not_taken_for_outliers() -> None:
    truth, estimate, rng = calibrated(4, 60)
    T = truth.placement[truth.frame_index("hand")].copy()
    T[:3, 3] += [0.08, 0.0, 0.0]
    q = rng.uniform(-1.5, 1.5, (30, 4))
    new = record(truth.with_placement("hand", T), q, rng.normal(size=(30, 6)), wild=6)
    answer = detect_change(estimate, [new])
    assert answer.suspects[0].part == "hand"
    assert np.linalg.norm(answer.suspects[0].change[:3]) == pytest.approx(0.08, rel=0.02)


def moving(n: int, rng: np.random.Generator) -> Array:
    """A smooth motion at 30 samples a second, (n, 4)."""
    t, turns = np.arange(n)[:, None] / 30, rng.uniform(0.15, 0.5, (1, 4))
    return 1.2 * np.sin(2 * np.pi * turns * t + rng.uniform(0, 6, (1, 4)))


def test_a_recording_louder_and_slower_than_the_calibration_has_not_changed() -> None:
    for seed in range(2):
        truth, estimate, rng = calibrated(10 + seed, 60)
        noise = rng.normal(size=(400, 6))
        for i in range(1, 400):
            noise[i] = 0.8 * noise[i - 1] + 0.6 * noise[i]
        found = check_stream(estimate, [record(truth, moving(400, rng), 1.6 * noise)])
        assert found.changes == ()


def slow_error(n: int, rng: np.random.Generator) -> Array:
    """Noise of unit size, and beside it a sensor that wanders by as much in some ten seconds."""
    wander = np.zeros((n, 6))
    for i in range(1, n):
        wander[i] = 0.997 * wander[i - 1] + np.sqrt(1 - 0.997**2) * rng.normal(size=6)
    return 0.3 * rng.normal(size=(n, 6)) + 1.5 * wander


def test_a_slow_sensor_error_on_a_resting_robot_is_no_change() -> None:
    for seed in range(3):
        truth, estimate, rng = calibrated(seed, 60)
        rest = np.repeat(rng.uniform(-1.0, 1.0, (1, 4)), 900, axis=0)
        rest += 5e-5 * rng.normal(size=(900, 4))
        still = record(truth, rest, slow_error(900, rng))
        assert check_stream(estimate, [still]).changes == ()


def test_a_robot_that_only_rests_cannot_be_checked() -> None:
    truth, _, rng = calibrated(1, 60)
    still = record(truth, np.zeros((300, 4)), slow_error(300, rng))
    with pytest.raises(InputError, match="rests all through the recording"):
        recheck_senses(Answer.__new__(Answer), [still], 0.01)


def test_what_changed_while_a_robot_rested_shows_when_it_moves() -> None:
    truth, estimate, rng = calibrated(5, 60)
    name = truth.joints[2]
    knocked = truth.with_variables(free_joints(truth, ("offsets",), [name]), [np.deg2rad(3.0)])
    q = moving(1200, rng)
    q[400:700] = q[400]
    before, after = (record(body, q, rng.normal(size=(1200, 6))) for body in (truth, knocked))
    pose = np.concatenate([before.pose[:600], after.pose[600:]])
    both = Poses.make(q, pose, "tracker", "hand", tuple(STD), time=100 + np.arange(1200) / 30)
    (change, *_) = check_stream(estimate, [both]).changes
    assert change.part == name
    assert 100 + 600 / 30 - 8 < change.time < 100 + 700 / 30 + 5


def test_a_joint_that_jumps_is_named_dated_and_measured() -> None:
    truth, estimate, rng = calibrated(20, 60)
    name, q = truth.joints[1], moving(700, rng)
    knocked = truth.with_variables(free_joints(truth, ("offsets",), [name]), [0.02])
    noise = rng.normal(size=(700, 6))
    noise[390:394] *= 60.0
    before, after = record(truth, q, noise), record(knocked, q, noise)
    pose = np.concatenate([before.pose[:420], after.pose[420:]])
    stream = Poses.make(q, pose, "tracker", "hand", tuple(STD), time=before.time)
    (change,) = check_stream(estimate, [stream]).changes
    assert change.part == name
    assert change.time == pytest.approx(114.0, abs=0.2)
    assert change.change[0] == pytest.approx(0.02, abs=4 * change.std[0])
    assert change.std[0] < 4e-3
    assert change.p_value < 1e-6
