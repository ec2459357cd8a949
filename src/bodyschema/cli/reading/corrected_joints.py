"""What a result says of joints' readings, put into what was recorded: columns, calibration files.

A joint's true value is (1 + gear) q + offset. The column that is written says that value in the
unit, scale, sign and zero of the run, so that whoever read the recording before reads it as before.
What is wrong with axes and links stands in no reading: it is in the corrected description.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.cli.reading.joint_columns import PERCENT, JointColumns
from bodyschema.cli.reading.joints import column_of, conversion
from bodyschema.errors import InputError, did_you_mean
from bodyschema.export.corrections import joint_corrections
from bodyschema.model.tree import Body
from bodyschema.sources.motors import STEPS, Motor, motor_name
from bodyschema.sources.recording import Recording
from bodyschema.units import listed

if TYPE_CHECKING:
    from bodyschema.answers.answer import Answer

Array = NDArray[np.float64]

NAMED = 6
"""Joints that a sentence names."""

DEG = 180 / np.pi


@dataclass(frozen=True)
class CorrectedJoints:
    """The joints of a run with what corrects their readings."""

    body: Body
    joints: JointColumns
    offset: Mapping[str, float]
    """Joint -> rad or m."""
    gear: Mapping[str, float]
    notes: tuple[str, ...]

    @classmethod
    def of(cls, answer: Answer, joints: JointColumns) -> CorrectedJoints:
        """The corrections of an answer.

        Raises:
            InputError: nothing of it may be put on a robot, or it corrects no reading.
        """
        found = joint_corrections(answer)
        offset, gear, others = dict[str, float](), dict[str, float](), list[str]()
        for name, value in found.items():
            joint, _, what = name.rpartition(".")
            if what in ("offset", "gear"):
                (offset if what == "offset" else gear)[joint] = value
            else:
                others.append(joint)
        if not offset and not gear:
            raise InputError(
                "the result corrects no zero and no gain of a joint, so readings stay as they are."
            )
        notes = []
        if others:
            some = listed(list(dict.fromkeys(others)), NAMED)
            notes.append(
                f"Axes or links of {some} were corrected, too, which no reading can say: use the "
                "corrected readings with a description that has these, and not these zeros twice."
            )
        return cls(answer.estimate.reference, joints, offset, gear, tuple(notes))

    @property
    def named(self) -> list[str]:
        """Joints whose readings change."""
        return [joint for joint in self.body.joints if joint in {*self.offset, *self.gear}]

    def columns(self, recording: Recording) -> dict[str, Array]:
        """The corrected columns of a recording, by name; nan where a cell is empty.

        Raises:
            InputError: it has none of them.
        """
        made = {}
        for joint in self.named:
            column = column_of(joint, self.joints)
            if column not in recording.columns:
                continue
            values, filled = recording.matrix([column], "1")
            one = conversion(self.body, self.body.joint_index(joint), self.joints)
            q = one.reading(values[:, 0])
            true = (1 + self.gear.get(joint, 0.0)) * q + self.offset.get(joint, 0.0)
            made[column] = np.where(filled, one.column(true), np.nan)
        if not made:
            wanted = [column_of(joint, self.joints) for joint in self.named]
            raise InputError(
                f"{recording.source} has no column of the joints that are corrected, "
                f"{listed(wanted, NAMED)}{did_you_mean(wanted[0], recording.columns)}"
            )
        return made

    def motors(self, motors: Mapping[str, Motor]) -> tuple[dict[str, Motor], list[str]]:
        """LeRobot's motors with the zeros put right, and what to know of it; units stay.

        Raises:
            InputError: none of the joints has a motor there.
        """
        slid, notes = dict(motors), list[str]()
        for joint in self.offset:
            name = motor_name(column_of(joint, self.joints))
            if name in motors:
                way = self._way(joint, motors[name])
                slid[name] = one = motors[name].slid(way * DEG * self.offset[joint])
                if one.range_min < 0 or one.range_max > STEPS:
                    notes.append(
                        f"The range of '{name}' would run from {one.range_min} to {one.range_max}, "
                        f"beyond 0 to {STEPS}: home that motor anew instead."
                    )
        if slid == motors:
            wanted = [motor_name(column_of(joint, self.joints)) for joint in self.offset]
            raise InputError(
                f"the calibration file has no motor of the joints that are corrected by a tick or "
                f"more, {listed(wanted, NAMED)}{did_you_mean(wanted[0] if wanted else '', motors)}"
            )
        if self.gear:
            notes.append(
                f"Gains of {listed(list(self.gear), NAMED)} are not in it: a turn of a motor has "
                f"{STEPS} ticks by definition."
            )
        return slid, notes

    def _way(self, joint: str, motor: Motor) -> float:
        """1 where the joint's reading grows with the ticks of its motor, else -1."""
        percent = self.joints.unit in PERCENT and not self.joints.motors
        return float(self.joints.of(joint).sign) * (-1.0 if percent and motor.drive_mode else 1.0)


def with_motors(document: Mapping[str, Any], slid: Mapping[str, Motor]) -> dict[str, Any]:
    """A calibration file with the ranges of these motors, all else as it is."""
    return {
        name: {**entry, "range_min": slid[name].range_min, "range_max": slid[name].range_max}
        for name, entry in document.items()
    }
