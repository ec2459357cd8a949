"""The section [joints]: units, signs, scales and zeros of single joints."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bodyschema.cli.reading.joint_columns import JointColumns, joint_columns
from bodyschema.cli.reading.joints import conversion, cut_off, read_joints
from bodyschema.errors import InputError
from bodyschema.export.documents import plain
from bodyschema.model.kernels import PRISMATIC
from bodyschema.model.tree import Body
from bodyschema.sources.recording import Recording

WHERE = "[joints] of 'run.toml'"


@pytest.fixture
def body() -> Body:
    """Two turning joints with limits, one without, and a sliding one."""
    made = Body.random_chain(4, np.random.default_rng(1))
    kind = made.kind.copy()
    kind[4] = PRISMATIC
    lower, upper = np.array([-1.0, 0.0, -np.inf, 0.0]), np.array([3.0, 2.0, np.inf, 0.4])
    return replace(made, kind=kind, lower=lower, upper=upper)


def read(body: Body, table: dict[str, Any], pattern: str = "{joint}", **columns: Any) -> Any:
    arrays = {name: np.asarray(values, dtype=float) for name, values in columns.items()}
    recording = Recording("'data.csv'", arrays, {})
    return read_joints(body, recording, joint_columns(table, WHERE), pattern)


def test_percent_of_the_limits(body: Body) -> None:
    """-100 at the lower, 100 at the upper; of sliding joints as well."""
    for unit in ("percent", "%"):
        q = read(body, {"unit": unit}, joint_1=[-100, 0, 100], joint_4=[-100, 50, 100])
        assert q[:, 0] == pytest.approx([-1, 1, 3])
        assert q[:, 3] == pytest.approx([0, 0.3, 0.4])


def test_percent_needs_limits(body: Body) -> None:
    with pytest.raises(InputError, match=r"has none for it; .* under \[joints\.joint_3\]"):
        read(body, {"unit": "percent"}, joint_3=[0, 1])


def test_counts_of_a_motor_that_turns_the_other_way(body: Body) -> None:
    wrist = {"column": "m5", "sign": -1, "scale": 0.1, "zero": 2048, "unit": "deg"}
    q = read(body, {"unit": "percent", "joint_2": wrist}, m5=[2048, 2148], joint_1=[0, 0])
    assert np.rad2deg(q[:, 1]) == pytest.approx([0, -10])
    assert q[:, 0].tolist() == [1, 1], "others keep the unit of the section"
    rates = read(body, {"joint_2": wrist}, "d_{joint}", d_m5=[100, 0])
    assert np.rad2deg(rates[:, 1]) == pytest.approx([-10, 0]), "rates have no zero"
    rates = read(body, {"unit": "percent"}, "d_{joint}", d_joint_1=[50, 0])
    assert rates[:, 0] == pytest.approx([1, 0])


def test_a_joint_of_its_own_unit(body: Body) -> None:
    """A section's unit is that of angles; a sliding joint is in m unless it says otherwise."""
    columns = {"joint_1": [180, 0], "joint_4": [0.1, 0.2]}
    q = read(body, {"unit": "deg"}, **columns)
    assert q[0, [0, 3]] == pytest.approx([np.pi, 0.1])
    q = read(body, {"unit": "deg", "joint_4": {"unit": "cm"}}, **columns)
    assert q[0, [0, 3]] == pytest.approx([np.pi, 0.001])
    for joint, unit in (("joint_1", "mm"), ("joint_4", "deg")):
        with pytest.raises(InputError, match=rf"unknown unit '{unit}' of joint '{joint}'"):
            read(body, {joint: {"unit": unit}}, **columns)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({"colums": {"elbow": "q3"}}, "unknown key 'colums' in .*; did you mean 'columns'"),
        ({"elbow": {"scal": 2}}, r"'scal' in \[joints.elbow\] of 'run.toml'; did you mean 'scale'"),
        ({"elbow": {"scale": 2, "sing": 1}}, "unknown key 'sing' .*did you mean 'sign'"),
        ({"elbow": {"sign": 2}}, "it is 1 or -1"),
        ({"elbow": {"scale": -2.0}}, "scale = -2 .* must be above 0"),
        ({"elbow": {"zero": "a"}}, "zero = 'a' .*expected a finite number"),
        ({"elbow": "q3"}, "unknown key 'elbow'"),
        ({"columns": {"e": "q3"}, "e": {"sign": -1}}, 'names e under columns .*column = "q3"'),
        ("q3", "must be a section"),
    ],
)
def test_what_cannot_be_used_is_said(table: Any, words: str) -> None:
    with pytest.raises(InputError, match=words):
        joint_columns(table, WHERE)


