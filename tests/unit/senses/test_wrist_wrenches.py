"""Wrenches: derivatives, known cases, and closed-form starts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model import parts
from bodyschema.model.inertia import Inertia, log_cholesky
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.motion import Motion, frame_motion, motion_derivatives
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, free_part, join
from bodyschema.senses.gravity import G
from bodyschema.senses.wrist_wrenches import WristWrenches

Array = NDArray[np.float64]

BOX = Inertia(0.6, np.array([0.016, -0.021, 0.092]), np.diag([3e-3, 2.4e-3, 1.6e-3]))
N = 6


def arm() -> Body:
    """Four joints, a sensor at the tip and a frame whose z points up."""
    body = Body.random_chain(4, np.random.default_rng(0))
    body = body.attach("sensor", "tip", lie.transform(lie.exp_so3([0.4, 0.1, -0.2]), [0.01] * 3))
    body = body.attach("up", "base", lie.transform(lie.exp_so3([0.1, 0.2, 0.0]), [0.0] * 3))
    body = body.with_part("load", parts.load(BOX)).with_part("tool", parts.load())
    return body.with_part("ft", parts.force_sensor())


def variables(body: Body) -> Variables:
    """All that a wrench can tell of."""
    frames = [free_frame(body, frame) for frame in ("sensor", "up")]
    held = [free_part(body, part) for part in ("load", "tool", "ft")]
    return join(free_joints(body), *frames, *held)


def felt(moving: bool) -> tuple[WristWrenches, Body, Variables, Array]:
    """Samples that hold at the truth x."""
    body = arm()
    free = variables(body)
    rng = np.random.default_rng(1)
    x = 0.3 * rng.uniform(-1, 1, len(free)) * np.minimum(free.scale, 1.0)
    q, dq, ddq = (rng.uniform(-1, 1, (N, 4)) for _ in range(3))
    more = {"dq": dq, "ddq": ddq} if moving else {}
    sense = WristWrenches.make(
        q, np.zeros((N, 6)), "sensor", "up", loads=("load", "tool"), sensor="ft", **more
    )
    return replace(sense, observed=sense.predict(body.with_variables(free, x))), body, free, x


@pytest.mark.parametrize("moving", [False, True])
def test_derivatives_agree_with_differences(moving: bool) -> None:
    sense, body, free, truth = felt(moving)
    x, step = 0.5 * truth, 1e-6
    L = sense.linearize(body, free, x)
    assert L.residual == pytest.approx(sense.residual(body.with_variables(free, x)), abs=1e-12)
    for i, d in enumerate(step * np.eye(len(free))):
        ends = [sense.residual(body.with_variables(free, x + s * d)) for s in (1, -1)]
        assert L.by_parameter[:, :, i] == pytest.approx((ends[0] - ends[1]) / (2 * step), abs=2e-6)
    there = body.with_variables(free, x)
    for j, d in enumerate(step * np.eye(4)):
        ends = [replace(sense, q=sense.q + s * d).residual(there) for s in (1, -1)]
        assert L.by_joint[:, :, j] == pytest.approx((ends[0] - ends[1]) / (2 * step), abs=2e-6)


def test_at_rest_the_sensor_holds_the_weight() -> None:
    body = Body.random_chain(2, np.random.default_rng(3)).with_part("load", parts.load(BOX))
    sense = WristWrenches.make(np.zeros((1, 2)), np.zeros((1, 6)), "base", "base")
    weight = BOX.mass * G * np.array([0.0, 0.0, 1.0])
    wrench = [*weight, *np.cross(BOX.com, weight)]
    assert sense.predict(body)[0] == pytest.approx(wrench, abs=1e-12)


def test_the_sensor_reads_with_its_gain_and_offset() -> None:
    body = arm()
    values = np.array([1.0, 2, 3, 0.1, 0.2, 0.3, *[0.01] * 6])
    wrong = body.with_part("ft", replace(body.part("ft"), values=values))
    sense = WristWrenches.make(np.ones((3, 4)), np.zeros((3, 6)), "sensor", "up", sensor="ft")
    assert sense.predict(wrong) == pytest.approx(1.01 * sense.predict(body) + values[:6])


def test_the_start_finds_load_offset_and_mounting_of_exact_samples() -> None:
    body = arm()
    rng = np.random.default_rng(4)
    mounted = lie.transform(lie.exp_so3([2.0, -0.5, 1.0]), [0.01] * 3)
    bias = np.array([3.0, -2.0, 1.0, 0.1, 0.2, -0.1, *[0.0] * 6])
    truth = body.with_placement("sensor", mounted)
    truth = truth.with_part("ft", replace(body.part("ft"), values=bias))
    q, dq, ddq = (rng.uniform(-3, 3, (30, 4)) for _ in range(3))
    rest = WristWrenches.make(q, np.zeros((30, 6)), "sensor", "up", (1e-3, 1e-4), sensor="ft")
    rest = replace(rest, observed=rest.predict(truth))
    unknown = body.with_part("load", parts.load())
    found = rest.start(unknown, ("sensor", "load", "ft"))
    assert found is not None
    T = found.placement[body.frame_index("sensor")]
    assert np.linalg.norm(lie.log_so3(T[:3, :3] @ mounted[:3, :3].T)) < 1e-6
    assert found.part("ft").values[:6] == pytest.approx(bias[:6], abs=1e-4)
    assert found.part("load").values[0] == pytest.approx(log_cholesky(BOX.phi)[0], abs=1e-5)
    moving = replace(rest, dq=dq, ddq=ddq)
    moving = replace(moving, observed=moving.predict(truth))
    found = moving.start(truth.with_part("load", parts.load()), ("load",))
    assert found is not None
    assert found.part("load").values == pytest.approx(log_cholesky(BOX.phi), abs=1e-3)
    assert rest.start(unknown, ()) is None


def test_half_a_motion_is_refused() -> None:
    sense, *_ = felt(True)
    with pytest.raises(InputError, match="both dq and ddq"):
        replace(sense, ddq=None)
    with pytest.raises(InputError, match="should have shape"):
        replace(sense, ddq=np.zeros((N, 3)))


def test_the_motion_of_a_frame_is_that_of_its_pose() -> None:
    body = Body.random_chain(3, np.random.default_rng(5))
    kind = body.kind.copy()
    kind[2] = 2  # the second joint slides
    body, free = replace(body, kind=kind), free_joints(body, ("offsets", "axes"))
    rng = np.random.default_rng(6)
    motion = Motion(*(rng.uniform(-1, 1, (4, 3)) for _ in range(3)))
    h = 1e-3

    def at(t: float) -> Array:
        q = motion.q + t * motion.dq + t * t / 2 * motion.ddq
        return relative_pose(body, q, "base", "tip")

    found = frame_motion(body, motion, "tip")
    R = at(0)[:, :3, :3]
    bend = (at(h) - 2 * at(0) + at(-h))[:, :3, 3] / h**2
    assert found.a == pytest.approx(np.einsum("nji,nj->ni", R, bend), abs=1e-5)
    turned = [lie.log_so3(np.swapaxes(R, 1, 2) @ at(t)[:, :3, :3]) for t in (h, -h)]
    assert found.w == pytest.approx((turned[0] - turned[1]) / (2 * h), abs=1e-5)
    assert found.dw == pytest.approx((turned[0] + turned[1]) / h**2, abs=1e-5)
    slopes = motion_derivatives(body, free, np.zeros(len(free)), motion, "tip")
    assert slopes.by_parameter.shape == (4, 9, len(free))
