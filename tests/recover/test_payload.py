"""A known load is found again, inside its own error bars, from wrenches and encoders."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.estimation.loads import com_covariance
from bodyschema.learners.payload.clock_lag import clock_lag, shifted
from bodyschema.learners.payload.learner import LoadLearner
from bodyschema.learners.payload.recorded import Part, fit_payload
from bodyschema.learners.payload.untold import untold
from bodyschema.learners.published.paper_payload import PaperPayload, load_of, paper_rows
from bodyschema.monitoring.monitor import Monitor
from bodyschema.senses.wrench_means import Averaging, postures
from bodyschema.simulation.loads import (
    Held,
    Sensor,
    draw_load,
    draw_motion,
    draw_sensor,
    feel,
    joined,
    record,
    wire_box,
)
from bodyschema.trust.wrench_doubt import doubt

BOX = wire_box()


def recorded(seed, seconds=10.0, speed=0.5, held=None, sensor=None):
    rng = np.random.default_rng([11, seed])
    motion = draw_motion(rng, seconds, speed, 100.0)
    sensor = sensor or draw_sensor(rng, np.radians(1))
    return record(motion, held or [Held(0.0, BOX)], sensor, rng)


def one(samples, learner=None, window=0.5):
    means = Averaging(window).means(samples)
    return fit_payload([Part(means, ("load",))], learner or LoadLearner())


@pytest.mark.parametrize("speed", [0.5, 1.0])
def test_ten_parameters_lie_within_their_error_bars(speed):
    inside, mass = [], []
    for seed in range(8):
        fit = one(recorded(seed, speed=speed))
        load, std = fit.loads["load"], np.sqrt(np.diag(fit.covariance("load")))
        inside.append(np.abs(load.phi - BOX.phi) < 1.96 * std)
        mass.append(abs(load.mass / BOX.mass - 1))
        assert load.physical
        assert np.linalg.norm(load.com - BOX.com) < 2e-4
    assert 0.85 < np.mean(inside) <= 1.0
    assert np.median(mass) < 5e-4


def test_a_stream_ends_at_the_answer_of_the_whole_and_certifies_itself():
    means, learner = Averaging().means(recorded(0)), LoadLearner()
    belief, when = learner.start(), None
    for k in range(len(means)):
        belief, _ = learner.step(belief, (means.take(slice(k, k + 1)),))
        if when is None and learner.certificate(belief).holds:
            when = means.time[k]
            assert abs(belief.load.mass / BOX.mass - 1) < 0.01
            assert np.linalg.norm(belief.load.com - BOX.com) < 1e-3
    assert 0.5 < when < 6
    whole, _ = learner.step(learner.start(), (means,))
    np.testing.assert_allclose(belief.load.mass, whole.load.mass, rtol=2e-5)
    np.testing.assert_allclose(belief.load.com, whole.load.com, atol=2e-5)


def test_the_state_does_not_grow():
    means, learner = Averaging().means(recorded(0)), LoadLearner()
    early, _ = learner.step(learner.start(), (means.take(slice(0, 20)),))
    late, _ = learner.step(early, (means.take(slice(20, None)),))
    assert [a.shape for a in (early.sums.S, early.sums.partial)] == [
        a.shape for a in (late.sums.S, late.sums.partial)
    ]


def test_a_sensor_mounted_anyhow_is_found():
    turn = lie.exp_so3([1.2, -0.7, 2.0])
    sensor = Sensor(np.array([0.5, -0.4, 0.3, 0.02, -0.01, 0.01]), turn)
    fit = one(recorded(1, sensor=sensor), LoadLearner(turn_std=np.inf))
    assert np.linalg.norm(lie.log_so3(fit.R @ turn.T)) < np.radians(0.05)
    np.testing.assert_allclose(fit.loads["load"].com, BOX.com, atol=3e-4)
    np.testing.assert_allclose(turn.T @ fit.solution.guess.bias[:3], sensor.bias[:3], atol=5e-3)


def test_spikes_are_left_out():
    samples = recorded(2)
    wrench = samples.wrench.copy()
    wrench[300:330, 0] += 5.0
    fit = one(replace(samples, wrench=wrench))
    assert 1 <= int((~fit.kept[0]).sum()) < 12
    assert abs(fit.loads["load"].mass / BOX.mass - 1) < 2e-3


@pytest.mark.parametrize("late", [0.0, 0.013, -0.04])
def test_a_clock_that_runs_late_is_found(late):
    samples = recorded(12)
    found = clock_lag(shifted(samples, -late), LoadLearner(), Averaging())
    assert found.lag == pytest.approx(late, abs=2e-3)


def test_cross_talk_widens_the_error_bars():
    samples = recorded(13)
    rng, z = np.random.default_rng(0), []
    scale = np.array([1.0, 1, 1, 0.05, 0.05, 0.05])
    clean = doubt(one(samples), LoadLearner(), None)
    assert not clean.left
    assert (clean.whole == clean.core).all()
    for _ in range(4):
        mixed = np.eye(6) + 0.01 * rng.normal(size=(6, 6)) * np.outer(scale, 1 / scale)
        fit = one(replace(samples, wrench=samples.wrench @ mixed.T))
        found = doubt(fit, LoadLearner(), None)
        assert found.left[0].family == "gains"
        assert 0.3 < found.left[0].size / 0.01 < 3
        fit = replace(fit, whole=found.whole)
        error = fit.loads["load"].phi - BOX.phi
        z.append(error[:4] / np.sqrt(np.diag(fit.covariance("load"))[:4]))
        noise = np.sqrt(np.diag(fit.solution.phi_covariance(0))[:4])
        assert (np.sqrt(np.diag(fit.covariance("load"))[:4]) > 1.3 * noise).all()
    assert np.sqrt(np.mean(np.square(z))) < 2


def test_the_object_is_told_from_the_gripper():
    rng = np.random.default_rng(3)
    grip, thing = draw_load(rng, 0.4), draw_load(rng, 0.25)
    samples = recorded(3, 24.0, held=[Held(0.0, grip), Held(12.0, joined(grip, thing))])
    means = Averaging().means(samples)
    parts = [
        Part(means.take(means.time < 11.5), ("gripper",)),
        Part(means.take(means.time > 12.5), ("gripper", "object")),
    ]
    fit = fit_payload(parts, LoadLearner())
    for name, truth in (("gripper", grip), ("object", thing)):
        e = fit.loads[name].phi - truth.phi
        assert e[:4] @ np.linalg.solve(fit.covariance(name)[:4, :4], e[:4]) < 23  # 1e-4 of chi2_4
        assert fit.loads[name].physical
    assert abs(fit.loads["object"].mass - 0.25) < 2e-3


def test_postures_tell_mass_and_centre_but_no_inertia():
    samples = recorded(4, 60.0, speed=0.5).take(slice(0, 6000, 300))
    rest = np.einsum("nji,j->ni", samples.rotation, -np.asarray(samples.down)) * BOX.mass
    noise = np.random.default_rng(0).normal(size=(len(rest), 6)) * [*[0.02] * 3, *[5e-4] * 3]
    wrench = np.hstack([rest, np.cross(BOX.com, rest)]) + noise + 0.1
    fit = fit_payload([Part(postures(replace(samples, wrench=wrench)), ("load",))], LoadLearner())
    load, P = fit.loads["load"], fit.covariance("load")
    assert abs(load.mass - BOX.mass) < 4 * np.sqrt(P[0, 0]) < 0.02
    step = load.com - BOX.com
    assert step @ np.linalg.solve(com_covariance(load, P), step) < 21
    assert {one.what for one in untold(load, P)} == {
        "I_xx", "I_xy", "I_yy", "I_xz", "I_yz", "I_zz",
    }  # fmt: skip


def test_one_posture_tells_neither_mass_nor_centre_and_says_so():
    samples = recorded(5).take(np.zeros(6, dtype=int))
    fit = fit_payload([Part(postures(samples), ("load",))], LoadLearner())
    named = {one.what for one in untold(fit.loads["load"], fit.covariance("load"))}
    assert {"mass", "com"} <= named


def test_the_wrong_sign_is_recognised():
    samples = recorded(6)
    with pytest.raises(InputError, match="other sign"):
        one(replace(samples, wrench=-samples.wrench))


def test_the_papers_form_is_right_at_rest_and_wrong_with_an_offset():
    motion = draw_motion(np.random.default_rng(7), 20.0, 0.05, 100.0)
    rest = replace(motion, w=0 * motion.w, dw=0 * motion.dw)
    rest = replace(rest, a_g=np.einsum("nji,j->ni", motion.R, [0, 0, 9.81]))
    learner = PaperPayload()
    answers = []
    for bias in (np.zeros(6), np.array([0.5, 0.3, -0.4, 0.02, 0.01, 0.0])):
        sensor = Sensor(bias, np.eye(3))
        y = feel(rest, [Held(0.0, BOX)], sensor, np.random.default_rng(8))
        A = paper_rows(motion.R, y[:, :3], y[:, 3:], np.array([0, 0, -9.81]))
        state = learner.start()
        for rows in A[::5]:
            state, _ = learner.step(state, (rows,))
        assert state.x is not None or bias.any()
        answers.append(load_of(learner.solve(state.moments).x))
    (mass, com), (wrong_mass, wrong_com) = answers
    assert abs(mass / BOX.mass - 1) < 2e-3
    assert np.linalg.norm(com - BOX.com) < 1e-3
    off = abs(wrong_mass / BOX.mass - 1) > 0.01 or np.linalg.norm(wrong_com - BOX.com) > 3e-3
    assert off


def test_grasp_swap_and_release_are_noticed_and_named():
    rng = np.random.default_rng(9)
    grip = draw_load(rng, 0.35)
    held = [
        Held(0.0, grip),
        Held(8.0, joined(grip, draw_load(rng, 0.05))),
        Held(16.0, joined(grip, draw_load(rng, 1.0))),
        Held(24.0, grip),
    ]
    samples = recorded(9, 32.0, held=held)
    means, watch = Averaging().means(samples), Monitor(LoadLearner())
    state, events, alarms = watch.start(), [], []
    for k in range(len(means)):
        state, report = watch.step(state, (means.take(slice(k, k + 1)),))
        if report.event == "alarm":
            alarms.append(float(means.time[k]))
        elif report.event:
            events.append((report.change or report.event, state.belief.load.mass))
    assert [name for name, _ in events] == ["identified", "grasp", "swap", "release"]
    np.testing.assert_allclose([m for _, m in events], [h.load.mass for h in held], rtol=0.02)
    for change in held[1:]:
        assert 0 < min(a - change.since for a in alarms if a > change.since - 0.3) + 0.3 < 1.0


def test_nothing_happens_while_nothing_changes():
    means, watch = Averaging().means(recorded(10, 60.0)), Monitor(LoadLearner())
    state, events = watch.start(), []
    for k in range(len(means)):
        state, report = watch.step(state, (means.take(slice(k, k + 1)),))
        events += [report.event] if report.event else []
    assert events == ["identified"]
