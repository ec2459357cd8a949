"""Mean wrenches: a recorded wrist as a sense, and its linear start."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bodyschema import lie
from bodyschema.model import parts
from bodyschema.model.inertia import Inertia, phi_of_log_cholesky
from bodyschema.model.kernels import FIXED
from bodyschema.model.tree import Body
from bodyschema.senses.mean_wrenches import MeanWrenches
from bodyschema.senses.wrench_means import WrenchMeans
from bodyschema.senses.wrenches import load_regressor

BOX = Inertia(0.6, np.array([0.016, -0.021, 0.092]), np.diag([3e-3, 2.4e-3, 1.6e-3]))
BIAS = np.array([1.0, -2, 3, 0.1, 0.2, -0.1])
TURN = lie.exp_so3([0.3, -0.2, 0.1])


def wrist() -> Body:
    """A mount that nothing carries, and a sensor turned on it."""
    body = Body.build("wrist", ["mount"], [""], [-1], [FIXED], [[0, 0, 1]], np.eye(4)[None])
    body = body.attach("sensor", "mount", lie.transform(TURN, np.zeros(3)))
    return body.with_part("load", parts.load()).with_part("ft", parts.force_sensor())


def recorded(n: int = 30) -> WrenchMeans:
    """Exact means of the box."""
    a, w, dw = np.random.default_rng(0).normal(size=(3, n, 3)) * [[[9.0]], [[1.0]], [[5.0]]]
    Y = load_regressor(a, w, dw)
    f = Y @ BOX.phi
    felt = np.hstack([f[:, :3] @ TURN, f[:, 3:] @ TURN]) + BIAS
    return WrenchMeans(np.arange(n) * 0.5, felt, Y, np.repeat([1e-3, 1e-5], 3), memory=3.0)


def test_the_start_finds_load_and_offset_of_exact_means() -> None:
    sense = MeanWrenches.of(recorded(), "sensor", "mount", 0, sensor="ft")
    assert len(sense) == 10
    found = sense.start(wrist(), ("load", "ft"))
    assert found is not None
    phi = phi_of_log_cholesky(found.part("load").values)[0]
    assert phi == pytest.approx(BOX.phi, abs=1e-4)
    assert found.part("ft").values[:6] == pytest.approx(BIAS, abs=1e-3)
    assert np.abs(sense.residual(found)).max() < 0.01
    assert sense.start(wrist(), ("sensor",)) is None


def test_a_part_that_is_known_stays() -> None:
    sense = MeanWrenches.of(recorded(), "sensor", "mount", 0, loads=("hand", "load"), sensor="ft")
    hand = Inertia(0.2, np.array([0.0, 0.0, 0.05]), np.diag([1e-4] * 3))
    body = wrist().with_part("hand", parts.load(hand))
    biased = replace(body.part("ft"), values=np.concatenate([BIAS, np.zeros(6)]))
    body = body.with_part("ft", biased)
    found = sense.start(body, ("load",))
    assert found is not None
    both = sum(phi_of_log_cholesky(found.part(name).values)[0] for name in ("hand", "load"))
    assert both == pytest.approx(BOX.phi, abs=1e-3)
    assert (found.part("hand").values == body.part("hand").values).all()
    assert (found.part("ft").values == biased.values).all()
