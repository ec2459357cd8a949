"""Edits of a URDF: the patched file has the poses of the corrected body, and says nothing else."""

from __future__ import annotations

import difflib
import sysconfig
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.export.joint_edit import JointEdit
from bodyschema.export.urdf_edits import unwritable, urdf_edits
from bodyschema.export.urdf_patch import patch_urdf
from bodyschema.model.tree import Body
from bodyschema.model.urdf import parse_urdf
from bodyschema.model.variables import free_frame, free_joints, join

Difference = Callable[[Body, Body], float]
PATH = Path("robot.urdf")

EXAMPLES = Path(
    sysconfig.get_path("purelib"), "cmeel.prefix", "share", "example-robot-data", "robots"
)
REAL = [
    "panda_description/urdf/panda.urdf",
    "ur_description/urdf/ur5_robot.urdf",
    "icub_description/robots/icub.urdf",
    "talos_data/robots/talos_full_v2.urdf",
    "tiago_description/robots/tiago.urdf",
]


def read(source: bytes) -> Body:
    return parse_urdf(source, PATH, {})


def wrong_everywhere(body: Body, seed: int = 0) -> Body:
    """All offsets, axes and links off, and every fixed frame turned."""
    rng = np.random.default_rng(seed)
    variables = free_joints(body, ["offsets", "axes", "links"])
    x = rng.uniform(-1, 1, len(variables)) * np.where(variables.prior_std < 0.05, 0.05, 0.5)
    moved = body.with_variables(variables, x)
    fixed = [f for k, f in enumerate(body.frames) if k and body.kind[k] == 0]
    if not fixed:
        return moved
    frames = join(*(free_frame(body, frame) for frame in fixed))
    return moved.with_variables(frames, rng.uniform(-0.3, 0.3, len(frames)))


def changed_lines(before: bytes, after: bytes) -> list[bytes]:
    lines = difflib.ndiff(before.decode().split("\n"), after.decode().split("\n"))
    return [line[2:].strip().encode() for line in lines if line[0] == "+"]


def offset(body: Body, joint: str, value: float) -> Body:
    offsets = body.offset.copy()
    offsets[body.joint_index(joint)] = value
    return replace(body, offset=offsets)


# ---- poses -----------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_the_patched_file_has_the_poses_of_the_corrected_body(
    robot: bytes, worst_pose: Difference, seed: int
) -> None:
    nominal = read(robot)
    corrected = wrong_everywhere(nominal, seed)
    assert worst_pose(nominal, corrected) > 0.05
    patched = read(patch_urdf(robot, urdf_edits(nominal, corrected)))
    assert worst_pose(patched, corrected) < 1e-9


@pytest.mark.parametrize("name", REAL)
def test_real_robots(name: str, worst_pose: Difference) -> None:
    source = (EXAMPLES / name).read_bytes()
    nominal = read(source)
    corrected = wrong_everywhere(nominal).attach("camera", nominal.frames[-1])
    patched = patch_urdf(source, urdf_edits(nominal, corrected))
    assert worst_pose(read(patched), corrected) < 1e-9
    assert read(patched).joints == nominal.joints


def test_an_axis_tilt_turns_the_direction_of_the_offset(
    robot: bytes, worst_pose: Difference
) -> None:
    nominal = read(robot)
    axes = free_joints(nominal, ["axes"], ["shoulder"])
    corrected = offset(nominal.with_variables(axes, [0.2, -0.1]), "shoulder", 0.7)
    edits = urdf_edits(nominal, corrected)
    assert edits.keys() == {"shoulder"}
    assert edits["shoulder"].axis == pytest.approx(corrected.axis[2])
    assert worst_pose(read(patch_urdf(robot, edits)), corrected) < 1e-12


def test_gear_errors_are_named_and_left_out(robot: bytes, worst_pose: Difference) -> None:
    nominal = read(robot)
    corrected = replace(wrong_everywhere(nominal), gear=np.array([0.0, 0.01, 0.0, 0.0]))
    (sentence,) = unwritable(nominal, corrected)
    assert sentence.startswith("joint 'shoulder' moves 1.01 times as far as its encoder says")
    patched = read(patch_urdf(robot, urdf_edits(nominal, corrected)))
    assert worst_pose(patched, replace(corrected, gear=np.zeros(4))) < 1e-9
    assert unwritable(nominal, wrong_everywhere(nominal)) == []


# ---- what is written -------------------------------------------------------------------------


def test_nothing_differs_nothing_is_edited(robot: bytes) -> None:
    nominal = read(robot)
    assert urdf_edits(nominal, nominal) == {}
    barely = free_joints(nominal, ["links"], ["elbow"])
    assert urdf_edits(nominal, nominal.with_variables(barely, [1e-13, 0, 0])) == {}


def test_frames_that_were_attached_are_skipped(robot: bytes) -> None:
    nominal = read(robot)
    # "mount_joint" is also what the joint of a frame "mount" would be called.
    seen = nominal.attach("camera", "base").attach("shoulder", "camera")
    free = free_frame(seen, "camera")
    assert urdf_edits(nominal, seen.with_variables(free, np.ones(6))) == {}


