"""LeRobot's calibration file: the same motion in degrees, percent and ticks is the same reading."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.sources.motors import Motor, motor_of, read_motors

TICKS = np.array([900.0, 1500.0, 2047.0, 3000.0])


def as_lerobot_writes(motor: Motor, ticks: Any, unit: str) -> Any:
    """As `MotorsBus._normalize` of LeRobot 0.3 has it."""
    low, high = motor.range_min, motor.range_max
    inside = np.clip(ticks, low, high)
    if unit == "percent":
        value = (inside - low) / (high - low) * 200 - 100
        return -value if motor.drive_mode else value
    if unit == "gripper":
        value = (inside - low) / (high - low) * 100
        return 100 - value if motor.drive_mode else value
    return (ticks - (low + high) / 2) * 360 / 4095


@pytest.mark.parametrize("drive_mode", [0, 1])
def test_three_units_of_one_motion(drive_mode: int) -> None:
    motor = Motor(1, 800, 3300, drive_mode)
    turned = as_lerobot_writes(motor, TICKS, "deg")
    for unit, column in (
        ("deg", turned),
        ("percent", as_lerobot_writes(motor, TICKS, "percent")),
        ("ticks", TICKS),
    ):
        size, zero = motor.degrees(unit)
        assert size * (column - zero) == pytest.approx(turned, abs=1e-9), unit
    size, zero = motor.degrees("percent", gripper=True)
    column = as_lerobot_writes(motor, TICKS, "gripper")
    assert size * (column - zero) == pytest.approx(turned, abs=1e-9)


def test_sliding_puts_a_zero_right_and_leaves_the_units() -> None:
    motor = Motor(1, 800, 3300)
    slid = motor.slid(2.5)
    assert slid.range_max - slid.range_min == 2500
    for unit in ("deg", "percent"):
        size = motor.degrees(unit)[0]
        more = as_lerobot_writes(slid, TICKS, unit) - as_lerobot_writes(motor, TICKS, unit)
        assert size * more == pytest.approx([2.5] * 4, abs=360 / 4095 / 2), unit


def test_a_file_is_read(tmp_path: Path) -> None:
    path = tmp_path / "so101.json"
    entry = {"id": 3, "drive_mode": 1, "homing_offset": -5, "range_min": 1, "range_max": 2}
    path.write_text(json.dumps({"elbow_flex": entry}))
    motors = read_motors(path)
    assert motors == {"elbow_flex": Motor(3, 1, 2, 1, -5)}
    assert motor_of("elbow_flex.pos", motors).id == 3
    with pytest.raises(InputError, match=r"no motor 'wrist', .*it has elbow_flex"):
        motor_of("wrist", motors)


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ([], "is no LeRobot calibration"),
        ({}, "is no LeRobot calibration"),
        ({"a": {"id": 1}}, "'a' in .* is no motor"),
        ({"a": {"id": 1, "range_min": 1.5, "range_max": 3}}, "expected whole numbers"),
        ({"a": {"id": 1, "range_min": 9, "range_max": 3}}, "runs from 9 to 3"),
    ],
)
def test_what_is_no_calibration(tmp_path: Path, table: Any, words: str) -> None:
    path = tmp_path / "arm.json"
    path.write_text(json.dumps(table))
    with pytest.raises(InputError, match=words):
        read_motors(path)
    with pytest.raises(InputError, match="no calibration file at"):
        read_motors(tmp_path / "none.json")
