"""First values: every combination of unknown frames, with gross outliers, from no guess at all."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema.errors import InputError
from bodyschema.model import parts
from bodyschema.model.inertia import Inertia
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.seeds import starts
from bodyschema.seeds.starts import start_frames
from bodyschema.senses.gravity import G, Gravity
from bodyschema.senses.sense import Sense
from bodyschema.senses.wrist_wrenches import WristWrenches
from simulated import angle, forgotten, points, poses, postures, random_pose, seen_arm, spoiled

Array = NDArray[np.float64]

SENSES = {"points": points, "poses": poses}
OUTLIERS, SIZE = 0.15, 0.2
"""Share of the samples, and m."""

NEAR, TURNED = 0.01, np.deg2rad(1)
"""m and rad."""


def off(found: Body, truth: Body, frame: str) -> tuple[float, float]:
    """Error of a placement in m and rad."""
    T, true = (body.placement[body.frame_index(frame)] for body in (found, truth))
    return float(np.linalg.norm(T[:3, 3] - true[:3, 3])), angle(T, true)


def lengths(residual: Array) -> Array:
    return np.asarray(np.linalg.norm(residual[:, :3], axis=1))


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("unknown", [("tracker",), ("tool",), ("tracker", "tool")])
@pytest.mark.parametrize("sense", SENSES)
def test_unknown_frames_are_found_among_outliers(
    sense: str, unknown: tuple[str, ...], seed: int
) -> None:
    rng = np.random.default_rng(seed)
    truth = seen_arm(6, rng)
    seen, _ = spoiled(SENSES[sense](truth, postures(40, truth, rng), rng), OUTLIERS, SIZE, rng)
    found = start_frames(forgotten(truth, unknown), unknown, [seen])
    for frame in unknown:
        shifted, turned = off(found, truth, frame)
        assert shifted < NEAR, frame
        # Nobody can see how a point is turned.
        assert turned < TURNED or (sense, frame) == ("points", "tool")
    assert np.median(lengths(seen.residual(found))) < 0.01


@pytest.mark.parametrize("seed", range(4))
def test_both_frames_are_found_when_half_of_the_poses_are_wrong(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = seen_arm(6, rng)
    seen = poses(truth, postures(40, truth, rng), rng)
    bad = rng.choice(40, 20, replace=False)
    pose = seen.pose.copy()
    pose[bad] = [random_pose(rng, 1.0) for _ in bad]
    found = start_frames(
        forgotten(truth, ("tracker", "tool")), ("tracker", "tool"), [replace(seen, observed=pose)]
    )
    for frame in ("tracker", "tool"):
        shifted, turned = off(found, truth, frame)
        assert shifted < NEAR, frame
        assert turned < TURNED, frame


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("sense", SENSES)
def test_a_long_recording_starts_where_all_of_it_would(
    sense: str, seed: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """45 % of 3000 rows are bad; some of the rows say what all of them say."""
    rng = np.random.default_rng(seed)
    truth = seen_arm(6, rng)
    seen, _ = spoiled(SENSES[sense](truth, postures(3000, truth, rng), rng), 0.45, SIZE, rng)
    blank = forgotten(truth, ("tracker", "tool"))
    some = start_frames(blank, ("tracker", "tool"), [seen])
    monkeypatch.setattr(starts, "spread", lambda sense: sense)
    every = start_frames(blank, ("tracker", "tool"), [seen])
    for found in (some, every):
        assert off(found, truth, "tracker")[0] < 2e-3
        assert off(found, truth, "tool")[0] < 2e-3


@pytest.mark.parametrize("seed", range(4))
def test_senses_that_share_a_frame_help_each_other(seed: int) -> None:
    """Three markers in one tracker, and a wrist camera that sees a board: five unknown frames."""
    rng = np.random.default_rng(seed)
    truth = seen_arm(6, rng).attach("camera", "tip", random_pose(rng, 0.1))
    truth = truth.attach("board", "base", random_pose(rng, 0.6))
    for k in range(2):
        truth = truth.attach(f"marker_{k}", "tip", random_pose(rng, 0.1))
    q = postures(40, truth, rng)
    senses: list[Sense] = [
        points(truth, q, rng, seen="marker_0"),
        points(truth, q, rng, seen="marker_1"),
        poses(truth, q, rng, seen_from="board", seen="camera"),
        poses(truth, q, rng, seen_from="tracker", seen="camera"),
    ]
    senses = [spoiled(sense, OUTLIERS, SIZE, rng)[0] for sense in senses]
    unknown = ("tracker", "board", "camera", "marker_0", "marker_1")
    found = start_frames(forgotten(truth, unknown), unknown, senses)
    for frame in unknown:
        shifted, turned = off(found, truth, frame)
        assert shifted < NEAR, frame
        assert turned < TURNED or frame.startswith("marker")


@pytest.mark.parametrize("seed", [23, 28, 31, 32])
def test_small_motions_of_a_far_point_do_not_end_in_a_wrong_place(seed: int) -> None:
    """Half a metre from its link and half a radian a joint: one first guess would not do."""
    rng = np.random.default_rng(seed)
    arm = Body.random_chain(6, rng).attach("tracker", "base", random_pose(rng, 1.0))
    truth = arm.attach("tool", "tip", random_pose(rng, 0.5))
    seen, _ = spoiled(points(truth, postures(40, truth, rng, 0.5), rng), OUTLIERS, SIZE, rng)
    found = start_frames(forgotten(truth, ("tracker", "tool")), ("tracker", "tool"), [seen])
    assert np.median(lengths(seen.residual(found))) < 0.003


def test_a_sense_that_settles_a_frame_comes_before_one_that_needs_it() -> None:
    """Two points cannot place tracker and marker; with the tracker known, they place the marker."""
    rng = np.random.default_rng(0)
    truth = seen_arm(6, rng).attach("marker", "tip", random_pose(rng, 0.1))
    q = postures(30, truth, rng)
    few, many = points(truth, q[:2], rng, seen="marker"), poses(truth, q, rng)
    unknown = ("tracker", "marker")
    found = start_frames(forgotten(truth, unknown), unknown, [few, many])
    assert max(off(found, truth, "tracker")) < NEAR
    assert off(found, truth, "marker")[0] < NEAR


@pytest.mark.parametrize("sense", SENSES)
def test_a_slightly_wrong_arm_still_gives_a_start(sense: str) -> None:
    """Joint offsets of 30 mrad are left to the fit; the start must not fail over them."""
    rng = np.random.default_rng(0)
    truth = seen_arm(6, rng)
    wrong = np.linspace(-0.03, 0.03, 6)
    seen = SENSES[sense](truth, postures(40, truth, rng) + wrong, rng)
    seen, _ = spoiled(seen, OUTLIERS, SIZE, rng)
    found = start_frames(forgotten(truth, ("tracker", "tool")), ("tracker", "tool"), [seen])
    assert off(found, truth, "tracker")[0] < 0.06
    assert off(found, truth, "tool")[0] < 0.06
    assert np.median(lengths(seen.residual(found))) < 0.03


def test_known_frames_stay_where_they_are() -> None:
    rng = np.random.default_rng(1)
    truth = seen_arm(5, rng)
    seen = poses(truth, postures(20, truth, rng), rng)
    found = start_frames(forgotten(truth, ["tool"]), ["tool"], [seen])
    assert off(found, truth, "tracker") == (0.0, pytest.approx(0.0, abs=1e-7))
    assert (start_frames(truth, (), [seen]).placement == truth.placement).all()


def test_a_frame_in_the_middle_of_the_chain_is_found() -> None:
    """The tracker sits on a moving link and looks at the tool."""
    rng = np.random.default_rng(2)
    arm = Body.random_chain(6, rng)
    truth = arm.attach("tracker", "link_2", random_pose(rng)).attach(
        "tool", "tip", random_pose(rng)
    )
    seen = poses(truth, postures(30, truth, rng), rng)
    found = start_frames(forgotten(truth, ("tracker", "tool")), ("tracker", "tool"), [seen])
    assert max(off(found, truth, "tracker") + off(found, truth, "tool")) < 0.01


def test_exact_samples_give_exact_frames() -> None:
    rng = np.random.default_rng(3)
    truth = seen_arm(6, rng)
    seen = poses(truth, postures(20, truth, rng), rng, (0.0, 0.0))
    found = start_frames(forgotten(truth, ("tracker", "tool")), ("tracker", "tool"), [seen])
    T = relative_pose(found, seen.q, "tracker", "tool")
    assert pytest.approx(seen.pose, abs=1e-9) == T


BOX = Inertia(0.6, np.array([0.016, -0.021, 0.092]), np.diag([3e-3, 2.4e-3, 1.6e-3]))


def felt(truth: Body, n: int, rng: np.random.Generator) -> WristWrenches:
    """Wrenches at rest on the tool, which carries the load, with the offset of sensor "ft"."""
    q = postures(n, truth, rng)
    sense = WristWrenches.make(q, np.zeros((n, 6)), "tool", "base", (1e-2, 1e-3), sensor="ft")
    return replace(sense, observed=sense.predict(truth))


def carrying(rng: np.random.Generator) -> tuple[Body, Body]:
    """An arm that carries a box on a sensor with an offset, and one that knows of neither."""
    bias = np.array([3.0, -2.0, 1.0, 0.1, 0.2, -0.1, *[0.0] * 6])
    ft = parts.force_sensor()
    nobody = seen_arm(5, rng).with_part("load", parts.load()).with_part("ft", ft)
    truth = nobody.with_part("load", parts.load(BOX)).with_part("ft", replace(ft, values=bias))
    return truth, nobody


@pytest.mark.parametrize("first", [True, False])
def test_parts_begin_where_the_samples_say_beside_frames(first: bool) -> None:
    """Poses place the tracker, wrenches tell the load and the offset, in either order."""
    rng = np.random.default_rng(0)
    truth, nobody = carrying(rng)
    seen: list[Sense] = [poses(truth, postures(30, truth, rng), rng), felt(truth, 30, rng)]
    unknown = ("tracker", "load", "ft")
    found = start_frames(forgotten(nobody, ["tracker"]), unknown, seen if first else seen[::-1])
    assert off(found, truth, "tracker") < (NEAR, TURNED)
    phi, true = parts.load_phi(found.part("load"))[0], BOX.phi
    assert phi[0] == pytest.approx(true[0], rel=0.02)
    assert phi[1:4] / phi[0] == pytest.approx(true[1:4] / true[0], abs=0.005)
    assert found.part("ft").values[:6] == pytest.approx(truth.part("ft").values[:6], abs=0.1)


def test_parts_that_nobody_asked_for_stay_as_they_are() -> None:
    rng = np.random.default_rng(0)
    truth, nobody = carrying(rng)
    found = start_frames(nobody, ("load",), [felt(truth, 30, rng)])
    assert found.part("load").values[0] != nobody.part("load").values[0]
    assert (found.part("ft").values == 0).all()


def test_a_part_that_nothing_can_begin_keeps_its_first_values() -> None:
    """Unlike a frame: a lens or a load has usual values, a place has none."""
    rng = np.random.default_rng(0)
    truth, nobody = carrying(rng)
    found = start_frames(
        forgotten(nobody, ["tool"]), ("tool", "load"), [poses(truth, postures(30, truth, rng), rng)]
    )
    assert off(found, truth, "tool") < (NEAR, TURNED)
    assert (found.part("load").values == nobody.part("load").values).all()


def test_an_unknown_frame_that_nothing_sees_is_refused() -> None:
    rng = np.random.default_rng(4)
    body = seen_arm(4, rng)
    seen = points(body, postures(10, body, rng), rng)
    with pytest.raises(InputError, match="frame tip is unknown, but no sense begins or ends in it"):
        start_frames(body, ["tool", "tip"], [seen])


class Unknown(Sense):
    """A kind that cannot say where its ends are."""

    measures = (("position", "m", 3),)


def test_a_sense_that_is_neither_points_nor_poses_is_refused() -> None:
    rng = np.random.default_rng(5)
    body = seen_arm(4, rng)
    seen = points(body, postures(3, body, rng), rng)
    batch = (seen.covariance, seen.rows, seen.observed)
    other = Unknown(seen.time, seen.q, "tracker", "tool", *batch)
    with pytest.raises(InputError, match="state roughly where it is"):
        start_frames(body, ["tool"], [other])


def test_a_turn_that_gravity_tells_is_no_place():
    # An accelerometer tells how the tool is turned, poses where it is; whoever comes first.
    rng = np.random.default_rng(8)
    truth = seen_arm(5, rng)
    q = postures(40, truth, rng)
    up = relative_pose(truth, q, "tool", "base")[:, :3, 2]
    felt = Gravity.make(q, G * up, "tool", "base")
    seen = poses(truth, q, rng)
    nominal = forgotten(truth, ("tracker", "tool"))
    for senses in ([felt, seen], [seen, felt]):
        found = start_frames(nominal, ("tracker", "tool"), senses)
        for frame in ("tracker", "tool"):
            distance, turn = off(found, truth, frame)
            assert distance < NEAR
            assert turn < TURNED
