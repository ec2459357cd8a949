"""Kinematics against Pinocchio on every robot of example-robot-data and icub-models."""

from __future__ import annotations

import sysconfig
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from bodyschema import lie
from bodyschema.errors import InputError
from bodyschema.model.kinematics import frame_jacobian, frame_poses, relative_pose
from bodyschema.model.tree import Body

pin = pytest.importorskip("pinocchio")
icub_models = pytest.importorskip("icub_models")

Array = NDArray[np.float64]

EXAMPLES = Path(sysconfig.get_path("purelib"), "cmeel.prefix/share/example-robot-data/robots")
ICUBS = Path(icub_models.get_models_path())
REFUSED = {
    "alex_psyonic_hands": "mimics 'index_q1', which is no moving joint; did you mean",
    "ur3": "must have one root link, it has 0",
}
"""Broken files: fingers that follow joints that do not exist, and a xacro macro unexpanded."""

FILES = [
    path
    for folder in (EXAMPLES, ICUBS)
    for path in sorted(folder.rglob("*.urdf"))
    if path.stem not in REFUSED
]

LEADER_COMES_LATER = ("romeo", "talos_full_v2", "talos_full_v2_box")
"""Pinocchio follows a mimic only to a joint that comes before; these have their values fed in."""

TOLERANCE = 1e-10
"""m, rad, or 1: the robots are about one metre large."""


@dataclass(frozen=True)
class Robot:
    """One robot as both libraries read it; Pinocchio's has every joint free of its mimic."""

    body: Body
    model: Any
    data: Any
    mimics: dict[str, tuple[str, float, float]]
    """Joint -> (joint it follows, multiplier, offset), as written in the file."""

    def values(self, q: Array) -> dict[str, float]:
        """The value of every moving joint, mimics worked out here and not by the library."""
        known = dict(zip(self.body.joints, q.tolist(), strict=True))

        def value(joint: str) -> float:
            if joint not in self.mimics:
                return known[joint]
            leader, rate, shift = self.mimics[joint]
            return rate * value(leader) + shift

        return {joint: value(joint) for joint in [*known, *self.mimics]}

    def columns(self) -> Array:
        """(n_joints, nv): how fast each of Pinocchio's velocities follows each joint."""
        zero, n = self.values(np.zeros(len(self.body.joints))), len(self.body.joints)
        rates = np.zeros((n, self.model.nv))
        for j in range(n):
            for name, moved in self.values(np.eye(n)[j]).items():
                rates[j, self.model.joints[self.model.getJointId(name)].idx_v] = moved - zero[name]
        return rates

    def compute(self, q: Array) -> None:
        """Poses and Jacobians at q, left in `data`."""
        full = configuration(self.model, self.values(q))
        pin.computeJointJacobians(self.model, self.data, full)
        pin.updateFramePlacements(self.model, self.data)

    def pose(self, frame: str) -> Array:
        """T_root_frame."""
        return np.array(self.data.oMf[self.frame(frame)].homogeneous)

    def jacobian(self, frame: str) -> Array:
        """(6, n_joints) in the root frame, linear before angular, at the frame's origin."""
        if not self.model.nv:
            return np.zeros((6, 0))  # Pinocchio crashes here
        J = pin.getFrameJacobian(self.model, self.data, self.frame(frame), pin.LOCAL_WORLD_ALIGNED)
        return np.asarray(J @ self.columns().T)

    def frame(self, name: str) -> int:
        return int(self.model.getFrameId(name, pin.FrameType.BODY))


def configuration(model: Any, values: dict[str, float]) -> Array:
    """Pinocchio's q: continuous joints take a cosine and a sine."""
    full = pin.neutral(model)
    for name, value in values.items():
        joint = model.joints[model.getJointId(name)]
        if joint.nq == 2:
            full[joint.idx_q : joint.idx_q + 2] = np.cos(value), np.sin(value)
        elif joint.nq == 1:
            full[joint.idx_q] = value
    return np.asarray(full)


def read(path: Path) -> Robot:
    mimics = {}
    for joint in ET.parse(path).getroot().findall("joint"):
        mimic = joint.find("mimic")
        if mimic is not None and joint.get("type") != "fixed":
            rate, shift = mimic.get("multiplier", "1"), mimic.get("offset", "0")
            mimics[joint.get("name", "")] = (mimic.get("joint", ""), float(rate), float(shift))
    model = pin.buildModelFromUrdf(str(path), mimic=False)
    return Robot(Body.from_urdf(path), model, model.createData(), mimics)


