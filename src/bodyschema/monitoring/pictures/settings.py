"""What a watch of hand and eye in pictures goes by, and what it is given."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from bodyschema.estimation.certificate import Tolerance
from bodyschema.learners.hand_eye.stereo_points import Stereo

Array = NDArray[np.float64]
Grey = NDArray[np.uint8]


@dataclass(frozen=True)
class StereoFrame:
    """One moment of a rectified pair and of the encoders."""

    time: float
    """s"""
    q: Array
    """(J,) rad."""
    T_world_hand: Array
    """(4, 4) of the hand, by the arm's kinematics."""
    left: Grey
    """(height, width)."""
    right: Grey
    """(height, width)."""


@dataclass(frozen=True)
class PictureSettings:
    """What decides."""

    joints: tuple[str, ...]
    """Names of what the encoders read."""
    stereo: Stereo
    """The rectified pair."""
    tolerance: Tolerance = field(
        default_factory=lambda: Tolerance({"rotation": 0.0035, "camera": 0.005})
    )
    """rad, m: 0.2 degrees and 5 mm, at 99 %."""
    find_s: float = 3.0
    """s of waggling from which the hand is found."""
    often: float = 0.2
    """Share of those frames in which a cell of the hand moves."""
    every: int = 3
    """Frames between two rows of a corner: errors of frames nearer together are the same."""
    solve: int = 15
    """Frames between two fits, looks at landmarks and births."""
    least_corners: int = 20
    """That a certificate rests on."""
    explains_px: float = 0.4
    """px: noise of u and v beyond which a fit does not explain what is seen."""
    keep: int = 250
    """Corners whose rows are kept; older ones stay as a prior of the camera."""
