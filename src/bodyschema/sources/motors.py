"""LeRobot's calibration file of an arm: what one in a column is, motor by motor.

    {"elbow_flex": {"id": 3, "drive_mode": 0, "homing_offset": -514,
                    "range_min": 901, "range_max": 3091}, ...}

LeRobot writes states in degrees, in percent of the range of each motor, or in ticks as the motor
reports them; STEPS of them are a turn:

    degrees    (ticks - mid) 360 / STEPS                          mid = (range_min + range_max) / 2
    percent    200 (ticks - range_min) / (range_max - range_min) - 100     of grippers 0 to 100

and reverses percent, not degrees, where drive_mode is not 0. Percent is cut off at the ends of the
range: a sample there says only that the motor was at the end or beyond. Zero is mid-range in all of
them; so a zero is put right by sliding both ends of the range, which leaves the units as they are.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

from bodyschema.documents import json_file
from bodyschema.errors import InputError
from bodyschema.units import listed

STEPS = 4095
"""Ticks of a turn, as LeRobot counts: the resolution less one."""

DEGREES, PERCENT, TICKS = "deg", "percent", "ticks"
UNITS = (DEGREES, PERCENT, TICKS)

GRIPPER = "gripper"
"""The motor whose percent runs from 0 to 100, also where the others are in degrees."""

NAMED = 8
"""Motors that a message names."""


@dataclass(frozen=True)
class Motor:
    """One motor of a calibration file."""

    id: int
    range_min: int
    range_max: int
    drive_mode: int = 0
    homing_offset: int = 0

    @property
    def middle(self) -> float:
        """Ticks at which LeRobot's degrees are 0."""
        return (self.range_min + self.range_max) / 2

    def degrees(self, unit: str, gripper: bool = False) -> tuple[float, float]:
        """What one in a column turns, in degrees the way the ticks grow, and the number at zero.

        Args:
            unit: of `UNITS`.
            gripper: percent runs from 0 to 100, and degrees are percent too.
        """
        width = (self.range_max - self.range_min) * 360 / STEPS
        way = -1.0 if self.drive_mode else 1.0
        if unit == TICKS:
            return 360 / STEPS, self.middle
        if gripper:
            return way * width / 100, 50.0
        return (way * width / 200, 0.0) if unit == PERCENT else (1.0, 0.0)

    def ends(self, unit: str, gripper: bool = False) -> tuple[float, float]:
        """Between which numbers a column is not cut off."""
        if gripper and unit != TICKS:
            return 0.0, 100.0
        return (-100.0, 100.0) if unit == PERCENT else (-float("inf"), float("inf"))

    def slid(self, degrees: float) -> Motor:
        """The motor that reads so many degrees more, to half a tick; units stay as they are."""
        ticks = round(degrees * STEPS / 360)
        return replace(self, range_min=self.range_min - ticks, range_max=self.range_max - ticks)


def motor_name(column: str) -> str:
    """The motor that a column of states is of: elbow_flex of "elbow_flex.pos"."""
    return column.removesuffix(".pos")


def read_motors(path: Path) -> dict[str, Motor]:
    """The motors of a calibration file, by name.

    Raises:
        InputError: it is missing, or no such file.
    """
    table = json_file(
        path, f"no calibration file at '{path}'; LeRobot writes <id>.json.", "no JSON"
    )
    return motors_of(table, f"'{path}'")


def motors_of(table: Any, where: str) -> dict[str, Motor]:
    """The motors that a table describes; see `read_motors`.

    Args:
        table: as in the file.
        where: names it in messages.
    """
    known = [field.name for field in fields(Motor)]
    entries = table if isinstance(table, Mapping) else {}
    made = {}
    for name, entry in entries.items():
        numbers = entry if isinstance(entry, Mapping) else {}
        whole = all(type(numbers.get(key, 0)) is int for key in known)
        if not whole or not {"id", "range_min", "range_max"} <= {*numbers}:
            raise InputError(
                f"'{str(name)[:40]}' in {where} is no motor of a LeRobot calibration; expected "
                f"whole numbers for {', '.join(known)}."
            )
        made[str(name)] = Motor(**{key: numbers[key] for key in known if key in numbers})
        if numbers["range_min"] >= numbers["range_max"]:
            raise InputError(
                f"the range of motor '{name}' in {where} runs from {numbers['range_min']} to "
                f"{numbers['range_max']}; calibrate the motor anew."
            )
    if not made:
        raise InputError(
            f"{where} is no LeRobot calibration: expected a table of motors, each with id, "
            "range_min and range_max."
        )
    return made


def motor_of(column: str, motors: Mapping[str, Motor]) -> Motor:
    """The motor of a column. Raises InputError where the file has none of its name."""
    name = motor_name(column)
    if name not in motors:
        raise InputError(
            f"the calibration file has no motor '{name}', as column '{column}' is called; it has "
            f"{listed(list(motors), NAMED)}. Name the joint's column, or give the joint a unit of "
            "its own."
        )
    return motors[name]
