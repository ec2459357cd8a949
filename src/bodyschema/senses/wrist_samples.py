"""What is recorded of a wrist sensor and its motion, row by row, before anything is derived."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class WristSamples:
    """What a recording or a stream says, row by row; what it does not say is None."""

    time: Array
    """(n,) s, increasing."""
    wrench: Array
    """(n, 6) N and Nm, by the sensor on the object, along the sensor's axes."""
    rotation: Array | None = None
    """(n, 3, 3) R_world_sensor."""
    position: Array | None = None
    """(n, 3) m, of the sensor in the world."""
    gravity: Array | None = None
    """(n, 3) m/s^2, downward along the sensor's axes; less acceleration where `carried`."""
    velocity: Array | None = None
    """(n, 3) m/s of the sensor's origin, along the world's axes."""
    acceleration: Array | None = None
    """(n, 3) m/s^2, the same."""
    angular_velocity: Array | None = None
    """(n, 3) rad/s, along the sensor's axes."""
    angular_acceleration: Array | None = None
    """(n, 3) rad/s^2, the same."""
    carried: bool = False
    """Whether `gravity` is minus what an accelerometer at the sensor felt."""
    down: tuple[float, float, float] = (0.0, 0.0, -9.81)
    """m/s^2, gravity in the world."""

    def __post_init__(self) -> None:
        if self.rotation is None and self.gravity is None:
            raise InputError(
                "the way down is not known: give the sensor's orientation or its gravity vector."
            )

    def __len__(self) -> int:
        return len(self.time)

    def downward(self) -> Array:
        """(n, 3) m/s^2, gravity along the sensor's axes."""
        return self._turned(np.asarray(self.down)) if self.gravity is None else self.gravity

    def to_sensor(self, vectors: Array) -> Array:
        """(n, 3) along the sensor's axes, of vectors (n, 3) along the world's."""
        return self._turned(vectors)

    def _turned(self, vectors: Array) -> Array:
        if self.rotation is None:
            raise InputError(
                "velocities and accelerations along the world's axes need the sensor's "
                "orientation; give its pose, or give them along the sensor's axes."
            )
        turned = np.swapaxes(self.rotation, 1, 2) @ vectors[..., None]
        return np.asarray(turned[..., 0])

    def take(self, rows: slice | Ints) -> WristSamples:
        """Some of the rows."""
        columns = {name: getattr(self, name) for name in COLUMNS}
        chosen: dict[str, Any] = {k: None if c is None else c[rows] for k, c in columns.items()}
        return replace(self, **chosen)


COLUMNS = (
    "time", "wrench", "rotation", "position", "gravity",
    "velocity", "acceleration", "angular_velocity", "angular_acceleration",
)  # fmt: skip
