"""Online gradient: its step is the derivative, in any unit; what it learns, keeps and refuses."""

from __future__ import annotations

import pickle
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.learners.learner import run
from bodyschema.learners.published.online_gradient import OnlineGradient, from_nothing
from bodyschema.learners.skeletons.samples import SkeletonSamples
from bodyschema.model.kernels import FIXED, PRISMATIC, REVOLUTE
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.skeleton import Skeleton
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, join
from bodyschema.senses.points import Points
from bodyschema.senses.poses import Poses
from bodyschema.senses.touches import Touches
from bodyschema.studies.touching_arms import touches, two_arms

Array = NDArray[np.float64]


def fork(rng: np.random.Generator) -> Body:
    """A trunk with two arms, frames turned at zero posture, a slide in one arm."""
    parent = [-1, 0, 1, 2, 1, 4, 3, 5]
    kind = [FIXED, REVOLUTE, REVOLUTE, PRISMATIC, REVOLUTE, REVOLUTE, FIXED, FIXED]
    axis = rng.normal(size=(8, 3))
    placement = lie.transform(lie.exp_so3(rng.normal(size=(8, 3))), rng.normal(size=(8, 3)))
    placement[0] = np.eye(4)
    return Body.build(
        name="fork",
        frames=["root", "trunk", "arm", "slide", "limb", "elbow", "left", "right"],
        carriers=["", "trunk_j", "arm_j", "slide_j", "limb_j", "elbow_j", "left_j", "right_j"],
        parent=parent,
        kind=kind,
        axis=axis / np.linalg.norm(axis, axis=1, keepdims=True),
        placement=placement,
    )


def everything(body: Body) -> Variables:
    ends = [f for f, k in zip(body.frames[1:], body.kind[1:], strict=True) if k == FIXED]
    frames = [free_frame(body, frame, turn_std=None) for frame in ends]
    return join(free_joints(body, ("axes", "links")), *frames)


def touch(body: Body, rng: np.random.Generator, a: str = "left", b: str = "right") -> Touches:
    """One true touch, with the point anywhere."""
    q, v = rng.uniform(-2, 2, (1, len(body.joints))), rng.normal(size=(1, 3))
    T = relative_pose(body, q, a, b)
    return Touches.make(q, T[:, :3, :3] @ v[0] + T[:, :3, 3], v, a, b)


