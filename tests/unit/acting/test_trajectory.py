"""Open loop: equal steps that end where they should."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.acting.trajectory import joint_trajectory
from bodyschema.errors import InputError


def test_steps_are_equal_and_the_last_is_the_goal_itself() -> None:
    q_i, q_d = np.array([0.1, -0.7, 3.0]), np.array([0.4, 0.2, 3.0])
    way = joint_trajectory(q_i, q_d, 120)
    assert way.shape == (120, 3)
    np.testing.assert_array_equal(way[-1], q_d)
    steps = np.diff(np.vstack([q_i, way]), axis=0)
    np.testing.assert_allclose(steps, np.tile((q_d - q_i) / 120, (120, 1)), atol=1e-15)


@pytest.mark.parametrize(("q_d", "frames"), [([1.0], 3), ([1.0, 2.0], 0)])
def test_other_robots_and_no_frame_are_refused(q_d: list[float], frames: int) -> None:
    with pytest.raises(InputError, match="two postures"):
        joint_trajectory([0.0, 0.0], q_d, frames)
