"""What a certificate promises, and how its promise is counted."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from bodyschema.estimation.certificate import bound
from bodyschema.studies.hand_eye_errors import certificates


@pytest.mark.parametrize("shape", [(1.0, 1.0, 1.0), (2.0, 1.0, 0.5)])
def test_a_bound_is_passed_by_one_vector_in_a_hundred_at_most(shape: tuple[float, ...]) -> None:
    assert chi2.sf((bound(np.eye(3), 0.0)) ** 2, 3) == pytest.approx(0.01, rel=0.02)
    drawn = np.random.default_rng(0).normal(size=(20_000, 3)) * shape
    passed = np.mean(np.linalg.norm(drawn, axis=1) > bound(np.diag(np.square(shape)), 0.0))
    assert 1e-4 < passed < 0.012


def test_what_the_fit_cannot_see_adds_in_quadrature() -> None:
    assert bound(np.zeros((3, 3)), 0.002) == pytest.approx(0.002)
    assert bound(np.eye(3), 4.0) == pytest.approx(np.hypot(bound(np.eye(3), 0.0), 4.0))


def test_a_certificate_is_false_when_one_error_is_larger_than_promised() -> None:
    good = {"seconds": 5.0, "rotation_deg": 0.1, "camera_mm": 4.0, "tip_mm": 1.0, "nees": 9.0}
    held = [good, good | {"tip_mm": 2.1}, None, good | {"rotation_deg": 90.0}]
    found = certificates(held)
    assert found["false_share"] == pytest.approx(2 / 3)
    assert found["wrong_basin_share"] == pytest.approx(1 / 3)
    assert found["given_share"] == pytest.approx(3 / 4)
