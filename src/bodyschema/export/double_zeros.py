"""Corrected zeros beside those that the description states itself: some drivers add both."""

from __future__ import annotations

from bodyschema.export.urdf_edits import urdf_edits
from bodyschema.model.tree import Body


def double_zeros(nominal: Body, corrected: Body) -> list[str]:
    """A sentence for each joint whose corrected zero a driver might apply twice.

    Args:
        nominal: the body that the URDF describes.
        corrected: the same robot; see `urdf_edits`.
    """
    shifts = {
        joint: -edit.shift_limits
        for joint, edit in urdf_edits(nominal, corrected, stops=True).items()
        if edit.shift_limits is not None and joint in nominal.stated_zeros
    }
    return [
        f"The URDF states a zero of joint '{joint}' of its own, {nominal.stated_zeros[joint]}, and "
        f"robot.urdf has the correction of {shift:+.4f} (rad or m) in its <origin> besides: a "
        "driver that honours what is stated turns by both; remove it there, or do not use this "
        "<origin>."
        for joint, shift in shifts.items()
    ]
