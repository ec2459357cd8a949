"""Change tests and the monitor: stated false alarms, delays, the right part blamed."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from bodyschema.estimation.belief import GaussianBelief, WhiteInnovation
from bodyschema.estimation.stream_noise import StreamNoise
from bodyschema.learners.hand_eye.point_memory import PointMemory
from bodyschema.learners.hand_eye.points import HandEyePoints
from bodyschema.learners.hand_eye.stereo_points import StereoPoints
from bodyschema.monitoring.block_ratio import BlockRatio, Window, noticeable, ratio
from bodyschema.monitoring.cusum import Cusum, Sums
from bodyschema.monitoring.excitation import missing_motion, turning
from bodyschema.monitoring.monitor import Monitor
from bodyschema.monitoring.whitening import prepare
from bodyschema.simulation.katana import Noise, project_points, stereo
from watched import errors, seen

LEARNER = HandEyePoints(stereo())


def watch(scene_now, stream, noise_of, monitor, state, first, last):
    """Feed part of a stream whose scene may have changed; the state and all events."""
    events = []
    for i in range(first, last):
        clean = project_points(scene_now, stream.T_world_hand[i : i + 1], stereo())[0]
        moment = StereoPoints(i / 30, stream.T_world_hand[i], clean + noise_of[i])
        state, report = monitor.step(state, (moment,))
        if report.event:
            events.append((i, report.event, report.block))
    return state, events


@pytest.fixture(scope="module", params=[0, 1])
def known(request):
    """A monitor that has identified, and what it takes to go on."""
    scene, stream = seen(400 + request.param, 60)
    noise = stream.pixels - project_points(scene, stream.T_world_hand, stereo())
    monitor = Monitor(LEARNER)
    state, events = watch(scene, stream, noise, monitor, monitor.start(), 0, 750)
    assert [event for _, event, _ in events] == ["identified"]
    assert state.mode == "observe"
    return scene, stream, noise, monitor, state


def test_a_certified_answer_is_true(known):
    scene, _, _, _, state = known
    assert (np.array(errors(state.belief.theta, scene)) < [0.2, 5, 2]).all()


@pytest.mark.parametrize("block", ["tool", "camera"])
def test_a_change_is_noticed_blamed_and_learned_again(known, block):
    scene, stream, noise, monitor, state = known
    if block == "tool":
        now = scene.rod_moved(np.array([0.03, -0.03, 0.0]))
    else:
        now = scene.head_moved(np.array([0.0, 0.1, 0.0]), np.array([0.04, 0.05, 0.0]))
    state, events = watch(now, stream, noise, monitor, state, 750, 1290)
    assert [event for _, event, _ in events[:3]] == ["alarm", "changed", "identified"]
    assert events[0][0] - 750 <= 5
    assert events[1][2] == block
    assert (np.array(errors(state.belief.theta, now)) < [0.2, 5, 2]).all()


def test_a_two_millimetre_slip_is_noticed_within_two_seconds(known):
    scene, stream, noise, monitor, state = known
    now = scene.rod_moved(np.array([0.0, 0.0014, 0.0014]))
    _, events = watch(now, stream, noise, monitor, state, 750, 960)
    assert events[0][1] == "alarm"
    assert events[0][0] - 750 <= 60


def test_a_burst_of_outliers_is_a_scare_not_a_change(known):
    scene, stream, noise, monitor, state = known
    burst = noise.copy()
    burst[750:756] += 80 * np.random.default_rng(0).normal(size=(6, 1, 3))
    state, events = watch(scene, stream, burst, monitor, state, 750, 900)
    assert [event for _, event, _ in events] == ["alarm", "dismissed"]
    assert state.mode == "observe"


def test_outliers_now_and_then_raise_no_alarm():
    scene, stream = seen(410, 60, wrong=Noise(wild=0.02))
    monitor = Monitor(LEARNER)
    state, events = monitor.start(), []
    for i in range(len(stream)):
        state, report = monitor.step(state, (stream.sample(i),))
        events += [report.event] if report.event else []
    assert events == ["identified"]
    assert (np.array(errors(state.belief.theta, scene)) < [0.2, 5, 2]).all()


def test_without_motion_the_machine_says_that_it_would_notice_little(known):
    _, stream, noise, monitor, moving = known
    still = moving
    clean = stream.pixels[749] - noise[749]
    for i in range(90):
        moment = StereoPoints(25 + i / 30, stream.T_world_hand[749], clean + noise[i])
        still, report = monitor.step(still, (moment,))
        assert not report.event
    seeing, blind = monitor.vigilance(moving), monitor.vigilance(still)
    assert seeing["tool"] < 0.01
    assert blind["camera"] > 100 * seeing["camera"]


def test_the_sum_keeps_its_rate_of_false_alarms():
    """Mean time to a false alarm at least as set, for each of the two sums, outliers included."""
    rng = np.random.default_rng(1)
    test = Cusum(1000.0)
    alarms, sums, samples = 0, Sums(), 60_000
    squares = np.where(rng.uniform(size=samples) < 0.02, 1e4, rng.chisquare(3, samples))
    for q in squares:
        sums, alarm = test.step(sums, [(float(q), 3)], 0.02, True)
        if alarm:
            alarms, sums = alarms + 1, Sums()
    assert alarms <= samples / 1000 + 3 * np.sqrt(samples / 1000)
    # It is a test, not a stone: twice the variance is noticed soon.
    sums, alarms = Sums(), 0
    for q in 2 * rng.chisquare(3, 200):
        sums, alarm = test.step(sums, [(float(q), 3)], 0.02, True)
        alarms += alarm
    assert alarms


def test_the_ratio_is_chi_square_with_the_beliefs_own_error_in_it():
    rng = np.random.default_rng(2)
    P = np.diag([0.5, 0.2, 0.4, 0.1])
    b, values = np.array([0, 1]), []
    for _ in range(3000):
        J = rng.normal(size=(30, 4))
        error = np.sqrt(np.diag(P)) * rng.normal(size=4)
        e = J @ error + rng.normal(size=30)
        values.append(ratio(J.T @ e, J.T @ J, P, b))
    assert np.mean(values) == pytest.approx(2, abs=0.12)
    assert np.mean(np.array(values) > chi2.isf(0.01, 2)) == pytest.approx(0.01, abs=0.006)


def test_the_ratio_names_the_block_and_moves_with_the_belief():
    rng = np.random.default_rng(3)
    test = BlockRatio(1e6, {"a": np.array([0, 1]), "b": np.array([2, 3])}, {"a": 1.0, "b": 1.0})
    window, P, blame = Window.empty(4), 1e-4 * np.eye(4), ""
    change = np.array([0.0, 0.0, 2.0, 0.0])
    for _ in range(60):
        J = rng.normal(size=(3, 4))
        window, blame = test.step(window, J @ change + rng.normal(size=3), J, P)
        if blame:
            break
    assert blame == "b"
    # A belief that knows the change is no longer surprised by what it saw.
    moved = window.move(change)
    H = window.H.sum(axis=0)
    assert ratio(moved.s.sum(axis=0), H, P, test.blocks["b"]) < 25
    assert noticeable(H, P, test.blocks["b"], 30.0) < 2.0
    assert noticeable(np.zeros((4, 4)), P, test.blocks["b"], 30.0) == np.inf


def test_correlated_innovations_are_made_white():
    rng = np.random.default_rng(4)
    belief = GaussianBelief(np.zeros((1, 1)), noise=StreamNoise(product=0.9))
    e, before, white = rng.normal(size=3), None, []
    source, J = np.zeros(3, dtype=np.int64), np.zeros((3, 1))
    for _ in range(4000):
        e = 0.9 * e + np.sqrt(1 - 0.81) * rng.normal(size=3)
        tested = prepare(WhiteInnovation(e, J, source), before, belief)
        before = tested.kept
        if len(tested.e):
            white.append(tested.e)
    rows = np.array(white)
    assert np.mean(rows[1:] * rows[:-1]) == pytest.approx(0, abs=0.03)
    assert np.var(rows) == pytest.approx(1, abs=0.06)


def test_the_missing_motion_is_named():
    _, stream = seen(0, 1)
    eyes = stereo()
    still = StereoPoints(0.0, stream.T_world_hand[0], stream.pixels[0])
    depth, keep = np.ones((1, 1)), np.ones((1, 1), bool)

    def of(poses):
        memory = PointMemory.empty(1)
        for T in poses:
            memory = memory.add(T[None], still.pixels[None], depth, keep, eyes.numbers)
        return memory

    from bodyschema import lie

    axis = np.array([0.0, 0.6, 0.8])
    one = [lie.transform(lie.exp_so3(a * axis), np.zeros(3)) for a in np.linspace(-0.5, 0.5, 30)]
    cross = [lie.transform(lie.exp_so3([a, 0, 0]), np.zeros(3)) for a in np.linspace(-0.5, 0.5, 30)]
    assert abs(turning(of(one)).axes[:, 0] @ axis) > 1 - 1e-9
    assert "(0.00, 0.60, 0.80) only" in missing_motion(of(one))
    assert missing_motion(of(one + cross)) == ""
    assert "hardly turned" in missing_motion(of(one[:1] * 5))
    assert "bring the point into view" in missing_motion(PointMemory.empty(1))
