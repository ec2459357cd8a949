"""Parts: vectors of named numbers on a body, free or fixed, and the bodies that deviate in them."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.model import parts
from bodyschema.model.camera import Camera
from bodyschema.model.inertia import Inertia, is_physical, log_cholesky
from bodyschema.model.kernels import PART
from bodyschema.model.parts import Part
from bodyschema.model.tree import Body
from bodyschema.model.variables import free_joints, free_part, join
from bodyschema.senses.points import Points
from simulated import seen_arm

BOX = Inertia(0.6, np.array([0.016, -0.021, 0.092]), np.diag([3e-3, 2.4e-3, 1.6e-3]))
MATRIX = np.array([[610.0, 0, 319.5], [0, 605.0, 239.5], [0, 0, 1]])


def body() -> Body:
    """Three joints, a lens, a load and a clock."""
    arm = seen_arm(3, np.random.default_rng(0))
    arm = arm.with_part("eye", parts.lens(Camera("eye", "tool", 640, 480, MATRIX)))
    return arm.with_part("box", parts.load(BOX)).with_part("late", parts.clock(0.02))


MADE = {
    "load": parts.load(),
    "force": parts.force_sensor(),
    "accelerometer": parts.accelerometer(),
    "drive": parts.drive(["lift", "bend"]),
    "clock": parts.clock(),
    "target": parts.target(),
    "edge": parts.edge(),
    "skin": parts.skin(3),
    "constants": parts.constants({"zero": 0.1}, {"zero": "m"}, {"zero": 0.05}),
    "lens": parts.lens(Camera("eye", "tool", 640, 480, MATRIX)),
}


@pytest.mark.parametrize("kind", MADE)
def test_each_number_has_a_name_a_unit_and_a_prior(kind: str) -> None:
    part = MADE[kind]
    k = len(part.names)
    assert k == len(set(part.names)) == len(part.units)
    assert part.values.shape == part.prior_std.shape == (k,)
    assert part.values.dtype == part.prior_std.dtype == np.float64
    assert (part.prior_std > 0).all()
    assert [part[name] for name in part.names] == part.values.tolist()


def test_numbers_begin_as_they_are_said_to() -> None:
    assert MADE["target"]["scale"] == 1.0
    assert parts.clock(0.03)["lag"] == 0.03
    assert MADE["drive"].names[:2] == ("inertia_lift", "viscous_lift")
    assert MADE["drive"].units[5:7] == ("kg m^2", "Nms")
    assert MADE["force"].prior_std[[0, 3, 6]].tolist() == [50.0, 5.0, parts.GAIN_PRIOR]
    assert MADE["constants"].units == ("m",)


def test_a_lens_is_that_of_its_camera() -> None:
    camera = Camera("eye", "tool", 640, 480, MATRIX, np.array([0.1, -0.2, 1e-3, 2e-3, 0.05]))
    part = parts.lens(camera)
    assert part.values.tolist() == [610, 605, 319.5, 239.5, 0.1, -0.2, 1e-3, 2e-3, 0.05]
    assert part.prior_std[0] == pytest.approx(0.02 * 610)
    longer = np.array([0.1, 0, 0, 0, 0, 0.3, 0, 0, 0, 0, 0, 0])
    part = parts.lens(Camera("eye", "tool", 640, 480, MATRIX, longer[:8]))
    assert (len(part.values), part["k4"]) == (12, 0.3)
    fisheye = parts.lens(Camera("eye", "tool", 640, 480, MATRIX, longer[:4], fisheye=True))
    assert fisheye.names[4:] == ("k1", "k2", "k3", "k4")
    longer[8] = 0.01
    with pytest.raises(InputError, match="camera 'eye' has 12 distortion coefficients"):
        parts.lens(Camera("eye", "tool", 640, 480, MATRIX, longer))
    with pytest.raises(InputError, match="of a fisheye 0 or 4"):
        Camera("eye", "tool", 640, 480, MATRIX, longer[:5], fisheye=True)


def test_a_load_is_physical_wherever_its_roots_go() -> None:
    part = parts.load(BOX)
    assert part.values == pytest.approx(log_cholesky(BOX.phi))
    assert parts.load_phi(part)[0] == pytest.approx(BOX.phi)
    rng = np.random.default_rng(0)
    for _ in range(50):
        moved = part.moved(np.arange(10), rng.normal(size=10) * part.prior_std)
        assert is_physical(parts.load_phi(moved)[0])


def test_numbers_move_alone() -> None:
    part = parts.skin(4)
    moved = part.moved(np.array([2, 0]), np.array([0.5, -1.0]))
    assert moved.values.tolist() == [-1.0, 0.0, 0.5, 0.0]
    assert (part.values == 0).all()


@pytest.mark.parametrize(
    ("names", "values", "std"),
    [(("a", "b"), [1.0], [1.0]), (("a",), [np.nan], [1.0]), (("a",), [1.0], [1.0, 2.0])],
)
def test_half_a_part_is_refused(names: tuple[str, ...], values: object, std: object) -> None:
    with pytest.raises(InputError, match="a part of kind 'constants' needs as many finite"):
        Part("constants", names, ("m",), np.array(values), np.array(std))


def test_a_number_that_is_not_there_is_named() -> None:
    with pytest.raises(InputError, match=r"no 'lagg' in a clock; did you mean 'lag'\?"):
        parts.clock()["lagg"]
    with pytest.raises(InputError, match=r"no part 'eyes' on .*; did you mean 'eye'\?"):
        body().part("eyes")
    with pytest.raises(InputError, match="has a frame 'tool'; give the clock another name"):
        body().with_part("tool", parts.clock())


def test_numbers_of_a_part_are_freed_by_name() -> None:
    arm = body()
    free = free_part(arm, "eye", ["cx", "fx"], {"cx": 3.0})
    assert free.names == ("eye.cx", "eye.fx")
    assert free.groups == ("lens:eye", "lens:eye")
    assert free.units == ("px", "px")
    assert (free.code == PART).all()
    assert free.component.tolist() == [2, 0]
    assert free.prior_std == pytest.approx([3.0, 12.2])
    assert np.isinf(free.bound).all()
    assert len(free_part(arm, "box")) == 10
    for part, names, text in (
        ("bxo", None, "no part 'bxo'.*did you mean 'box'"),
        ("box", ["alfa"], "no 'alfa' in box.*did you mean 'alpha'"),
    ):
        with pytest.raises(InputError, match=text):
            free_part(arm, part, names)
    with pytest.raises(InputError, match="no 'laag' in late"):
        free_part(arm, "late", prior_std={"laag": 1.0})


def test_variables_know_the_columns_of_each_part() -> None:
    arm = body()
    box = free_part(arm, "box", ["t2", "alpha"])
    free = join(box, free_joints(arm, ["offsets"]), free_part(arm, "late"))
    columns, numbers = free.of_part("box")
    assert (columns.tolist(), numbers.tolist()) == ([0, 1], [8, 0])
    assert [a.tolist() for a in free.of_part("late")] == [[5], [0]]
    assert [len(a) for a in free.of_part("eye")] == [0, 0]
    assert free.has_parts
    assert not free_joints(arm).has_parts
    assert free.where(["load:box"]).of_part("box")[0].tolist() == [0, 1]


def test_a_body_deviates_in_what_is_free_alone() -> None:
    arm = body()
    free = join(
        free_part(arm, "late"), free_joints(arm, ["offsets"]), free_part(arm, "box", ["t2"])
    )
    x = np.array([0.005, 0.1, 0.2, 0.3, -0.04])
    there, slope = arm.deviate(free, x)
    assert slope.shape == (5, 3)
    assert there.part("late")["lag"] == pytest.approx(0.025)
    assert there.offset == pytest.approx([0.1, 0.2, 0.3])
    moved = there.part("box").values - arm.part("box").values
    assert moved == pytest.approx([0, 0, 0, 0, 0, 0, 0, 0, -0.04, 0])
    assert (
        there.part("eye") is arm.part("eye")
        or (there.part("eye").values == arm.part("eye").values).all()
    )
    assert arm.part("late")["lag"] == 0.02
    with pytest.raises(InputError, match="expected 5 parameters, got an array"):
        arm.with_variables(free, x[:4])


def test_a_late_stream_is_read_at_earlier_joints() -> None:
    """q - lag dq/dt, and the derivative by the lag is that of the motion."""
    arm = body()
    rng = np.random.default_rng(3)
    q, rate = rng.normal(size=(2, 6, 3))
    seen = Points.make(q, np.zeros((6, 3)), "tracker", "tool", clock="late", rate=rate)
    assert seen.readings(arm) == pytest.approx(q - 0.02 * rate)
    assert Points.make(q, np.zeros((6, 3)), "tracker", "tool").readings(arm) == pytest.approx(q)
    free, h = free_part(arm, "late"), 1e-6
    ends = [seen.residual(arm.with_variables(free, np.array([s * h]))) for s in (1, -1)]
    slope = seen.linearize(arm, free, np.zeros(1)).by_parameter[:, :, 0]
    assert np.abs(slope).max() > 0.01
    assert slope == pytest.approx((ends[0] - ends[1]) / (2 * h), abs=1e-6)