def postures(body: Body) -> Array:
    """Zero and three random postures, joints up to 2 rad or m away from zero."""
    n = len(body.joints)
    return np.vstack([np.zeros((1, n)), np.random.default_rng(0).uniform(-2, 2, (3, n))])


def name_of(path: Path) -> str:
    return f"{path.parent.name}-{path.stem}" if ICUBS in path.parents else path.stem


robots = pytest.mark.parametrize("path", FILES, ids=name_of)


@robots
def test_frame_poses(path: Path) -> None:
    robot = read(path)
    assert set(robot.values(postures(robot.body)[0])) == set(robot.model.names[1:])
    worst = 0.0
    for q in postures(robot.body):
        robot.compute(q)
        poses = frame_poses(robot.body, q)
        errors = [poses[k] - robot.pose(frame) for k, frame in enumerate(robot.body.frames)]
        worst = max(worst, np.abs(errors).max())
    assert worst < TOLERANCE


@robots
def test_frame_poses_with_pinocchios_own_mimics(path: Path) -> None:
    robot = read(path)
    if path.stem in LEADER_COMES_LATER:
        with pytest.raises(ValueError, match="mimic joint is not in the kinematic tree"):
            pin.buildModelFromUrdf(str(path), mimic=True)
        return
    model = pin.buildModelFromUrdf(str(path), mimic=True)
    data, q = model.createData(), postures(robot.body)[-1]
    values = dict(zip(robot.body.joints, q.tolist(), strict=True))
    pin.framesForwardKinematics(model, data, configuration(model, values))
    poses = frame_poses(robot.body, q)
    for k, frame in enumerate(robot.body.frames):
        oracle = data.oMf[model.getFrameId(frame, pin.FrameType.BODY)].homogeneous
        assert np.abs(poses[k] - oracle).max() < TOLERANCE, frame


@robots
def test_jacobians_from_the_root(path: Path) -> None:
    robot, rng = read(path), np.random.default_rng(1)
    body = robot.body
    leaves = [f for k, f in enumerate(body.frames) if k not in body.parent][:6]
    worst = 0.0
    for q in postures(body)[1:]:
        robot.compute(q)
        for frame in [*leaves, *rng.choice(body.frames, 6)]:
            J = frame_jacobian(body, q, body.frames[0], str(frame))
            worst = max(worst, np.abs(J - robot.jacobian(str(frame))).max(initial=0.0))
    assert worst < TOLERANCE


@robots
def test_pairs_of_frames(path: Path) -> None:
    """Up one branch and down another: T_a_b and its Jacobian from those of the root."""
    robot, rng = read(path), np.random.default_rng(2)
    worst = 0.0
    for q in postures(robot.body):
        robot.compute(q)
        for a, b in rng.choice(robot.body.frames, (8, 2)):
            T_a, T_b = robot.pose(a), robot.pose(b)
            pose = np.linalg.inv(T_a) @ T_b
            worst = max(worst, np.abs(relative_pose(robot.body, q, a, b) - pose).max())
            J = seen_from(T_a, T_b, robot.jacobian(a), robot.jacobian(b))
            error = frame_jacobian(robot.body, q, a, b) - J
            worst = max(worst, np.abs(error).max(initial=0.0))
    assert worst < TOLERANCE


def seen_from(T_a: Array, T_b: Array, J_a: Array, J_b: Array) -> Array:
    """The Jacobian of b as an observer in a sees it, who moves with a."""
    R = T_a[:3, :3].T
    carried = lie.skew(T_b[:3, 3] - T_a[:3, 3]) @ J_a[3:]
    return np.vstack([R @ (J_b[:3] - J_a[:3] + carried), R @ (J_b[3:] - J_a[3:])])


@pytest.mark.parametrize("name", REFUSED)
def test_broken_files_are_refused(name: str) -> None:
    with pytest.raises(InputError, match=REFUSED[name]):
        Body.from_urdf(next(EXAMPLES.rglob(f"{name}.urdf")))


def test_many_robots_are_compared() -> None:
    """Every file is compared: a test above fails, and never skips, where a reader refuses one."""
    print(f"{len(FILES)} robots compared with Pinocchio {pin.__version__}")
    assert len(FILES) >= 65
    assert sum(bool(read(path).mimics) for path in FILES) >= 8
