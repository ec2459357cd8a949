"""Poses between any two frames, and their derivatives by every kind of parameter."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.kernels import (
    AXIS,
    FIXED,
    GEAR,
    LINK,
    OFFSET,
    PART,
    PRISMATIC,
    REVOLUTE,
    TURN,
)
from bodyschema.model.kinematics import (
    frame_jacobian,
    frame_poses,
    path_between,
    relative_pose,
    relative_pose_derivatives,
)
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, join

Array = NDArray[np.float64]

properties = settings(derandomize=True, deadline=None, database=None, max_examples=40)

TREE = {  # frame: (parent, kind)
    "base": ("", FIXED),
    "torso": ("base", REVOLUTE),
    "neck": ("torso", REVOLUTE),
    "camera": ("neck", FIXED),
    "lift": ("torso", PRISMATIC),
    "shoulder": ("lift", REVOLUTE),
    "elbow": ("shoulder", REVOLUTE),
    "finger": ("elbow", REVOLUTE),
    "fingertip": ("finger", REVOLUTE),
    "jaw": ("fingertip", PRISMATIC),
    "tool": ("jaw", FIXED),
}
MIMICS = {"fingertip_joint": ("finger_joint", -0.7, 0.2), "jaw_joint": ("lift_joint", 1.5, -0.1)}

PATHS = [
    ("base", "tool"),
    ("tool", "base"),
    ("camera", "tool"),
    ("tool", "camera"),
    ("fingertip", "neck"),
    ("lift", "elbow"),
    ("elbow", "elbow"),
]
"""Down, up, over a branch both ways, within a branch, and nowhere."""

KINDS = {"offset": OFFSET, "gear": GEAR, "axis": AXIS, "link": LINK, "turn": TURN}


@pytest.fixture(scope="module")
def body() -> Body:
    """A branching body with revolute, prismatic, fixed and mimicking joints."""
    rng = np.random.default_rng(7)
    frames, n = list(TREE), len(TREE)
    axis = rng.normal(size=(n, 3))
    return Body.build(
        name="tree",
        frames=frames,
        carriers=["", *(f"{frame}_joint" for frame in frames[1:])],
        parent=[frames.index(parent) if parent else -1 for parent, _ in TREE.values()],
        kind=[kind for _, kind in TREE.values()],
        axis=axis / np.linalg.norm(axis, axis=1, keepdims=True),
        placement=lie.transform(
            lie.exp_so3(rng.normal(size=(n, 3))), rng.uniform(-0.4, 0.4, size=(n, 3))
        ),
        mimics=MIMICS,
    )


@pytest.fixture(scope="module")
def variables(body: Body) -> Variables:
    return join(free_joints(body), free_frame(body, "camera"), free_frame(body, "tool"))


def deviation(variables: Variables, size: float) -> Array:
    """Angles up to `size`, gears up to a quarter of it, everything else up to a third."""
    scale = np.where(variables.code == GEAR, 0.25, 1.0) * np.where(variables.code == LINK, 0.3, 1)
    return np.random.default_rng(3).uniform(-size, size, len(variables)) * scale


def posture(body: Body) -> Array:
    return np.random.default_rng(4).uniform(-1.5, 1.5, len(body.joints))


def twist_differences(pose: Callable[[Array], Array], at: Array, step: float = 1e-5) -> Array:
    """Central differences (6, n): motion of the origin of b, and turn, both in frame a."""
    R = pose(at)[:3, :3]
    columns = []
    for i in range(len(at)):
        d = step * (np.arange(len(at)) == i)
        forth, back = pose(at + d), pose(at - d)
        turn = lie.log_so3(forth[:3, :3] @ R.T) - lie.log_so3(back[:3, :3] @ R.T)
        columns.append(np.concatenate([forth[:3, 3] - back[:3, 3], turn]) / (2 * step))
    return np.stack(columns, axis=-1)


@pytest.mark.parametrize("size", [0.0, 0.05, 1.0], ids=["at-zero", "near", "far"])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("a", "b"), PATHS)
def test_derivatives_by_parameter(
    body: Body, variables: Variables, a: str, b: str, kind: str, size: float
) -> None:
    x, q = deviation(variables, size), posture(body)
    D = relative_pose_derivatives(body, variables, x, q, a, b)
    rows = np.flatnonzero(variables.code == KINDS[kind])
    assert len(rows)

    def pose(some: Array) -> Array:
        moved = x.copy()
        moved[rows] = some
        return relative_pose(body.with_variables(variables, moved), q, a, b)

    differences = twist_differences(pose, x[rows])
    assert np.abs(D.by_parameter[:, rows] - differences).max() < 1e-8
    assert np.abs(D.pose - pose(x[rows])).max() < 1e-14
    if a != b and size and (kind != "turn" or "camera" in (a, b) or "tool" in (a, b)):
        assert np.abs(differences).max() > 0.01


@pytest.mark.parametrize(("a", "b"), PATHS)
def test_derivatives_by_joint_with_gears(body: Body, variables: Variables, a: str, b: str) -> None:
    x, q = deviation(variables, 1.0), posture(body)
    worn = body.with_variables(variables, x)
    assert np.abs(worn.gear).min() > 0.01
    differences = twist_differences(lambda some: relative_pose(worn, some, a, b), q)
    D = relative_pose_derivatives(body, variables, x, q, a, b)
    assert np.abs(D.by_joint - differences).max() < 1e-8
    assert np.abs(frame_jacobian(worn, q, a, b) - differences).max() < 1e-8


@pytest.mark.parametrize("tilt", [0.0, 1e-9, 9.99e-4, 1.001e-3, 0.1, 1.5])
def test_the_chart_is_smooth_where_its_series_begins(body: Body, tilt: float) -> None:
    variables = join(free_joints(body, ["axes"]), free_frame(body, "tool"))
    x, q = np.full(len(variables), tilt / np.sqrt(3)), posture(body)

    def pose(some: Array) -> Array:
        return relative_pose(body.with_variables(variables, some), q, "camera", "tool")

    D = relative_pose_derivatives(body, variables, x, q, "camera", "tool")
    assert np.abs(D.by_parameter - twist_differences(pose, x)).max() < 1e-8


def test_what_is_not_on_the_path_does_not_matter(body: Body, variables: Variables) -> None:
    D = relative_pose_derivatives(
        body, variables, deviation(variables, 1.0), posture(body), "torso", "camera"
    )
    on_path = [name.split(".")[0] in ("neck_joint", "camera") for name in variables.names]
    assert (D.by_parameter[:, np.logical_not(on_path)] == 0).all()
    assert (np.abs(D.by_parameter[:, on_path]).max(axis=0) > 0).all()


def test_parts_move_no_frame(body: Body, variables: Variables) -> None:
    x, q = deviation(variables, 0.5), posture(body)
    with_parts = join(
        variables,
        replace(free_frame(body.attach("eye", "neck"), "eye"), code=np.arange(PART, PART + 6)),
    )
    longer = np.append(x, np.arange(6.0))
    D = relative_pose_derivatives(body, variables, x, q, "camera", "tool")
    E = relative_pose_derivatives(body, with_parts, longer, q, "camera", "tool")
    assert (E.pose == D.pose).all()
    assert (E.by_parameter[:, : len(variables)] == D.by_parameter).all()
    assert (E.by_parameter[:, len(variables) :] == 0).all()
    assert (
        body.with_variables(with_parts, longer).placement
        == body.with_variables(variables, x).placement
    ).all()


def test_batches_equal_singles(body: Body, variables: Variables) -> None:
    x = deviation(variables, 0.5)
    q = np.random.default_rng(5).normal(size=(2, 3, len(body.joints)))
    worn = body.with_variables(variables, x)
    D = relative_pose_derivatives(body, variables, x, q, "camera", "tool")
    assert D.pose.shape == (2, 3, 4, 4)
    assert D.by_joint.shape == (2, 3, 6, len(body.joints))
    assert D.by_parameter.shape == (2, 3, 6, len(variables))
    for i in np.ndindex(2, 3):
        single = relative_pose_derivatives(body, variables, x, q[i], "camera", "tool")
        assert (D.pose[i] == single.pose).all()
        assert (D.by_joint[i] == single.by_joint).all()
        assert (D.by_parameter[i] == single.by_parameter).all()
        assert (frame_poses(worn, q)[i] == frame_poses(worn, q[i])).all()
        assert (
            relative_pose(worn, q, "tool", "neck")[i] == relative_pose(worn, q[i], "tool", "neck")
        ).all()
    assert frame_poses(worn, np.empty((0, len(body.joints)))).shape == (0, len(body.frames), 4, 4)


def test_a_reversed_path_is_the_inverse_and_paths_chain(body: Body) -> None:
    q = posture(body)
    poses = frame_poses(body, q)
    for i, a in enumerate(body.frames):
        for j, b in enumerate(body.frames):
            T_a_b = relative_pose(body, q, a, b)
            assert np.abs(T_a_b - lie.inverse(poses[i]) @ poses[j]).max() < 1e-14
            assert np.abs(T_a_b @ relative_pose(body, q, b, a) - np.eye(4)).max() < 1e-14


def test_path_between_leaves_out_the_meeting_node(body: Body) -> None:
    path, climbed = path_between(body, "camera", "lift")
    assert [body.frames[k] for k in path] == ["camera", "neck", "lift"]
    assert climbed == 2
    assert len(path_between(body, "neck", "neck")[0]) == 0


def test_mimicking_joints_follow(body: Body) -> None:
    q = posture(body)
    ratio, shift = MIMICS["fingertip_joint"][1:]
    angle = ratio * q[body.joint_index("finger_joint")] + shift
    k = body.frame_index("fingertip")
    motion = lie.transform(lie.exp_so3(angle * body.axis[k]), np.zeros(3))
    expected = body.placement[k] @ motion
    assert np.abs(relative_pose(body, q, "finger", "fingertip") - expected).max() < 1e-15


@properties
@given(st.integers(0, 2**32 - 1), st.integers(1, 8), st.floats(-3, 3))
def test_an_offset_is_a_turned_placement(seed: int, n: int, offset: float) -> None:
    """Baking: what an exporter may write into the <origin> of a joint."""
    rng = np.random.default_rng(seed)
    arm, j, q = Body.random_chain(n, rng), int(rng.integers(n)), rng.normal(size=n)
    variables = free_joints(arm, ["offsets"], [arm.joints[j]])
    k = j + 1
    turned = arm.placement[k] @ lie.transform(lie.exp_so3(offset * arm.axis[k]), np.zeros(3))
    baked = arm.with_placement(arm.frames[k], turned)
    worn = arm.with_variables(variables, [offset])
    assert np.abs(frame_poses(baked, q) - frame_poses(worn, q)).max() < 1e-14


def test_baking_shifts_prismatic_and_mimicking_joints(body: Body) -> None:
    q, offset = posture(body), 0.3
    worn = body.with_variables(free_joints(body, ["offsets"], ["lift_joint"]), [offset])
    baked = body
    for frame, rate in (("lift", 1.0), ("jaw", MIMICS["jaw_joint"][1])):
        k = body.frame_index(frame)
        along = lie.transform(np.eye(3), rate * offset * body.axis[k])
        baked = baked.with_placement(frame, body.placement[k] @ along)
    assert np.abs(frame_poses(baked, q) - frame_poses(worn, q)).max() < 1e-14


def test_wrong_joint_positions_are_refused(body: Body) -> None:
    with pytest.raises(
        InputError, match=r"6 columns \(torso_joint, .*got an array of shape \(4,\)"
    ):
        frame_poses(body, np.zeros(4))
    with pytest.raises(InputError, match=r"no frame 'elbov'.*did you mean 'elbow'"):
        relative_pose(body, np.zeros(6), "elbov", "tool")
