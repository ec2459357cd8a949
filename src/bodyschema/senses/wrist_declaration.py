"""What the columns of a wrist sensor's recording hold, as somebody declares it.

Recordings differ, and a wrong guess is a wrong answer: frame and sign of the wrench have no
default. What is declared can be tested against the recording, see
`judging.wrist_declarations`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from bodyschema.errors import InputError, did_you_mean

SIGNS = ("on_object", "on_sensor")
KNOWN = ("exactly", "roughly", "no")
BIASES = ("unknown", "none")
POINTS = ("sensor", "flange", "tcp", "base")
"""Origins that a torque is taken about."""


@dataclass(frozen=True)
class WrenchColumns:
    """Force and torque."""

    columns: tuple[str, ...]
    """Six: the forces, then the torques."""
    frame: str
    """Whose axes: "sensor", "flange", "tcp", "base", or a link of the robot."""
    sign: str
    """"on_sensor", the load's pull; "on_object", the push on the load."""
    force_unit: str = "N"
    torque_unit: str = "Nm"
    about: str = ""
    """Origin of the torque; that of `frame`, or the sensor's with "base", when empty."""
    bias: str = "unknown"
    """"none" for a sensor that was tared with nothing on it."""


@dataclass(frozen=True)
class PoseColumns:
    """The flange in the base."""

    columns: tuple[str, ...]
    layout: str = "xyz_xyzw"
    unit: str = "m"
    angle_unit: str = "rad"
    inverse: bool = False
    """The columns hold the base seen from the flange."""
    xyz: tuple[float, ...] = (0.0, 0.0, 0.0)
    """m, and rpy in rad: where the frame of the columns sits in the flange."""
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class GravityColumns:
    """The way down, along the sensor's axes."""

    columns: tuple[str, ...]
    unit: str = "m/s^2"
    kind: str = "gravity"
    """Or "accelerometer", which reads up at rest."""


@dataclass(frozen=True)
class VectorColumns:
    """A velocity or an acceleration, of the flange."""

    columns: tuple[str, ...]
    unit: str = ""
    frame: str = "base"
    """Or "sensor": whose axes."""


@dataclass(frozen=True)
class SensorPlace:
    """Where the sensor sits, and its noise if it is known."""

    link: str = ""
    """With a robot: the link that carries it."""
    xyz: tuple[float, ...] = (0.0, 0.0, 0.0)
    """m, in that link or in the flange."""
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)
    """rad, fixed axes."""
    known: str = "roughly"
    """The turn: "exactly", "roughly" (5 degrees) or "no"."""
    noise_N: float | None = None
    """Of postures at rest; and of the torques."""
    noise_Nm: float | None = None


@dataclass(frozen=True)
class MotionReading:
    """How the motion of a recording is read."""

    kind: str = "auto"
    """"moving", "postures" (every row at rest), or "auto": by the clock."""
    window: float = 0.5
    """s that are averaged."""
    down: tuple[float, ...] = (0.0, 0.0, -9.81)
    """m/s^2, gravity in the base."""


@dataclass(frozen=True)
class LoadSegments:
    """Which times belong to the gripper alone, and which to gripper and object."""

    empty: tuple[Any, ...] = ()
    """(from, to) in s, or a list of such pairs."""
    loaded: tuple[Any, ...] = ()


@dataclass(frozen=True)
class WristDeclaration:
    """All that is said of a recording; its wrench, and one source of the orientation, at least."""

    wrench: WrenchColumns
    pose: PoseColumns | None = None
    gravity: GravityColumns | None = None
    velocity: VectorColumns | None = None
    acceleration: VectorColumns | None = None
    angular_velocity: VectorColumns | None = None
    angular_acceleration: VectorColumns | None = None
    sensor: SensorPlace = field(default_factory=SensorPlace)
    down: tuple[float, ...] = (0.0, 0.0, -9.81)
    """m/s^2, gravity in the base."""
    time: str | None = None
    """Column of times; the usual names when None, "" for postures at rest."""
    time_unit: str = "s"

    def __post_init__(self) -> None:
        chosen = (
            ("sign", self.wrench.sign, SIGNS),
            ("bias", self.wrench.bias, BIASES),
            ("about", self.wrench.about or "sensor", POINTS),
            ("known", self.sensor.known, KNOWN),
        )
        for key, word, known in chosen:
            if word not in known:
                raise InputError(f"{key} = '{word}'{did_you_mean(word, known)}")
        counted = [("wrench", self.wrench.columns, 6)]
        for name in VECTORS:
            entry: VectorColumns | GravityColumns | None = getattr(self, name)
            counted += [(name, entry.columns, 3)] if entry else []
        for place in (self.sensor, self.pose or self.sensor):
            counted += [("xyz", tuple(map(str, place.xyz)), 3)]
            counted += [("rpy", tuple(map(str, place.rpy)), 3)]
        for name, values, count in (*counted, ("down", tuple(map(str, self.down)), 3)):
            if len(values) != count:
                raise InputError(f"[{name}] needs {count} entries, it has {len(values)}.")


VECTORS = ("gravity", "velocity", "acceleration", "angular_velocity", "angular_acceleration")
"""Entries of three columns."""
