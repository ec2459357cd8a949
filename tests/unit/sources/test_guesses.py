"""What columns may be, by their names and ranges."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.sources.contents import Stream
from bodyschema.sources.guesses import angle_unit, groups_of, joints_of, plain
from bodyschema.sources.recording import Recording


def stream(*names: str, size: float = 1.0, kind: str = "table") -> Stream:
    columns = {name: size * np.array([-1.0, 1.0]) for name in names}
    return Stream("a.csv", kind, 2, recording=Recording("a", columns, {}))


@pytest.mark.parametrize(
    ("names", "kind", "layout", "name"),
    [
        ("x y z qx qy qz qw", "poses", "xyz_xyzw", ""),
        ("b.x b.y b.z b.qx b.qy b.qz b.qw", "poses", "xyz_xyzw", "b"),
        ("X Y Z A B C", "poses", "xyz_rpy", ""),
        ("tag_tx tag_ty tag_tz tag_rx tag_ry tag_rz", "poses", "xyz_rotvec", "tag"),
        (" ".join(f"T_{i}{j}" for i in range(3) for j in range(4)), "poses", "matrix3x4", "T"),
        (" ".join(f"T1_{i}{j}" for i in range(4) for j in range(4)), "poses", "matrix4x4", "T1"),
        ("fx fy fz tx ty tz", "wrenches", "", ""),
        ("u v", "pixels", "", ""),
        ("x1 y1 z1", "points", "", ""),
        ("tip_x tip_y tip_z", "points", "", "tip"),
    ],
)
def test_columns_that_belong_together(names: str, kind: str, layout: str, name: str) -> None:
    (found,) = groups_of(stream(*names.split(), "max", "elbow"))
    assert (found.kind, found.layout, found.name) == (kind, layout, name)
    assert {*found.columns} == {*names.split()}


def test_kuka_angles_turn_in_the_order_of_rpy() -> None:
    (found,) = groups_of(stream(*"XYZABC", size=100.0))
    assert found.columns == ("X", "Y", "Z", "C", "B", "A")
    assert (found.unit, found.angle_unit) == ("mm", "deg")


@pytest.mark.parametrize(
    ("size", "name", "unit"),
    [
        (3.1, "a", "rad"), (90.0, "a", "deg"), (100.0, "a", "percent"), (2100.0, "a", "ticks"),
        (3.1, "a_deg", "deg"), (80.0, "motor_rad_0", "rad"),
    ],
)  # fmt: skip
def test_units_of_joints(size: float, name: str, unit: str) -> None:
    assert angle_unit({name: np.array([-1.0, size, np.nan])}, [name]) == unit


def test_joints_by_their_names() -> None:
    recorded = stream("elbow.pos", "q_wrist", "Base_deg", "x", "y", "z")
    assert joints_of(recorded, ("base", "elbow", "wrist")) == {
        "base": "Base_deg", "elbow": "elbow.pos", "wrist": "q_wrist",
    }  # fmt: skip
    assert joints_of(stream("q1", "q2", "x", "y", "z")) == {"q1": "q1", "q2": "q2"}
    assert joints_of(stream("q1", "q2"), ("s", "t")) == {"s": "q1", "t": "q2"}, "by order"
    assert joints_of(stream("q1", "q2", "q3"), ("s", "t")) == {}
    states = stream("pan", "d_pan", "effort_pan", kind="sensor_msgs/msg/JointState")
    assert joints_of(states) == {"pan": "pan"}
    assert plain("joint_states.elbow.position") == "elbow"
