"""What is certified is true, and beliefs are as sure as they say, whatever the noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.estimation.belief import forget
from bodyschema.estimation.certificate import Tolerance, bound, certify
from bodyschema.estimation.stream_noise import StreamNoise, measured
from bodyschema.learners.filter import Filter
from bodyschema.learners.hand_eye.points import HandEyePoints
from bodyschema.learners.hand_eye.stereo_points import StereoPoints
from bodyschema.learners.learner import moments
from bodyschema.learners.watched_body import WatchedBelief, WatchedBody
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.senses.points import Points
from bodyschema.simulation.katana import Noise, stereo
from linear_learner import Monitor, watch
from simulated import drawn, free_all, postures, seen_arm
from watched import errors, learned, seen, truth

Array = NDArray[np.float64]

UNITS = {"tip": "m"}


def remembering(r: float, shape: tuple[int, ...], rng: np.random.Generator) -> Array:
    """Noise of unit variance whose samples remember the one before, (n, ...)."""
    e = rng.normal(size=shape)
    for i in range(1, len(e)):
        e[i] = r * e[i - 1] + np.sqrt(1 - r * r) * e[i]
    return e


# Bounds.


def test_of_a_hundred_certified_at_most_one_is_outside() -> None:
    rng, outside = np.random.default_rng(0), 0
    for _ in range(2000):
        root = np.diag(rng.uniform(0.2, 1.0, 3)) @ np.linalg.qr(rng.normal(size=(3, 3)))[0]
        error = root @ rng.normal(size=3)
        outside += np.linalg.norm(error) > bound(root @ root.T)
    assert outside <= 20 + 3 * np.sqrt(20)


def certificate(covariance: Array, fit: float = 1.0, gap: float = 1e3, budget: float = 0.0):
    """Of a tip wanted to 1 mm."""
    tolerance = Tolerance({"tip": 1e-3}, {"tip": budget})
    return certify(tolerance, {"tip": covariance}, fit, 1000.0, gap, UNITS)


def test_a_certificate_needs_bounds_fit_and_no_rival() -> None:
    good = 0.25e-3**2 * np.eye(3)
    assert certificate(good).holds
    assert not certificate(np.diag([1, 1, 1.6]) ** 2 * good).holds
    assert not certificate(good, fit=1.5).holds
    assert not certificate(good, fit=0.5).holds
    assert not certificate(good, gap=5.0).holds
    assert not certificate(good, budget=0.9e-3).holds
    assert certificate(good).bounds["tip"] == pytest.approx(0.842e-3, rel=1e-3)


# Noise.


def test_outliers_and_memory_do_not_spoil_the_level() -> None:
    rng, noise, before = np.random.default_rng(1), StreamNoise(), None
    for e in 2.0 * remembering(0.8, (3000, 3), rng):
        e = e + 100.0 * (rng.uniform() < 0.1)
        noise = noise.learn(e, before, float(e @ e))
        before = e if e @ e < 200 else None
    assert noise.level == pytest.approx(4.0, rel=0.25)
    assert noise.long_run == pytest.approx(9.0, rel=0.35)
    assert 0.1 < noise.outlier_share < 0.13


def test_noise_of_a_recording_is_measured_through_its_changes() -> None:
    rng = np.random.default_rng(2)
    J = rng.normal(size=(900, 3, 2))
    d = np.where(np.arange(900)[:, None] < 430, 0.0, 30.0) * [1.0, 0.5]
    e = np.einsum("nij,nj->ni", J, d) + 1.5 * rng.normal(size=(900, 3))
    noise = measured([e], [J])
    assert noise.level == pytest.approx(2.25, rel=0.15)
    assert noise.correlation < 0.1
    slow = measured([remembering(0.9, (3000, 3), rng)], [rng.normal(size=(3000, 3, 2))])
    assert slow.correlation == pytest.approx(0.9, abs=0.08)


# Hand and eye.


@pytest.mark.parametrize("correlation", [0.0, 0.9])
def test_a_hand_that_certifies_itself_is_right(correlation: float) -> None:
    learner, squares = HandEyePoints(stereo()), []
    for seed in range(5):
        scene, stream = seen(700 + seed, 25, wrong=Noise(correlation))
        state, certified = learner.start(), False
        for i in range(len(stream)):
            state, _ = learner.step(state, (stream.sample(i),))
            if i % 10 == 0 and learner.certificate(state).holds:
                certified = True
                break
        if not certified:
            continue
        assert (np.array(errors(state.theta, scene)) < [0.2, 5, 2]).all()
        away = truth(scene).away_from(state.theta)
        squares.append(float(away @ np.linalg.solve(state.covariance, away)))
    assert len(squares) >= 3
    assert np.mean(squares) < 9 + 3 * np.sqrt(18 / len(squares))


def test_a_forgotten_part_leaves_the_rest_as_uncertain_as_it_was() -> None:
    learner = HandEyePoints(stereo())
    _, stream = seen(1, 10)
    state = learned(learner, stream)
    prior = learner.forget(state, "tool").prior
    assert prior is not None
    rest = np.arange(6)
    told = np.linalg.inv(prior.information[np.ix_(rest, rest)])
    assert told == pytest.approx(state.covariance[np.ix_(rest, rest)], rel=1e-6)
    assert not prior.information[6:].any()


def test_what_was_known_pulls_in_what_a_belief_costs() -> None:
    learner = HandEyePoints(stereo())
    state = learned(learner, seen(4, 15)[1])
    fresh = learner.forget(state, "tool")
    for i in range(15):
        fresh, _ = learner.step(fresh, (seen(4, 15)[1].sample(i),))
    assert fresh.theta is not None
    away = np.array([0, 0, 0, 5e-3, 0, 0, 0, 0, 0])
    moved = replace(fresh, theta=fresh.theta.move(away))
    pull = away @ fresh.prior.information @ away
    assert pull > 10
    assert learner.belief(moved).cost == pytest.approx(learner.belief(fresh).cost + pull, rel=0.3)


def test_forgetting_leaves_the_marginal_of_the_rest() -> None:
    rng = np.random.default_rng(5)
    A = rng.normal(size=(20, 6))
    L, block, rest = A.T @ A, np.array([1, 4]), np.array([0, 2, 3, 5])
    after = np.linalg.inv(forget(L, block, np.array([4.0, 9.0])))
    before = np.linalg.inv(L)
    assert after[np.ix_(rest, rest)] == pytest.approx(before[np.ix_(rest, rest)])
    assert after[np.ix_(block, block)] == pytest.approx(np.diag([0.25, 1 / 9]))
    assert after[np.ix_(rest, block)] == pytest.approx(0)
    assert not forget(L, block)[block].any()


def test_a_forgotten_part_does_not_forgive_the_others() -> None:
    """Blame is weighed with the pull of what was known: a moved camera is no changed tool."""
    learner = HandEyePoints(stereo())
    scene, stream = seen(2, 25)
    state = learned(learner, stream)
    moved = scene.head_moved(np.array([0.0, 0.1, 0.0]), np.array([0.04, 0.05, 0.0]))
    from bodyschema.simulation.katana import project_points

    pixels = project_points(moved, stream.T_world_hand, stereo())
    pixels = pixels + 0.5 * np.random.default_rng(3).normal(size=pixels.shape)
    wrong, right = learner.forget(state, "tool"), learner.forget(state, "camera")
    for i in range(60):
        sample = StereoPoints(i / 30, stream.T_world_hand[i], pixels[i])
        wrong, right = (learner.step(state, (sample,))[0] for state in (wrong, right))
    assert learner.belief(right).explains
    assert not learner.belief(wrong).explains
    assert not learner.certificate(wrong).holds


def test_a_stream_that_stops_fitting_loses_its_certificate() -> None:
    learner = HandEyePoints(stereo())
    _, stream = seen(3, 30)
    state = learned(learner, stream)
    assert learner.certificate(state).holds
    assert not learner.belief(state).diverged
    for i in range(30):
        moment = stream.sample(i)
        state, _ = learner.step(
            state, (replace(moment, pixels=moment.pixels + np.array([60.0, 0.0, 0.0])),)
        )
    assert not learner.certificate(state).holds
    assert learner.belief(state).diverged


# A body.


class Arm:
    """A small arm seen as points: at random postures, or, where noise remembers, on its way."""

    def __init__(self, seed: int, r: float = 0.0, joints: int = 3) -> None:
        self.rng, self.r = np.random.default_rng(seed), r
        nominal = seen_arm(joints, self.rng)
        self.variables = free_all(nominal, turns=False)
        self.truth = nominal.with_variables(self.variables, drawn(self.variables, self.rng, 0.3))
        self.learner = WatchedBody(nominal, self.variables, Filter(burn_in=40))
        self.noise, self.time = self.rng.normal(size=3), 0
        self.turns = self.rng.uniform(0.05, 0.2, joints), self.rng.uniform(0, 6, joints)

    def look(self, n: int, body: Body | None = None, wild: float = 0.0):
        """Moments."""
        body = body or self.truth
        t = (self.time + np.arange(n)[:, None]) / 30
        q, e = 2.0 * np.sin(2 * np.pi * self.turns[0] * t + self.turns[1]), np.empty((n, 3))
        if not self.r:
            q = postures(n, body, self.rng)
        self.time += n
        for i in range(n):
            self.noise = self.r * self.noise
            self.noise += np.sqrt(1 - self.r**2) * self.rng.normal(size=3)
            e[i] = 1e-3 * self.noise
        e += wild * self.rng.normal(size=(n, 3))
        position = relative_pose(body, q, "tracker", "tool")[:, :3, 3] + e
        return moments([Points.make(q, position, "tracker", "tool", 1e-3)])

    def taught(self, n: int) -> WatchedBelief:
        """The belief after so many moments."""
        state = self.learner.start()
        for moment in self.look(n):
            state, _ = self.learner.step(state, moment)
        return state


def test_a_body_s_belief_is_as_sure_as_it_says_in_noise_that_remembers() -> None:
    shares = []
    for seed in range(8):
        arm = Arm(seed, r=0.8)
        state = arm.taught(600)
        P = arm.learner.belief(state).doubt
        q = np.concatenate([moment[0].q for moment in arm.look(300)])[::10]
        told = state.filter.estimate.body
        ours, true = (
            relative_pose(body, q, "tracker", "tool")[:, :3, 3] for body in (told, arm.truth)
        )
        (moment,) = arm.look(1)
        J = (
            moment[0]
            .imagined(told, q)
            .linearize(state.filter.reference, arm.variables, state.filter.anchor)
        )
        spread = np.einsum("nik,kl,nil->n", J.by_parameter, P, J.by_parameter)
        shares.append(np.mean(np.sum((ours - true) ** 2, axis=1) / spread))
    assert 0.4 < np.mean(shares) < 2.0


def test_a_certified_body_predicts_to_the_bound_in_all_its_workspace() -> None:
    for seed in range(4):
        arm = Arm(20 + seed)
        state = arm.taught(150)
        found = arm.learner.certificate(state).bounds["position"]
        q = postures(400, arm.truth, arm.rng)
        P = arm.learner.belief(state).doubt
        (moment,) = arm.look(1)
        J = (
            moment[0]
            .imagined(arm.truth, q)
            .linearize(state.filter.reference, arm.variables, state.filter.x)
        )
        spread = J.by_parameter @ P @ np.swapaxes(J.by_parameter, 1, 2)
        widest = np.sqrt(np.linalg.eigvalsh(spread)[:, -1])
        assert found > 3.37 * np.quantile(widest, 0.9)


def test_a_body_is_not_certified_at_once_nor_while_samples_do_not_fit() -> None:
    arm = Arm(30)
    state = arm.taught(45)
    easy = replace(arm.learner, tolerance=Tolerance({"position": 1.0}))
    assert not easy.certificate(state).holds
    for moment in arm.look(60):
        state, _ = easy.step(state, moment)
    assert easy.certificate(state).holds
    assert not easy.belief(state).diverged
    for moment in arm.look(30, wild=0.5):
        state, _ = easy.step(state, moment)
    assert not easy.certificate(state).holds
    assert easy.belief(state).diverged


def test_a_wrong_part_learned_again_is_not_certified() -> None:
    arm = Arm(31)
    state = arm.taught(200)
    joint = arm.truth.joints[1]
    moved = arm.truth.with_variables(
        arm.variables.take([arm.variables.names.index(f"{joint}.offset")]), [0.05]
    )
    easy = replace(arm.learner, tolerance=Tolerance({"position": 1.0}))
    wrong, right = easy.forget(state, arm.truth.joints[0]), easy.forget(state, joint)
    for moment in arm.look(60, moved):
        wrong, right = (easy.step(state, moment)[0] for state in (wrong, right))
    assert easy.certificate(right).holds
    assert not easy.certificate(wrong).holds


def test_one_outlier_does_not_decide_what_a_belief_costs() -> None:
    arm = Arm(32)
    fresh = arm.learner.forget(arm.taught(150), "")
    for moment in arm.look(20):
        fresh, _ = arm.learner.step(fresh, moment)
    before = arm.learner.belief(fresh).cost
    (wild,) = arm.look(1, wild=1.0)
    after, _ = arm.learner.step(fresh, wild)
    assert arm.learner.belief(after).cost < before + 60


def test_a_scare_is_no_change_though_noise_remembers() -> None:
    """Noise that remembers looks like a change of something for a while."""
    for seed in (40, 41, 43):
        arm = Arm(seed, r=0.9)
        state = arm.taught(500)
        monitor = Monitor(arm.learner, 1e6)
        samples = arm.look(6, wild=1.0) + arm.look(105)
        _, events = watch(monitor, monitor.observing(state), samples)
        assert [event for _, event, _ in events] == ["alarm", "dismissed"]


@pytest.mark.parametrize("r", [0.0, 0.8])
def test_a_joint_that_moved_is_named_and_learned_again(r: float) -> None:
    arm = Arm(50, r)
    state = arm.taught(400)
    joint = arm.truth.joints[1]
    row = arm.variables.names.index(f"{joint}.offset")
    moved = arm.truth.with_variables(arm.variables.take([row]), [0.03])
    monitor = Monitor(arm.learner, 1e6)
    after, events = watch(monitor, monitor.observing(state), arm.look(160, moved))
    assert ("changed", joint) in [(event, block) for _, event, block in events]
    step = after.belief.filter.x[row] - state.filter.x[row]
    assert step == pytest.approx(0.03, abs=5e-3)
