"""One joint's new values in a URDF, as they will be written."""

from __future__ import annotations

import math
from dataclasses import dataclass

from bodyschema.errors import InputError

Vector = tuple[float, float, float]

DEFAULTS: dict[tuple[str, str], tuple[float, ...]] = {
    ("origin", "xyz"): (0.0, 0.0, 0.0),
    ("origin", "rpy"): (0.0, 0.0, 0.0),
    ("axis", "xyz"): (1.0, 0.0, 0.0),
    ("limit", "lower"): (0.0,),
    ("limit", "upper"): (0.0,),
}
"""What readers of a URDF take for an attribute that is not written."""


@dataclass(frozen=True)
class JointEdit:
    """New values for one `<joint>`; None leaves the attribute as it is."""

    xyz: Vector | None = None
    """`<origin xyz>`: position of the joint's frame in that of its parent link, metres."""
    rpy: Vector | None = None
    """`<origin rpy>`: fixed-axis angles of the same placement (Rz·Ry·Rx), rad."""
    axis: Vector | None = None
    """`<axis xyz>`: unit vector in the joint's frame."""
    lower: float | None = None
    """`<limit lower>`: rad for a revolute joint, metres for a prismatic one."""
    upper: float | None = None
    """`<limit upper>`: rad for a revolute joint, metres for a prismatic one."""
    shift_limits: float | None = None
    """Added to the limits that the file states, `<limit>` and soft ones of `<safety_controller>`:
    rad or metres. For a joint whose zero has moved; a continuous joint has none to add it to."""

    def __post_init__(self) -> None:
        """Refuse numbers that would break the file for its readers."""
        for tag, group in self.numbers().items():
            for name, numbers in group.items():
                count = len(DEFAULTS[tag, name])
                if len(numbers) != count or not all(map(math.isfinite, numbers)):
                    raise InputError(f"<{tag} {name}> needs {count} finite numbers: {numbers}.")
        if self.axis is not None and abs(math.hypot(*self.axis) - 1.0) > 1e-6:
            raise InputError(f"axis needs a unit vector, got {self.axis}: divide by its length.")
        if self.lower is not None and self.upper is not None and self.lower > self.upper:
            raise InputError(f"the lower limit {self.lower} is above the upper {self.upper}.")
        if self.shift_limits is not None:
            if not math.isfinite(self.shift_limits):
                raise InputError(f"shift_limits needs a finite number, got {self.shift_limits}.")
            if self.lower is not None or self.upper is not None:
                raise InputError("give new limits or shift_limits, not both.")

    def numbers(self) -> dict[str, dict[str, tuple[float, ...]]]:
        """Return the given values as they will be written, by element and attribute."""
        limits = {"lower": self.lower, "upper": self.upper}
        values: dict[str, dict[str, tuple[float, ...] | None]] = {
            "origin": {"xyz": self.xyz, "rpy": self.rpy},
            "axis": {"xyz": self.axis},
            "limit": {name: None if x is None else (x,) for name, x in limits.items()},
        }
        return {
            tag: {name: tuple(map(clean, xs)) for name, xs in group.items() if xs is not None}
            for tag, group in values.items()
        }


def clean(value: float) -> float:
    """Drop the rounding noise of a computation: 0.30000000000000004 is 0.3, -0.0 is 0.0."""
    short = round(float(value), 12)
    noise = 4.0 * math.ulp(max(1.0, abs(short)))
    return (short if abs(short - value) <= noise else float(value)) + 0.0


def nearest_rpy(rpy: Vector, old: Vector) -> Vector:
    """The same rotation by the angles that lie nearest to others.

    (r, p, y) and (r + pi, pi - p, y + pi) turn alike, and so does every angle a whole turn on.
    """
    r, p, y = rpy
    same = ((r, p, y), (r + math.pi, math.pi - p, y + math.pi))
    turned = [
        tuple(
            a - 2 * math.pi * round((a - b) / (2 * math.pi)) for a, b in zip(one, old, strict=True)
        )
        for one in same
    ]
    a, b, c = min(turned, key=lambda one: math.dist(one, old))
    return a, b, c
