"""What a simulated camera and the encoders deliver, with the truth about every pixel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Pictures = NDArray[np.uint8]

WIDTH, HEIGHT = 320, 240
"""pixels"""


@dataclass(frozen=True)
class Film:
    """Pictures with encoder readings of the same time stamps, and what is truly seen."""

    joints: tuple[str, ...]
    """J names; those that carry the camera come last."""
    head: tuple[str, ...]
    """Those of the joints that carry the camera."""
    time: Array
    """(n,) s."""
    q: Array
    """(n, J) rad."""
    pictures: Pictures
    """(n, HEIGHT, WIDTH) grey."""
    motion_end: Array
    """(M,) s, when each motion is over in the encoders."""
    delay_s: float
    """Time stamp of a picture minus the time of what it shows."""
    labelled: NDArray[np.int64]
    """(m,) frames whose pixels are labelled."""
    body: Flags
    """(m, HEIGHT, WIDTH) pixels of links that the arm's joints move."""
    thing: Flags
    """(m, HEIGHT, WIDTH) pixels of the rod or the sleeve."""
    speed: Array
    """(J, HEIGHT, WIDTH) pixels/rad by which each joint moves what is seen at home; 0 off the
    robot."""
