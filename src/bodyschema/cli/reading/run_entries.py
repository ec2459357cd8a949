"""Sections of the run file besides its senses and parts."""

from __future__ import annotations

from dataclasses import dataclass

from bodyschema.cli.entry_types import one_of
from bodyschema.errors import InputError

KNOWLEDGE = ("exactly", "roughly", "no")

MOUNTS, JOINS = ("hand", "base"), ("rows", "time")
"""What may carry an eye, and how poses of robot and eye are joined."""


@dataclass(frozen=True)
class FrameEntry:
    """A fixed frame besides those of the robot description."""

    parent: str
    xyz: tuple[float, ...] = (0.0, 0.0, 0.0)
    rpy: tuple[float, ...] = (0.0, 0.0, 0.0)
    known: str = "no"
    per_recording: bool = False
    """It was moved between the recordings that `append` names."""

    def check(self, where: str) -> None:
        """Refuse a placement that is none. Raises InputError."""
        one_of("known", self.known, KNOWLEDGE, where)
        for name in ("xyz", "rpy"):
            if len(getattr(self, name)) != 3:
                raise InputError(f"{name} in {where} must be three numbers.")


@dataclass(frozen=True)
class FreeEntry:
    """What may be wrong, where the user says."""

    groups: tuple[str, ...] | None = None
    joints: tuple[str, ...] | None = None
    offset_deg: float | None = None
    """How wrong offsets may be, one standard deviation, where pictures have no markers."""
    offset_mm: float | None = None


@dataclass(frozen=True)
class WantedEntry:
    """A frame of the robot that is to be right, whatever it is that was seen."""

    seen: str
    seen_from: str = ""
    """The root of the robot when empty."""


@dataclass(frozen=True)
class HandEyeEntry:
    """What `hand-eye` reads besides two senses of poses: the robot's, then the eye's."""

    eye_on: str = "hand"
    """What carries the eye: "hand" or "base"."""
    join: str = "rows"
    """"rows" of one recording or of equally long ones are pairs; "time": streams, by a lag."""
    free_scale: bool | None = None
    """The eye's lengths have one unknown scale; decided by the data when absent."""
    accepted_mm: float = 50.0
    """Error of the eye's place above which it counts as not known."""

    def check(self, where: str) -> None:
        """Refuse words that mean nothing. Raises InputError."""
        one_of("eye_on", self.eye_on, MOUNTS, where)
        one_of("join", self.join, JOINS, where)
