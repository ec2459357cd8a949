"""What two wrists carry, side by side."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bodyschema import InputError
from bodyschema.answers.comparison import compare
from bodyschema.model.inertia import Inertia
from bodyschema.trust.trust import Trust

STD = np.array([2e-3, *[1e-4] * 3, *[1e-5] * 6])


def carrying(mass: float, verb: str = "payload") -> Any:
    """An answer that knows a load of this mass (kg), five centimetres before the wrist."""
    load = Inertia(mass, np.array([0.0, 0.0, 0.05]), 1e-3 * mass * np.eye(3))
    loads = [{"name": "a", "phi": dict(enumerate(load.phi)), "phi_covariance": np.diag(STD**2)}]
    return SimpleNamespace(
        verb=verb, details={"loads": loads, "last": ["a"]}, trust=Trust(), from_nothing=False
    )


def test_the_same_load() -> None:
    found = compare(carrying(0.5), carrying(0.502))
    assert found.same
    assert {part.part for part in found.parts} == {"mass", "centre of mass", "moments"}


def test_a_heavier_load_is_told_by_its_mass() -> None:
    found = compare(carrying(0.5), carrying(0.55))
    assert found.parts[0].part == "mass"
    assert found.parts[0].differs
    assert found.parts[0].change == pytest.approx([0.05])
    assert found.parts[0].deviations == pytest.approx(0.05 / (2e-3 * 2**0.5))


def test_a_load_and_a_robot_are_no_pair() -> None:
    with pytest.raises(InputError, match=r"of payload and the second of calibrate"):
        compare(carrying(0.5), carrying(0.5, "calibrate"))
    with pytest.raises(InputError, match="find-body"):
        compare(carrying(0.5, "find-body"), carrying(0.5))
