"""Are time stamps in seconds? ROS writes nanoseconds, files milliseconds or microseconds.

Streams of poses have readings every millisecond to every second. Steps that are longer are in
another unit, and which one the steps say by themselves: 1 to 1e3 for ms, to 1e6 for us, beyond for
ns. An eye may well look once in a few seconds; its stamps are doubted only where they also last far
longer than the hand's.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from bodyschema.errors import InputError

Array = NDArray[np.float64]

SLOWEST = 1.0
"""s between readings of a stream, at most."""

UNITS = ((1e3, "ms", "1e3"), (1e6, "us", "1e6"), (np.inf, "ns", "1e9"))
"""Median step up to which stamps are in this unit, and how many of them make a second."""

LONGER = 30.0
"""Times the hand's stream: an eye's that lasts longer is not in its unit."""


def check_stamps(hand: Array, eye: Array) -> None:
    """Refuse streams whose stamps are not in seconds.

    Args:
        hand: (n,) stamps of the hand, increasing.
        eye: (m,) stamps of the eye, increasing.

    Raises:
        InputError: with the unit that they seem to be in.
    """
    lasts = float(hand[-1] - hand[0])
    for whose, time, most in (("hand", hand, 0.0), ("eye", eye, LONGER * lasts)):
        length, step = float(time[-1] - time[0]), float(np.median(np.diff(time)))
        if step <= SLOWEST or length <= most:
            continue
        _, unit, count = next(one for one in UNITS if step <= one[0])
        raise InputError(
            f"the {whose}'s times make a stream of {length:.2g} s with {step:.2g} s between "
            f"readings; are the times in {unit}? Divide them by {count} to give seconds."
        )
