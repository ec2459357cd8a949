"""What every sense must keep: a new one joins by one line in SENSES."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.model import parts
from bodyschema.model.camera import Camera
from bodyschema.model.inertia import Inertia
from bodyschema.model.kinematics import relative_pose
from bodyschema.model.tree import Body
from bodyschema.model.variables import Variables, free_frame, free_joints, free_part, join
from bodyschema.senses.distances import Distances
from bodyschema.senses.gravity import Gravity
from bodyschema.senses.mean_wrenches import MeanWrenches
from bodyschema.senses.pixels import Pixels
from bodyschema.senses.planes import Planes
from bodyschema.senses.points import Points
from bodyschema.senses.poses import Poses
from bodyschema.senses.sense import Linearized, Sense, check_samples
from bodyschema.senses.torques import Torques
from bodyschema.senses.touches import Touches
from bodyschema.senses.wrenches import load_regressor
from bodyschema.senses.wrist_wrenches import WristWrenches
from bodyschema.testing import check_sense

Array = NDArray[np.float64]

N, V = 6, np.array([0.1, -0.2, 0.3])
RATE = np.random.default_rng(4).normal(size=(N, 4))


@dataclass(frozen=True)
class WireLengths(Sense):
    """A sense as a user writes it: without derivatives, starts or words of its own."""

    measures = (("length", "m", 1),)

    def predict(self, body: Body) -> Array:
        T = relative_pose(body, self.readings(body), self.seen_from, self.seen)
        return np.linalg.norm(T[:, :3, 3], axis=1)


moving = {"dq": RATE, "ddq": RATE[::-1]}
late = {"clock": "clock", "rate": RATE}
SENSES: dict[str, Callable[[Array], Sense]] = {
    "points": lambda q: Points.make(q, np.zeros((N, 3)), "eye", "tip"),
    "late points": lambda q: Points.make(q, np.zeros((N, 3)), "eye", "tip", **late),
    "poses": lambda q: Poses.make(q, np.tile(np.eye(4), (N, 1, 1)), "eye", "tip"),
    "touches": lambda q: Touches.make(q, np.zeros((N, 3)), V, "eye", "tip"),
    "pixels": lambda q: Pixels.make(q, np.zeros((N, 2)), "eye", "tip", "lens"),
    "pixels of a board": lambda q: Pixels.make(
        q, np.zeros((N, 2)), "eye", "tip", "lens", BOARD, "board", **late
    ),
    "distances": lambda q: Distances.make(q, 1.0, "eye", "tip"),
    "distances of points": lambda q: Distances.make(q, 1.0, "eye", "tip", V, -V, "wire", **late),
    "planes": lambda q: Planes.make(q, "eye", "tip", 0.02),
    "planes under a point": lambda q: Planes.make(q, "eye", "tip", 0.02, V, **late),
    "gravity": lambda q: Gravity.make(q, np.tile([0, 0, 9.81], (N, 1)), "eye", "tip"),
    "gravity of a sensor": lambda q: Gravity.make(
        q, np.tile([0, 0, 9.81], (N, 1)), "tip", "eye", "imu", **late
    ),
    "wrenches at rest": lambda q: WristWrenches.make(q, np.zeros((N, 6)), "tip", "eye"),
    "wrenches in motion": lambda q: WristWrenches.make(
        q, np.zeros((N, 6)), "tip", "eye", sensor="ft", loads=("load", "tool"), **moving, **late
    ),
    "mean wrenches": lambda q: MeanWrenches.make(
        q, np.zeros((N, 6)), "tip", "eye", (0.05, 0.002), sensor="ft", regressor=REGRESSOR
    ),
    "torques": lambda q: Torques.make(
        q,
        np.zeros((N, 4)),
        {"link_2": "tool", "tip": "load"},
        "base",
        "eye",
        **moving,
        drive="motors",
        **late,
    ),
    "a user's own": lambda q: WireLengths.make(q, np.zeros(N), "eye", "tip", 1e-3),
}
"""Name -> samples at postures q (N, 4), whatever was seen; frames and parts are those of `body`."""

SWINGS = np.random.default_rng(6).normal(size=(3, N, 3))
REGRESSOR = load_regressor(SWINGS[0] + [0.0, 0.0, 9.81], SWINGS[1], SWINGS[2])
BOARD = 0.1 * np.random.default_rng(3).uniform(-1, 1, (N, 3))
CAMERA = Camera("eye", "eye", 640, 480, np.array([[500.0, 0, 320], [0, 510, 240], [0, 0, 1]]))


@pytest.fixture(scope="module")
def body() -> Body:
    """An eye on the first link looks at the tip of the same arm: up-paths and down-paths."""
    arm = Body.random_chain(4, np.random.default_rng(0))
    tip = relative_pose(arm, np.zeros(4), "link_1", "tip")[:3, 3]
    R = lie.exp_so3([0.3, 0.2, 0.9])
    arm = arm.attach("eye", "link_1", lie.transform(R, tip - R @ [0.1, 0.1, 1.0]))
    bent = replace(CAMERA, distortion=np.array([-0.2, 0.05, 1e-3, -2e-3, 0.01]))
    made = {
        "lens": parts.lens(bent),
        "board": parts.target(1.02),
        "clock": parts.clock(0.02),
        "wire": parts.sensor(("length",), ("m",), 0.1),
        "imu": parts.accelerometer(),
        "ft": parts.force_sensor(),
        "load": parts.load(),
        "tool": parts.load(Inertia(0.6, np.array([0.02, -0.02, 0.1]), np.diag([3e-3] * 3))),
        "motors": parts.drive(arm.joints),
    }
    for name, part in made.items():
        arm = arm.with_part(name, part)
    return arm


@pytest.fixture(scope="module")
def variables(body: Body) -> Variables:
    """Everything that may be wrong with it."""
    frames = [free_frame(body, frame, 0.1, 0.2) for frame in ("eye", "tip")]
    return join(free_joints(body), *frames, *(free_part(body, part) for part in body.parts))


def seen(name: str, body: Body) -> Sense:
    """Samples of one kind with noise, at postures in which the eye sees the tip."""
    q = np.random.default_rng(2).uniform(-0.4, 0.4, (N, 4))
    sense = SENSES[name](q)
    shown = sense.predict(body)
    if isinstance(sense, Poses):
        return replace(sense, observed=shown)
    noise = np.random.default_rng(5).normal(size=shown.shape)
    return replace(sense, observed=shown + noise * np.sqrt(np.diag(sense.covariance)))


@pytest.mark.parametrize("name", SENSES)
def test_a_sense_keeps_its_promises(name: str, body: Body, variables: Variables) -> None:
    check_sense(seen(name, body), body, variables)


@pytest.mark.parametrize("name", SENSES)
def test_a_wrong_body_leaves_a_residual(name: str, body: Body, variables: Variables) -> None:
    sense, x = seen(name, body), 0.1 * variables.scale
    noise = np.sqrt(np.diag(sense.covariance))
    assert np.abs(sense.residual(body) / noise).max() < 4
    assert np.abs(sense.residual(body.with_variables(variables, x)) / noise).max() > 5


@dataclass(frozen=True)
class Broken(Points):
    """Points whose derivatives, samples or words are not in order."""

    fault: str = field(default="", kw_only=True)
    memory: list[int] = field(default_factory=list, kw_only=True)

    def __post_init__(self) -> None:
        if self.fault != "takes anything":
            check_samples(self, self.observed, (3,))

    @property
    def label(self) -> str:
        return " " if self.fault == "no name" else super().label

    @property
    def components(self) -> tuple[tuple[str, str, slice], ...]:
        whole = (("position", "m", slice(0, 3)),)
        return (("position", "m", slice(0, 2)),) if self.fault == "half covered" else whole

    @property
    def shows(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        shown = super().shows
        return (shown[0][:3], shown[1]) if self.fault == "hides a turn" else shown

    def residual(self, body: Body) -> Array:
        self.memory.append(1)
        drift = 1e-10 * len(self.memory) if self.fault == "remembers" else 0.0
        return super().residual(body) + drift + (0.1 if self.fault == "is never right" else 0.0)

    def linearize(self, reference: Body, variables: Variables, x: Array) -> Linearized:
        linear = super().linearize(reference, variables, x)
        columns = linear.by_joint if self.fault == "wrong by joint" else linear.by_parameter
        if self.fault.startswith("wrong"):
            columns[2:3, 1, 1] *= 1.001
        if self.fault == "spoils its data":
            self.q[0, 0] += 1e-3
        return linear

    def imagined(self, body: Body, q: Any) -> Any:
        there = super().imagined(body, q)
        return there.take(slice(1, None)) if self.fault == "forgets one" else there


FAULTS = {
    "takes anything": "it takes a time that is no number",
    "no name": "`label` is empty",
    "half covered": r"should cover each of the 3 rows once; they cover \[0, 1\]",
    "hides a turn": r"leaves out turn_x, turn_y, turn_z of eye",
    "remembers": "asked twice with the same body",
    "is never right": "exactly as predicted, `residual` leaves 0.1",
    "wrong by parameter": "derivative by variable joint_2.offset .* in sample 2, row 1",
    "wrong by joint": "derivative by reading joint_2",
    "spoils its data": "predicting has changed q|does not answer the same",
    "forgets one": "at the postures that are asked for",
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_broken_promise_is_told(fault: str, body: Body) -> None:
    good = seen("points", body)
    sense = Broken.make(good.q.copy(), good.observed, "eye", "tip", fault=fault)
    variables = join(
        free_joints(body, ["offsets"], ["joint_3", "joint_2"]), free_frame(body, "eye")
    )
    with pytest.raises(AssertionError, match=FAULTS[fault]):
        check_sense(sense, body, variables)
