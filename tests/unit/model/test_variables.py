"""The list of what may be wrong: names, groups, selection, refusals, and the chart's manifold."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.dh import DHRow, body_from_dh
from bodyschema.model.kernels import AXIS, GEAR, LINK, OFFSET, TURN
from bodyschema.model.tree import Body
from bodyschema.model.variables import GROUPS, Variables, free_frame, free_joints, join

properties = settings(derandomize=True, deadline=None, database=None, max_examples=60)


@pytest.fixture(scope="module")
def body() -> Body:
    """A revolute and a prismatic joint, a fixed flange, and a camera on the base."""
    rows = [DHRow("swing", a=0.3, alpha=0.2), DHRow("slide", d=0.1, type="prismatic")]
    return body_from_dh(rows, name="crane").attach("camera", "base")


def test_names_units_and_groups_of_everything(body: Body) -> None:
    variables = join(free_joints(body), free_frame(body, "camera"))
    assert variables.names == (
        "swing.offset", "swing.gear", "swing.axis_1", "swing.axis_2",
        "swing.link_x", "swing.link_y", "swing.link_z",
        "slide.offset", "slide.gear", "slide.axis_1", "slide.axis_2",
        "slide.link_x", "slide.link_y", "slide.link_z",
        "camera.link_x", "camera.link_y", "camera.link_z",
        "camera.turn_x", "camera.turn_y", "camera.turn_z",
    )  # fmt: skip
    joint = ("rad", "1", "rad", "rad", "m", "m", "m")
    assert variables.units == (*joint, "m", *joint[1:], *["m"] * 3, *["rad"] * 3)
    assert set(variables.groups) == {*GROUPS, "frame:camera"}
    codes = [OFFSET, GEAR, AXIS, AXIS, LINK, LINK, LINK] * 2 + [LINK] * 3 + [TURN] * 3
    assert variables.code.tolist() == codes
    assert (variables.prior_std > 0).all()
    assert (variables.bound > variables.prior_std).all()


def test_choosing_groups_joints_and_rows(body: Body) -> None:
    assert free_joints(body, ["gears"]).names == ("swing.gear", "slide.gear")
    assert free_joints(body, ["offsets"], ["slide"]).names == ("slide.offset",)
    both = join(free_joints(body), free_frame(body, "flange", turn_std=None))
    chosen = both.where(["frame:flange", "offsets"])
    assert chosen.names == (
        "swing.offset", "slide.offset", "flange.link_x", "flange.link_y", "flange.link_z",
    )  # fmt: skip
    taken = both.take([3, 0])
    assert taken.names == ("swing.axis_2", "swing.offset")
    for field in ("code", "index", "component", "prior_std", "bound"):
        assert getattr(taken, field).tolist() == getattr(both, field)[[3, 0]].tolist()
    assert len(both.take([])) == 0


def test_priors_can_be_replaced(body: Body) -> None:
    variables = free_frame(body, "camera", position_std=0.2, turn_std=0.3)
    assert variables.prior_std.tolist() == [0.2] * 3 + [0.3] * 3
    assert variables.with_prior(np.arange(6.0)).prior_std.tolist() == [0, 1, 2, 3, 4, 5]
    assert variables.prior_std.tolist() == [0.2] * 3 + [0.3] * 3


def test_a_mimicking_joint_shares_offset_and_gear_but_has_its_own_geometry() -> None:
    hand = Body.build(
        name="hand",
        frames=["palm", "finger", "tip"],
        carriers=["", "finger_joint", "tip_joint"],
        parent=[-1, 0, 1],
        kind=[0, 1, 1],
        axis=np.tile([0.0, 0.0, 1.0], (3, 1)),
        placement=np.tile(np.eye(4), (3, 1, 1)),
        mimics={"tip_joint": ("finger_joint", 0.5, 0.0)},
    )
    names = free_joints(hand, ["offsets", "gears", "axes"]).names
    assert names == (
        "finger_joint.offset", "finger_joint.gear",
        "finger_joint.axis_1", "finger_joint.axis_2", "tip_joint.axis_1", "tip_joint.axis_2",
    )  # fmt: skip


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda b: free_joints(b, ["ofsets"]), "no parameter group 'ofsets'; did you mean 'offs"),
        (lambda b: free_joints(b, joints=["swin"]), "no joint 'swin' on crane; did you mean 'swin"),
        (lambda b: free_frame(b, "camra"), "no frame 'camra' on crane; did you mean 'camera'"),
        (lambda b: free_frame(b, "base"), "'base' cannot be freed as a whole: it is the root"),
        (lambda b: free_frame(b, "link_1"), "'link_1' cannot .* moving joint; free that joint"),
        (
            lambda b: join(free_joints(b, ["gears"]), free_joints(b)),
            r"'slide.gear' is freed twice; free it once",
        ),
        (lambda b: b.with_variables(free_joints(b), [0.0]), r"expected 14 .*an array \(1,\)"),
    ],
)
def test_refusals_name_the_alternatives(body: Body, call: object, message: str) -> None:
    assert callable(call)
    with pytest.raises(InputError, match=message):
        call(body)


@pytest.fixture(scope="module")
def arm() -> tuple[Body, Variables]:
    arm = Body.random_chain(4, np.random.default_rng(0)).attach("camera", "base")
    return arm, join(free_joints(arm), free_frame(arm, "camera"), free_frame(arm, "tip"))


@properties
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1e-12, 1e-4, 1e-2, 1.0, 2.2]))
def test_axes_stay_unit_and_rotations_orthonormal(
    arm: tuple[Body, Variables], seed: int, size: float
) -> None:
    body, variables = arm
    x = np.random.default_rng(seed).uniform(-size, size, len(variables))
    worn = body.with_variables(variables, x)
    assert np.abs(np.linalg.norm(worn.axis, axis=1) - 1).max() < 1e-15
    R = worn.placement[:, :3, :3]
    assert np.abs(R @ np.swapaxes(R, 1, 2) - np.eye(3)).max() < 5e-15
    assert np.linalg.det(R) == pytest.approx(1.0, abs=5e-15)


@properties
@given(st.floats(0, np.pi / 2), st.floats(-np.pi, np.pi))
def test_an_axis_tilts_by_the_length_of_its_parameters(tilt: float, around: float) -> None:
    body = Body.random_chain(1, np.random.default_rng(1))
    axes = free_joints(body, ["axes"])
    moved = body.with_variables(axes, tilt * np.array([np.cos(around), np.sin(around)])).axis[1]
    angle = np.arctan2(np.linalg.norm(np.cross(body.axis[1], moved)), body.axis[1] @ moved)
    assert angle == pytest.approx(tilt, abs=1e-14)


def test_each_kind_moves_what_its_name_says(body: Body) -> None:
    variables = join(free_joints(body), free_frame(body, "camera"))
    x = dict.fromkeys(variables.names, 0.0)
    x |= {"swing.offset": 0.1, "slide.gear": 0.2, "slide.link_y": 0.3}
    x |= {"camera.link_z": 0.4, "camera.turn_x": 0.5}
    worn = body.with_variables(variables, list(x.values()))
    assert worn.offset.tolist() == [0.1, 0.0]
    assert worn.gear.tolist() == [0.0, 0.2]
    slide, camera = body.frame_index("link_2"), body.frame_index("camera")
    assert (worn.placement - body.placement)[slide, :3, 3] == pytest.approx([0, 0.3, 0])
    assert worn.placement[camera, :3, 3].tolist() == [0, 0, 0.4]
    assert worn.placement[camera, :3, :3] == pytest.approx(lie.exp_so3([0.5, 0, 0]), abs=1e-15)
    assert (worn.axis == body.axis).all()
    assert (body.offset == 0).all(), "the reference must not change"
