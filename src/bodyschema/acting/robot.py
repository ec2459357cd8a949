"""What acting needs of a robot: where its joints are, and a way to ask them to go elsewhere.

A driver of a real robot is a class with these three names; nothing in this library moves a robot
by itself, only a call of `command` does.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


class Robot(Protocol):
    """A robot that can be read and moved."""

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints, in the order of every q."""
        ...

    def read(self) -> Array:
        """(n_joints,) what the encoders say now, rad or m."""
        ...

    def command(self, q: ArrayLike) -> None:
        """Go to these encoder readings, (n_joints,), and return when there.

        Raises:
            InputError: a joint is sent beyond its range, or the array does not fit; the robot then
                stands where it stood.
        """
        ...