def test_an_offset_changes_the_origin_only(robot: bytes) -> None:
    nominal = read(robot)
    edits = urdf_edits(nominal, offset(nominal, "shoulder", 0.25))
    assert edits.keys() == {"shoulder"}
    patched = patch_urdf(robot, edits)
    assert changed_lines(robot, patched) == [b'<origin xyz="0.1 0.2 0.3" rpy="0.35 -0.2 3.1"/>']
    assert np.array_equal(read(patched).lower, nominal.lower)


def test_limits_that_are_stops_move_with_the_zero(robot: bytes) -> None:
    nominal = read(robot)
    edits = urdf_edits(nominal, offset(nominal, "shoulder", 0.25), stops=True)
    assert edits["shoulder"].xyz is None
    assert edits["shoulder"].axis is None
    patched = patch_urdf(robot, edits)
    changed = changed_lines(robot, patched)
    assert len(changed) == 3
    assert b'<limit lower="-1.75" upper="1.25" effort="9" velocity="1"/>' in changed
    assert b'soft_lower_limit="-1.65" soft_upper_limit="1.15"/>' in changed[2]
    assert read(patched).lower[1] == -1.75


def test_the_offset_of_a_rail_shifts_its_origin_along_the_axis(robot: bytes) -> None:
    nominal = read(robot)
    edits = urdf_edits(nominal, offset(nominal, "rail", 0.02))
    # The rail's frame is pitched by 90 degrees and its axis is -z: it points along -x of the base.
    assert edits["rail"].xyz == pytest.approx((-0.02, 0.0, 0.5), abs=1e-15)
    assert edits["rail"].rpy is None
    stops = urdf_edits(nominal, offset(nominal, "rail", 0.02), stops=True)
    changed = changed_lines(robot, patch_urdf(robot, stops))
    assert b'<limit lower="-0.02" upper="1.48" effort="9" velocity="1"/>' in changed


def test_followers_move_with_their_leader_and_keep_their_mimic(robot: bytes) -> None:
    nominal = read(robot)
    moved = offset(nominal, "finger_l", 0.01)
    patched = patch_urdf(robot, urdf_edits(nominal, moved, stops=True))
    changed = changed_lines(robot, patched)
    assert b'<limit lower="-0.01" upper="0.03" effort="9" velocity="1"/>' in changed
    # finger_r runs at -2: its zero moves by -0.02. Its lower limit was URDF's default, 0.
    assert b'<limit upper="0.07" effort="9" velocity="1" lower="0.02"/>' in changed
    # wheel runs at 7 times -2: its zero moves by -0.14.
    assert b'<limit lower="-0.86" upper="2.14" effort="9" velocity="1"/>' in changed
    assert patched.count(b"<mimic") == 2
    assert all(b"<mimic" not in line for line in changed)
    assert np.array_equal(read(patched).shift, nominal.shift)


def test_the_limits_of_a_continuous_joint_mean_nothing_and_stay(robot: bytes) -> None:
    nominal = read(robot)
    patched = patch_urdf(robot, urdf_edits(nominal, offset(nominal, "elbow", 0.3), True))
    (line,) = changed_lines(robot, patched)
    assert line.startswith(b"<origin")


# ---- limits in the patch ---------------------------------------------------------------------


def patch(joint: bytes, shift: float) -> bytes:
    source = b"<robot name='r'>" + joint + b"</robot>"
    return patch_urdf(source, {"a": JointEdit(shift_limits=shift)})[16:-8]


@pytest.mark.parametrize(
    "joint",
    [
        b'<joint name="a" type="revolute"/>',
        b'<joint name="a" type="revolute"><limit effort="1" velocity="1"/></joint>',
        b'<joint name="a" type="revolute"><safety_controller k_velocity="1"/></joint>',
        b'<joint name="a" type="revolute"><limit lower="-inf" upper="inf"/></joint>',
        b'<joint name="a" type="continuous"><limit lower="1" upper="2"/></joint>',
    ],
)
def test_limits_that_are_not_stated_are_not_written(joint: bytes) -> None:
    assert patch(joint, 0.1) == joint


def test_a_soft_limit_alone_is_shifted() -> None:
    joint = b'<joint name="a"><safety_controller soft_lower_limit="%b" k_velocity="1"%b/></joint>'
    upper = b' soft_upper_limit="0.5"'
    assert patch(joint % (b"-1", b""), 0.5) == joint % (b"-0.5", upper)


def test_a_limit_that_is_no_number_is_refused() -> None:
    with pytest.raises(InputError, match="<limit lower> of joint 'a' is 'pi', expected a number"):
        patch(b'<joint name="a"><limit lower="pi" upper="4"/></joint>', 0.1)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"shift_limits": float("nan")}, "shift_limits needs a finite number"),
        ({"shift_limits": 0.1, "lower": 0.0}, "new limits or shift_limits, not both"),
    ],
)
def test_shifts_that_make_no_sense_are_refused(values: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        JointEdit(**values)  # type: ignore[arg-type]


# ---- two robots ------------------------------------------------------------------------------


def test_another_robot_is_refused(robot: bytes) -> None:
    nominal = read(robot)
    with pytest.raises(InputError, match="no frame 'fore' on other"):
        urdf_edits(nominal, read(robot.replace(b"fore", b"arm").replace(b"railarm", b"other")))
    rehung = replace(nominal, carriers=(*nominal.carriers[:-1], "sprocket"))
    with pytest.raises(InputError, match="hangs on joint 'wheel' in railarm and on 'sprocket'"):
        urdf_edits(nominal, rehung)