def test_a_joint_that_the_body_does_not_have(body: Body) -> None:
    with pytest.raises(InputError, match="did you mean 'joint_1'"):
        read(body, {"joint1": {"sign": -1}}, joint_1=[0, 1])


def test_a_record_is_the_section() -> None:
    table = {"unit": "%", "columns": {"a": "q1"}, "b": {"sign": -1, "zero": 3}}
    made = joint_columns(table, WHERE)
    assert isinstance(made, JointColumns)
    assert joint_columns(plain(asdict(made)), WHERE) == made


MOTORS = {
    "joint_1": {"id": 1, "drive_mode": 1, "homing_offset": 0, "range_min": 0, "range_max": 4095},
    "gripper": {"id": 2, "drive_mode": 0, "homing_offset": 7, "range_min": 1000, "range_max": 3000},
}


@pytest.fixture
def calibration(tmp_path: Path) -> str:
    (tmp_path / "arm.json").write_text(json.dumps(MOTORS))
    return str(tmp_path / "arm.json")


def test_percent_of_a_motor_of_lerobot(body: Body, calibration: str) -> None:
    """Of its own range, not of the limits; a gripper's runs from 0 to 100."""
    named = {"joint_1": "joint_1.pos", "joint_2": "gripper.pos"}
    table = {"unit": "percent", "calibration": calibration, "columns": named}
    columns: dict[str, Any] = {"joint_1.pos": [50, 0], "gripper.pos": [50, 100]}
    q = read(body, table, **columns)
    assert np.rad2deg(q[:, 0]) == pytest.approx([-90, 0])
    assert np.rad2deg(q[:, 1]) == pytest.approx([0, 1000 * 360 / 4095])
    ticks: dict[str, Any] = {"joint_1.pos": [2047.5], "gripper.pos": [2000]}
    q = read(body, {**table, "unit": "ticks"}, **ticks)
    assert q[0] == pytest.approx([0, 0, 0, 0])
    turned = {"column": "joint_1.pos", "sign": -1}
    table["columns"] = {"joint_2": "gripper.pos"}
    assert np.rad2deg(read(body, {**table, "joint_1": turned}, **columns)[0, 0]) == pytest.approx(
        90
    )


def test_samples_at_an_end_are_cut_off(body: Body, calibration: str) -> None:
    joints = joint_columns({"unit": "percent", "calibration": calibration}, WHERE)
    columns = {"joint_1": np.array([-100.0, 0, 100, 99]), "joint_2": np.array([100.0] * 4)}
    recording = Recording("'data.csv'", columns, {})
    own = {**joints.each, "joint_2": joint_columns({"j": {"unit": "deg"}}, WHERE).each["j"]}
    found = cut_off(body, recording, replace(joints, each=own))
    assert found[:, 0].tolist() == [True, False, True, False]
    assert not found[:, 1:].any(), "of other units nobody knows"
    assert not cut_off(body, recording, joint_columns({"unit": "percent"}, WHERE)).any()


def test_a_record_needs_the_file_no_more(calibration: str) -> None:
    joints = joint_columns({"unit": "percent", "calibration": "arm.json"}, WHERE,
                           Path(calibration).parent)  # fmt: skip
    Path(calibration).unlink()
    assert joint_columns(plain(asdict(joints)), WHERE) == joints


def test_units_that_do_not_go_with_a_motor(body: Body, calibration: str) -> None:
    with pytest.raises(InputError, match="beside a LeRobot calibration"):
        read(body, {"unit": "rad", "calibration": calibration}, joint_1=[0])
    with pytest.raises(InputError, match="no motor 'joint_2'"):
        read(body, {"unit": "deg", "calibration": calibration}, joint_2=[0])
    with pytest.raises(InputError, match="name LeRobot's file"):
        read(body, {"unit": "ticks"}, joint_1=[0])


def test_back_to_the_numbers_of_a_column(body: Body) -> None:
    wrist = {"column": "m5", "sign": -1, "scale": 0.1, "zero": 2048, "unit": "deg"}
    joints = joint_columns({"unit": "percent", "joint_2": wrist}, WHERE)
    for joint in (0, 1):
        one = conversion(body, joint, joints)
        values = np.array([2000.0, 2100.0])
        assert one.column(one.reading(values)) == pytest.approx(values)