@pytest.mark.parametrize("seed", range(5))
def test_a_small_step_is_the_gradient_of_half_the_squared_residual(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = fork(rng)
    variables = everything(truth)
    body = from_nothing(truth, variables, 1.0, rng)
    sample, epsilon, length = touch(truth, rng), 1e-7, 1.7
    learner = OnlineGradient(epsilon=epsilon, length=length)
    state, (miss,) = learner.step(learner.start(body, variables), (sample,))
    assert miss.residual == pytest.approx(sample.residual(body)[0], abs=1e-13)
    old, new = Skeleton.of(body), state.skeleton

    def energy(axes: Array, links: Array) -> float:
        return 0.5 * float(
            np.sum(sample.residual(replace(old, axes=axes, links=links).into(body)) ** 2)
        )

    h = 1e-6
    for k in range(1, 8):
        for j in range(3):
            d = np.zeros((8, 3))
            d[k, j] = h
            slope = (energy(old.axes, old.links + d) - energy(old.axes, old.links - d)) / (2 * h)
            moved = (new.links - old.links)[k, j] / epsilon
            assert moved == pytest.approx(-slope, abs=1e-6)
        a = old.axes[k]
        for tangent in np.linalg.svd(a[None])[2][1:]:
            d = np.zeros((8, 3))
            d[k] = h * tangent
            slope = (energy(old.axes + d, old.links) - energy(old.axes - d, old.links)) / (2 * h)
            moved = (new.axes - old.axes)[k] @ tangent / epsilon
            assert moved == pytest.approx(-slope / length**2, abs=1e-5)


def test_one_segment_by_the_formula_of_the_paper() -> None:
    """Eq. 5, 7 and 9, written out with matrices."""
    rng = np.random.default_rng(1)
    body = Body.random_chain(1, rng)
    theta, v, seen = 0.7, rng.normal(size=3), rng.normal(size=3)
    a, link = body.axis[1], body.placement[1, :3, 3]
    R = lie.exp_so3(theta * a)
    e = seen - (link + R @ v)
    arrow = np.array([[0, v[2], -v[1]], [-v[2], 0, v[0]], [v[1], -v[0], 0]])
    D = np.sin(theta) * arrow + (1 - np.cos(theta)) * (np.outer(a, v) + a @ v * np.eye(3))
    a_new = a + 0.05 * e @ D
    learner = OnlineGradient(epsilon=0.05, length=1.0)
    start = learner.start(body, free_joints(body, ("axes", "links")))
    state, _ = learner.step(start, (Touches.make([theta], seen, v, "base", "link_1"),))
    assert state.body.placement[1, :3, 3] == pytest.approx(link + 0.05 * e, abs=1e-14)
    assert state.body.axis[1] == pytest.approx(a_new / np.linalg.norm(a_new), abs=1e-14)


@pytest.mark.parametrize("rule", ["constant", "decaying", "normalised"])
def test_millimetres_learn_as_metres_do(rule: str) -> None:
    rng = np.random.default_rng(2)
    truth = Body.random_chain(3, rng)
    body = from_nothing(truth, everything(truth), 0.2, rng)
    learner = OnlineGradient(0.1, rule, half_after=10, length=0.2)  # type: ignore[arg-type]
    small = big = learner.start(body, everything(body))
    in_mm = replace(learner, length=200.0)
    scaled = replace(small.skeleton, links=1e3 * small.skeleton.links)
    big = in_mm.start(scaled.into(body), everything(body))
    for _ in range(20):
        sample = touch(truth, rng, "base", "tip")
        mm = replace(sample, observed=1e3 * sample.position, touching=1e3 * sample.touching)
        small, big = learner.step(small, (sample,))[0], in_mm.step(big, (mm,))[0]
    assert big.skeleton.axes == pytest.approx(small.skeleton.axes, abs=1e-11)
    assert big.skeleton.links == pytest.approx(1e3 * small.skeleton.links, abs=1e-9)
    assert np.linalg.norm(small.skeleton.axes, axis=1) == pytest.approx(np.ones(5))
    assert np.abs(small.skeleton.links - Skeleton.of(body).links).max() > 0.01


def test_the_decaying_step_is_half_after_as_many_samples_as_said() -> None:
    rng = np.random.default_rng(3)
    body = Body.random_chain(2, rng)
    tip = free_frame(body, "tip", turn_std=None)
    learner = OnlineGradient(0.1, "decaying", half_after=50)
    state = learner.start(body, tip)
    sample = Points.make([0.3, 0.4], [1.0, 2.0, 3.0], "base", "tip")
    for steps, share in ((0, 0.1), (50, 0.05), (150, 0.025)):
        _, (before,) = learner.step(replace(state, steps=steps), (sample,))
        after, _ = learner.step(replace(state, steps=steps), (sample,))
        _, (left,) = learner.step(after, (sample,))
        assert left.distance == pytest.approx((1 - share) * before.distance)


def test_a_full_normalised_step_on_one_link_ends_the_error() -> None:
    body = Body.random_chain(2, np.random.default_rng(4))
    learner = OnlineGradient(1.0, "normalised")
    state = learner.start(body, free_frame(body, "tip", turn_std=None))
    sample = Points.make([0.3, 0.4], [1.0, 2.0, 3.0], "base", "tip")
    state, _ = learner.step(state, (sample,))
    state, (miss,) = learner.step(state, (sample,))
    assert miss.distance < 1e-14
    # Nothing left to learn: the step 0/0 must be none.
    exact = Points.make([0.0, 0.0], relative_pose(state.body, [0.0, 0.0], "base", "tip")[:3, 3],
                        "base", "tip")  # fmt: skip
    assert np.isfinite(learner.step(state, (exact,))[0].skeleton.links).all()


def test_only_what_is_free_moves() -> None:
    rng = np.random.default_rng(5)
    truth = fork(rng)
    learner = OnlineGradient(0.1)
    tool = learner.start(truth, free_frame(truth, "right", turn_std=None))
    elbow = learner.start(truth, free_joints(truth, ("axes",), ["elbow_j"]))
    sample = touch(fork(rng), rng)
    moved, _ = learner.step(tool, (sample,))
    assert moved.body.placement[:7] == pytest.approx(truth.placement[:7], abs=1e-15)
    assert np.abs(moved.body.placement[7] - truth.placement[7]).max() > 1e-3
    assert moved.body.axis == pytest.approx(truth.axis, abs=1e-15)
    turned, _ = learner.step(elbow, (sample,))
    assert turned.body.placement == pytest.approx(truth.placement, abs=1e-15)
    changed = np.linalg.norm(turned.body.axis - truth.axis, axis=1) > 1e-3
    assert changed.tolist() == [frame == "elbow" for frame in truth.frames]


def test_the_state_does_not_grow_and_senses_may_alternate() -> None:
    rng = np.random.default_rng(6)
    truth = fork(rng)
    learner = OnlineGradient(0.05)
    state = learner.start(from_nothing(truth, everything(truth), 1.0, rng), everything(truth))
    pairs = [("left", "right"), ("root", "left"), ("right", "arm"), ("elbow", "slide")]
    sizes: list[int] = []
    for i in range(40):
        state, _ = learner.step(state, (touch(truth, rng, *pairs[i % 4]),))
        sizes.append(len(pickle.dumps(state)))
    assert max(sizes[1:]) - sizes[1] <= 2
    assert state.steps == 40


def test_a_hand_seen_from_nothing() -> None:
    """Three joints, one frame seen at its origin, in one pass through the loop of all learners."""
    rng = np.random.default_rng(7)
    truth = Body.random_chain(3, rng)
    q = rng.uniform(-np.pi / 2, np.pi / 2, (6000, 3))
    seen = Points.make(q, relative_pose(truth, q, "base", "tip")[:, :3, 3], "base", "tip")
    learner = OnlineGradient(1.0, "normalised", length=0.2)
    state = learner.start(from_nothing(truth, everything(truth), 0.2, rng), everything(truth))
    *_, (state, _) = run(learner, state, [seen.take(range(3000))])
    left = np.linalg.norm(seen.take(range(3000, 6000)).residual(state.body), axis=1)
    assert left.max() < 0.01 * np.linalg.norm(truth.placement[:, :3, 3], axis=1).sum()


@pytest.mark.parametrize(
    ("free", "message"),
    [
        (("offsets",), "'joint_1.offset' is no joint axis and no link vector"),
        (("axes", "gears"), "'joint_1.gear' is no joint axis"),
    ],
)
def test_what_it_cannot_learn_is_refused(free: tuple[str, ...], message: str) -> None:
    body = Body.random_chain(2, np.random.default_rng(0))
    with pytest.raises(InputError, match=message):
        OnlineGradient().start(body, free_joints(body, free))


def test_refusals_that_say_what_to_do() -> None:
    body = Body.random_chain(2, np.random.default_rng(0))
    with pytest.raises(InputError, match=r"'tip.turn_x' is .*turn_std=None"):
        OnlineGradient().start(body, free_frame(body, "tip"))
    with pytest.raises(InputError, match="only 2 parameters of the link at 'tip' are free"):
        OnlineGradient().start(body, free_frame(body, "tip", turn_std=None).take([0, 2]))
    empty = replace(body, placement=np.tile(np.eye(4), (4, 1, 1)))
    with pytest.raises(InputError, match=r"typical `length` in m"):
        OnlineGradient().start(empty, everything(body))
    learner = OnlineGradient()
    state = learner.start(body, everything(body))
    pose = Poses.make([[0.0, 0.0]], np.eye(4)[None], "base", "tip")
    with pytest.raises(InputError, match="from Points and Touches, got Poses"):
        learner.step(state, (pose,))
    with pytest.raises(InputError, match=r"q with 2 columns \(joint_1, joint_2\), got 3"):
        learner.step(state, (Points.make([0.0] * 3, [0.0] * 3, "base", "tip"),))
    with pytest.raises(InputError, match="no step rule 'normal'"):
        OnlineGradient(rule="normal")  # type: ignore[arg-type]
    for wrong in ({"epsilon": -1.0}, {"half_after": 0.0}, {"length": 0.0}):
        with pytest.raises(InputError, match="must be above zero"):
            OnlineGradient(**wrong)  # type: ignore[arg-type]


@pytest.mark.parametrize("seed", [2, 3])
def test_two_arms_that_touch_each_other_learn_both_from_nothing(seed: int) -> None:
    """Nothing is seen. About every second random start ends in a false minimum, and its misses say
    so. The touches must lie on a skin that is large: a body of no size at all explains the touches
    of two finger tips almost as well as the true one."""
    rng = np.random.default_rng(seed)
    truth = two_arms(rng)
    felt = touches(truth, 0.2, 3000, rng)
    shown, fresh = felt.take(slice(0, -500)), felt.take(slice(-500, None))
    learner = OnlineGradient(1.0, "normalised", length=0.2)
    missed = []
    for _ in range(5):
        start = from_nothing(truth, everything(truth), 0.2, rng)
        state = learner.start(start, everything(truth))
        seen = SkeletonSamples.of(shown, state.reference, state.R0)
        for _ in range(10):
            state, _ = learner.descend(state, seen)
        ends = (start, state.body)
        missed.append([np.median(np.abs(fresh.residual(body))) for body in ends])
        missed[-1].append(np.median(np.abs(shown.residual(state.body))))
    untaught, taught, during = np.array(missed).T
    assert untaught.min() > 0.05
    assert taught[np.argmin(during)] < 1e-3
