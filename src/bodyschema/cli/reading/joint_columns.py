"""The section [joints] of a run file: which columns hold the joints, and in which units.

    [joints]
    unit = "rad"                            # of all columns that say nothing else
    columns = { elbow = "q3" }              # where only the name differs

    [joints.wrist]                          # or more than the name
    column = "motor_5"
    sign = -1                               # the motor turns the other way
    scale = 0.088                           # one count, in the unit
    zero = 2048                             # the count at which the joint is at zero
    unit = "deg"

    reading = sign scale (number in the column - zero), in the unit

In "percent" the number is -100 at the lower limit and 100 at the upper one.

    [joints]
    calibration = "my_arm.json"             # LeRobot's: what one in a column is, motor by motor
    unit = "percent"                        # or "deg", "ticks": as the data set was recorded

"percent" is then of each motor's own range, and samples at its ends, where it is cut off, are left
out. The way is that of the ticks; a joint that turns the other way in the URDF has sign = -1.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

from bodyschema.cli.entry_types import entry_of, section
from bodyschema.errors import InputError
from bodyschema.sources.motors import Motor, motors_of, read_motors

PERCENT = ("percent", "%")
"""Units of the limits: -100 is the lower one, 100 the upper one."""


@dataclass(frozen=True)
class JointEntry:
    """How one joint is recorded."""

    column: str = ""
    """That is named like the joint when empty."""
    unit: str = ""
    """That of the section when empty; a sliding joint's is m."""
    scale: float = 1.0
    """What one in the column is, in the unit."""
    sign: int = 1
    """-1 where the column grows as the joint turns back."""
    zero: float = 0.0
    """The number in the column at which the joint is at zero, or half way between its limits."""

    def check(self, where: str) -> None:
        """Refuse numbers that mean nothing. Raises InputError."""
        if self.sign not in (1, -1):
            raise InputError(f"sign = {self.sign} in {where}; it is 1 or -1, see scale for sizes.")
        if self.scale <= 0:
            raise InputError(f"scale = {self.scale:g} in {where} must be above 0; see sign.")


@dataclass(frozen=True)
class JointColumns:
    """How joint readings are recorded."""

    unit: str = "rad"
    columns: dict[str, str] = field(default_factory=dict)
    each: dict[str, JointEntry] = field(default_factory=dict)
    """Joint -> how it is recorded, from [joints.NAME]."""
    calibration: str = ""
    """LeRobot's file."""
    motors: dict[str, Motor] = field(default_factory=dict)
    """What stands in it, so that a record of the run needs it no more."""

    def check(self, where: str) -> None:
        """Refuse joints that are described twice. Raises InputError."""
        twice = [joint for joint in self.each if joint in self.columns]
        if twice:
            raise InputError(
                f"{where} names {twice[0]} under columns and by a section of its own; write "
                f'column = "{self.columns[twice[0]]}" into the section.'
            )

    def of(self, joint: str) -> JointEntry:
        """How one joint is recorded."""
        entry = self.each.get(joint, JointEntry())
        column = entry.column or self.columns.get(joint, joint)
        return JointEntry(column, entry.unit, entry.scale, entry.sign, entry.zero)

    @property
    def named(self) -> tuple[str, ...]:
        """Joints of which something is said."""
        return (*self.columns, *self.each)


def joint_columns(table: Any, where: str, here: Path = Path()) -> JointColumns:
    """The section as it stands in a run file, or in a record of one.

    Args:
        table: the section.
        where: names it in messages.
        here: anchors the path of a calibration file.

    Raises:
        InputError: a key is unknown, or a value does not fit.
    """
    if not isinstance(table, Mapping):
        return entry_of(JointColumns, table, where)
    own, said = [f.name for f in fields(JointColumns)], {f.name for f in fields(JointEntry)}
    near = [name for name in table if difflib.get_close_matches(name, own)]  # misspelt, perhaps
    inner = {
        name: entry
        for name, entry in table.items()
        if name not in own and isinstance(entry, Mapping) and (said & {*entry} or name not in near)
    }
    rest = {name: entry for name, entry in table.items() if name not in inner}
    each = {**section(rest.get("each", {}), where), **inner}
    rest["each"] = {
        name: entry_of(JointEntry, entry, f"{where.replace(']', f'.{name}]', 1)}")
        for name, entry in each.items()
    }
    file = rest.get("calibration")
    if isinstance(file, str) and file:
        path = here / file
        told = rest.get("motors")
        motors = motors_of(told, f"motors of {where}") if told else read_motors(path)
        rest |= {"calibration": str(path), "motors": motors}
    elif rest.get("motors"):
        raise InputError(f"motors in {where} has no calibration; name LeRobot's file.")
    return entry_of(JointColumns, rest, where)
