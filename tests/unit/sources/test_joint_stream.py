"""Joint readings between the readings."""

from __future__ import annotations

import numpy as np
import pytest

from bodyschema.errors import InputError
from bodyschema.sources.joint_stream import JointStream


def swing(time: np.ndarray) -> np.ndarray:
    return np.column_stack([np.sin(2 * np.pi * time / 8), np.cos(2 * np.pi * time / 6)])


def test_between_readings_and_how_fast() -> None:
    time = np.arange(0, 20, 0.8)
    stream = JointStream("'joints.csv'", time, swing(time))
    at = np.linspace(3, 16, 50)
    q, rate, known = stream.at(at)
    assert known.all()
    assert np.abs(q - swing(at)).max() < 5e-4
    slope = (swing(at + 1e-6) - swing(at - 1e-6)) / 2e-6
    assert np.abs(rate - slope).max() < 2e-3
    assert stream.speed == pytest.approx(np.sqrt(0.5) * 2 * np.pi / 6, rel=0.1)


def test_pauses_and_ends_are_not_known() -> None:
    time = np.concatenate([np.arange(0, 5, 0.1), np.arange(9, 14, 0.1)])
    stream = JointStream("'joints.csv'", time, swing(time))
    q, _, known = stream.at(np.array([-0.1, 0.0, 4.85, 7.0, 9.05, 13.5, 14.1]))
    assert known.tolist() == [False, True, True, False, True, True, False]
    assert np.isfinite(q).all()


def test_too_few_readings() -> None:
    with pytest.raises(InputError, match=r"'joints.csv' has 5 readings"):
        JointStream("'joints.csv'", np.arange(5.0), np.zeros((5, 2)))
