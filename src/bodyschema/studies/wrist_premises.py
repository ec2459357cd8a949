"""What Nabeshima and Kuniyoshi presume of the wrist (section 4.4), and a harder case beside it.

"Currently available force/torque sensor can not inevitably cancel fictitious force ... We carry out
the experiment under low acceleration." Eq. 37 has neither an offset of the sensor nor a turn of it
on its mount: both were known and removed before. Studies of that section run within these premises
unless they are told otherwise, and once more outside them; both are named in their answers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from bodyschema.errors import InputError
from bodyschema.simulation.loads import Sensor, draw_sensor

LEVER = 0.04
"""m, torque offset for each newton of force offset: 20 mNm for 0.5 N."""

FASTEST = 1.0
"""Of the joints' limits; studies that sweep the speed go up to it."""


@dataclass(frozen=True)
class Premises:
    """One case: what is wrong with the sensor, and how fast the arm moves."""

    force_offset: float
    """N, standard deviation of the sensor's offset along each axis."""
    turn_deg: float
    """Degrees, standard deviation of the sensor's turn on its mount about each axis."""
    speed: float
    """Peak joint speed as a share of the limits."""

    def draw_sensor(self, rng: np.random.Generator) -> Sensor:
        """A sensor; of one generator the same errors for all premises, but for their size."""
        bias = (self.force_offset, LEVER * self.force_offset)
        return draw_sensor(rng, float(np.radians(self.turn_deg)), bias)

    def stated(self) -> dict[str, Any]:
        """For the answer, with units."""
        return {
            "force_offset_n": self.force_offset,
            "torque_offset_nm": LEVER * self.force_offset,
            "turn_deg": self.turn_deg,
            "speed": self.speed,
        }

    @property
    def text(self) -> str:
        """For notes under a table."""
        offset = f"offset {self.force_offset:g} N" if self.force_offset else "no offset"
        turn = f"turned {self.turn_deg:g} deg" if self.turn_deg else "not turned"
        return f"{offset}, {turn}, speed x{self.speed:g}"


@dataclass(frozen=True)
class WristPremises:
    """Settings that every study of the wrist has: the paper's premises, and the harder case."""

    force_offset: float = 0.0
    """N, standard deviation of the sensor's offset; the paper presumes that it was removed. That of
    torque is 0.04 m times as large."""
    turn_deg: float = 0.0
    """How far the sensor is turned on its mount, standard deviation about each axis; the paper
    presumes that it is known."""
    speed: float = 0.15
    """Peak joint speed as a share of the limits; the paper moves slowly."""
    outside_force_offset: float = 0.5
    """N, offset in the harder case."""
    outside_turn_deg: float = 1.0
    """Degrees in the harder case."""
    outside_speed: float = 0.5
    """Speed in the harder case."""

    @property
    def within(self) -> Premises:
        """The paper's own case."""
        return Premises(self.force_offset, self.turn_deg, self.speed)

    @property
    def outside(self) -> Premises:
        """The harder one."""
        return Premises(self.outside_force_offset, self.outside_turn_deg, self.outside_speed)

    @property
    def cases(self) -> dict[str, Premises]:
        """Both, by the ending of their keys in an answer."""
        return {"": self.within, "_outside": self.outside}

    @property
    def speeds(self) -> list[float]:
        """Of a sweep: that of either case, and the joints' limits."""
        return sorted({self.speed, self.outside_speed, FASTEST})

    def check_premises(self) -> None:
        """Raise of settings that no arm and no sensor has.

        Raises:
            InputError: an offset or turn below 0, or a speed outside 0 .. 2.
        """
        for ending, case in self.cases.items():
            name = "outside-" if ending else ""
            for flag, value in (("force-offset", case.force_offset), ("turn-deg", case.turn_deg)):
                if value < 0:
                    raise InputError(f"--{name}{flag} is a spread, 0 or more; got {value:g}.")
            if not 0 < case.speed <= 2:
                raise InputError(
                    f"--{name}speed is above 0 and at most 2, a share of the joints' limits; "
                    f"got {case.speed:g}."
                )

    def stated_premises(self) -> dict[str, Any]:
        """Both cases for the answer."""
        return {
            "premises": self.within.stated(),
            "premises_outside": self.outside.stated(),
        }
