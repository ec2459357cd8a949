"""Recordings declared otherwise than they were made: named, and good ones are not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model.free_hand import free_hand, hand_readings
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.seeds.frame_fits import FrameFits
from bodyschema.seeds.open_chain import OpenChain
from bodyschema.senses.points import Points
from bodyschema.senses.poses import Poses
from bodyschema.senses.sense import Sense
from bodyschema.trust.declarations import Recorded, geared
from bodyschema.trust.neighbours import EXPLAINS, Neighbour, neighbourhood, neighbours
from bodyschema.trust.trials import Trials
from simulated import points, poses, postures, random_pose, random_poses, seen_arm

Array = NDArray[np.float64]
Change = Callable[[Array], Array]

OFF = np.deg2rad([0, 3, -2, 2, -3, 0])
"""Zeros that are wrong in every recording."""


def recorded(kind: str, n: int = 40, seed: int = 0) -> tuple[Body, Sense]:
    """A robot as described, and what is seen of one with other zeros."""
    rng = np.random.default_rng(seed)
    body = seen_arm(6, rng)
    make = points if kind == "points" else poses
    return body, make(replace(body, offset=OFF), postures(n, body, rng), rng)


def turned(sense: Sense, change: Change) -> Sense:
    """Poses with other rotations."""
    T = sense.observed.copy()
    T[:, :3, :3] = change(T[:, :3, :3])
    return replace(sense, observed=T)


def moved(sense: Sense, change: Change) -> Sense:
    """What was seen at other positions."""
    seen = sense.observed.copy()
    if seen.ndim == 3:
        seen[:, :3, 3] = change(seen[:, :3, 3])
    else:
        seen = change(seen)
    return replace(sense, observed=seen)


def read(sense: Sense, change: Change) -> Sense:
    return replace(sense, q=change(sense.q.copy()))


def wxyz_as_xyzw(R: Array) -> Array:
    return lie.rotation_from_xyzw(np.roll(lie.quaternion_xyzw(R), 1, axis=1))


def reversed_rpy(R: Array) -> Array:
    return lie.rotation_from_rpy(lie.rpy_from_rotation(R)[:, ::-1])


def swapped(q: Array) -> Array:
    return q[:, [0, 3, 2, 1, 4, 5]]


def times(joint: int, factor: float) -> Change:
    return lambda q: q * np.where(np.arange(q.shape[1]) == joint, factor, 1.0)


def named(
    body: Body, sense: Sense, layout: str = "", joint_unit: str = ""
) -> tuple[Neighbour, ...]:
    return neighbours(body, [sense], {sense.label: Recorded(layout, "m")}, None, joint_unit)


@pytest.mark.parametrize("kind", ["points", "poses"])
@pytest.mark.parametrize(
    ("change", "key", "entry"),
    [
        (lambda s: moved(s, lambda p: 1e3 * p), "unit", 'unit = "mm"'),
        (lambda s: moved(s, lambda p: 1e2 * p), "unit", 'unit = "cm"'),
        (lambda s: moved(s, lambda p: p / 0.0254), "unit", 'unit = "in"'),
        (lambda s: moved(s, lambda p: p / 1.4), "scale", ""),
        (lambda s: moved(s, lambda p: p * [1, -1, 1]), "axes", ""),
        (lambda s: read(s, swapped), "swap 1 3", "columns of joint_2 and joint_4"),
        (lambda s: read(s, times(2, -1)), "joint 2", ""),
        (lambda s: read(s, times(2, 0.6)), "joint 2", ""),
        (lambda s: read(s, np.rad2deg), "joint unit", '[joints] unit = "deg"'),
        (lambda s: replace(s.take(range(39)), q=s.q[1:]), "rows", ""),
        (lambda s: replace(s.take(range(1, 40)), q=s.q[:-1]), "rows", ""),
    ],
    ids=["mm", "cm", "in", "scale", "mirror", "swap", "sign", "gear", "degrees", "early", "late"],
)
def test_the_right_one_is_named(
    kind: str, change: Callable[[Sense], Sense], key: str, entry: str
) -> None:
    body, sense = recorded(kind)
    wrong = change(sense)
    best = named(body, wrong, joint_unit="rad")[0]
    assert (best.declaration.key, best.entry) == (key, entry)
    assert best.factor > 2
    mended = best.senses([wrong])
    assert neighbourhood(body, mended).share < 0.15


@pytest.mark.parametrize(
    ("change", "layout", "key", "entry"),
    [
        (lambda R: np.swapaxes(R, 1, 2), "matrix3x4", "transposed", ""),
        (wxyz_as_xyzw, "xyz_xyzw", "layout", 'layout = "xyz_wxyz"'),
        (wxyz_as_xyzw, "", "layout", 'layout = "xyz_wxyz"'),
        (reversed_rpy, "xyz_rpy", "layout", "columns"),
        (
            lambda R: lie.rotation_from_rpy(np.deg2rad(lie.rpy_from_rotation(R))),
            "xyz_rpy",
            "angle_unit",
            'angle_unit = "deg"',
        ),
        (
            lambda R: lie.exp_so3(lie.rpy_from_rotation(R)),
            "xyz_rotvec",
            "layout",
            'layout = "xyz_rpy"',
        ),
    ],
    ids=["transposed", "wxyz", "unknown", "reversed", "radians", "rpy"],
)
def test_rotations_read_otherwise_are_named(
    change: Change, layout: str, key: str, entry: str
) -> None:
    body, sense = recorded("poses")
    if layout == "xyz_rotvec":
        # Angles of more than half a turn come back as another vector: keep them small.
        small = np.linalg.norm(lie.log_so3(sense.observed[:, :3, :3]), axis=1) < 1.8
        sense = sense.take(small)
    if key == "angle_unit":
        entry, change = 'angle_unit = "rad"', change
        best = neighbours(
            body, [turned(sense, change)], {sense.label: Recorded(layout, "m", "deg")}
        )[0]
    else:
        best = named(body, turned(sense, change), layout)[0]
    assert best.declaration.key == key
    assert best.entry == entry or (entry == "columns" and "reverse" in best.words)


@pytest.mark.parametrize("kind", ["points", "poses"])
def test_an_eye_on_the_other_end_is_named(kind: str) -> None:
    body, sense = recorded("poses")
    truth = replace(body, offset=OFF)
    back = relative_pose(truth, sense.q, "tool", "tracker")
    wrong: Sense = Poses.make(sense.q, back, "tracker", "tool")
    if kind == "points":
        wrong = Points.make(sense.q, back[:, :3, 3], "tracker", "tool")
    best = named(body, wrong)[0]
    assert best.declaration.key == "mount"
    assert best.entry == ("inverse = true" if kind == "poses" else "")
    mended = best.senses([wrong])[0]
    frames = body.with_placement("tracker", np.eye(4))
    assert neighbourhood(frames, [wrong]).share > 0.3
    if kind == "points":
        assert (mended.seen_from, mended.seen) == ("tool", "tracker")


GOOD: dict[str, Callable[[np.random.Generator], tuple[Body, Body, int, float]]] = {
    "zeros": lambda rng: (b := seen_arm(6, rng), turned_body(b, 0.14, rng), 48, 0.0),
    "outliers": lambda rng: (b := seen_arm(6, rng), turned_body(b, 0.05, rng), 48, 0.3),
    "few": lambda rng: (b := seen_arm(5, rng), turned_body(b, 0.05, rng), 15, 0.0),
}


def turned_body(body: Body, size: float, rng: np.random.Generator) -> Body:
    return replace(body, offset=size * rng.normal(size=len(body.joints)))


@pytest.mark.parametrize("case", GOOD)
@pytest.mark.parametrize("kind", ["points", "poses"])
def test_good_recordings_get_no_name(case: str, kind: str) -> None:
    for seed in range(3):
        rng = np.random.default_rng(seed)
        body, truth, n, share = GOOD[case](rng)
        sense = (points if kind == "points" else poses)(truth, postures(n, body, rng), rng)
        bad = rng.random(n) < share
        shift = rng.uniform(-0.3, 0.3, (n, 3)) * bad[:, None]
        assert not named(body, moved(sense, lambda p, shift=shift: p + shift))


def test_zeros_a_quarter_turn_off_are_no_declaration() -> None:
    rng = np.random.default_rng(0)
    body = seen_arm(6, rng)
    truth = replace(body, offset=np.deg2rad([0, 0, 90, 0, 0, 0]))
    sense = poses(truth, postures(40, body, rng), rng)
    found = neighbourhood(body, [sense])
    assert found.share > 0.3
    assert not found.neighbours


def test_a_zero_that_looks_like_a_gear_is_no_gear() -> None:
    """Where a joint reads 0.8 to 1.2 rad, a zero of 0.25 rad is much like a quarter of it more."""
    rng = np.random.default_rng(1)
    body = seen_arm(6, rng)
    truth = replace(body, offset=np.array([0, 0, 0.25, 0, 0, 0]))
    q = postures(40, body, rng)
    q[:, 2] = rng.uniform(0.8, 1.2, 40)
    sense = poses(truth, q, rng)
    [gear] = Trials(body, OpenChain.all_of(body, [sense])).of([geared(body, 2, 1.25)])
    found = neighbourhood(body, [sense])
    assert found.share > 2 * gear.share
    assert gear.share < EXPLAINS
    assert not found.neighbours


def test_what_explains_hardly_anything_is_not_named() -> None:
    """In mm, and mostly noise: with the right unit a third of the spread would still be left."""
    body, sense = recorded("points")
    shift = 0.1 * np.random.default_rng(2).normal(size=(40, 3))
    found = neighbourhood(body, [moved(sense, lambda p: 1e3 * (p + shift))])
    assert found.share > 0.6
    assert not found.neighbours


def test_readings_of_joints_that_are_not_in_the_way_do_not_count() -> None:
    body, sense = recorded("poses")
    wider = body.attach("aside", "base")
    assert [n.declaration.key for n in named(wider, moved(sense, lambda p: 1e3 * p))] == ["unit"]


def test_two_senses_are_looked_at_apart() -> None:
    body, sense = recorded("poses")
    rng = np.random.default_rng(9)
    body = body.attach("second", "base", random_pose(rng, 1.0))
    truth = replace(body, offset=OFF)
    other = points(truth, sense.q, rng, seen_from="second")
    wrong = moved(other, lambda p: 1e3 * p)
    best = neighbours(body, [sense, wrong])[0]
    assert best.declaration.sense == wrong.label
    assert best.senses([sense, wrong])[0] is not None
    assert best.senses([sense, wrong])[1].observed == pytest.approx(other.observed)


# ---- a free hand: pose lists without a robot description ---------------------------------------


def lists(n: int = 40) -> tuple[Body, Array, Array]:
    """A free hand between eye and target, its poses, and what the eye saw."""
    rng = np.random.default_rng(3)
    A = random_poses(n, rng)
    T = lie.inverse(random_pose(rng, 1.0)) @ A @ random_pose(rng)
    T[:, :3, 3] += 1e-3 * rng.normal(size=(n, 3))
    return free_hand().attach("eye", "base").attach("target", "hand"), A, T


def hand_named(body: Body, A: Array, T: Array, robot: str = "", eye: str = "") -> set[str]:
    sense = Poses.make(hand_readings(A), T, "eye", "target")
    declared = {sense.label: Recorded(eye, "m")}
    return {n.declaration.key for n in neighbours(body, [sense], declared, Recorded(robot, "m"))}


def test_good_lists_get_no_name() -> None:
    assert not hand_named(*lists())


def test_lists_of_a_free_hand_are_named() -> None:
    body, A, T = lists()
    assert hand_named(body, A, lie.inverse(T)) == {"mount"}
    wrong = T.copy()
    wrong[:, :3, :3] = wxyz_as_xyzw(T[:, :3, :3])
    assert hand_named(body, A, wrong, eye="xyz_xyzw") == {"layout"}
    turned_hand = A.copy()
    turned_hand[:, :3, :3] = wxyz_as_xyzw(A[:, :3, :3])
    assert hand_named(body, turned_hand, T, robot="xyz_xyzw") == {"robot layout"}


def test_lengths_of_one_list_in_mm_may_be_those_of_the_other_in_km() -> None:
    """Only the ratio shows; the unit that there is comes first."""
    body, A, T = lists()
    wrong = T.copy()
    wrong[:, :3, 3] *= 1e3
    assert hand_named(body, A, wrong) == {"unit"}


def test_the_score_is_that_of_both_parts() -> None:
    one = FrameFits(
        R_X=np.eye(3)[None],
        scale=np.ones(1),
        position=np.array([0.1]),
        rotation=np.array([0.2]),
        posed=True,
        metres=np.zeros(1),
        radians=np.zeros(1),
        axes=np.eye(3)[None],
    )
    assert one.score[0] == pytest.approx(np.log(0.02))
    assert one.worst[0] == 0.2
