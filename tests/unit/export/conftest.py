"""A small calibration, made once, and a URDF robot that has everything a URDF may have."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

import bodyschema
from bodyschema import lie
from bodyschema.export.urdf_writer import write_urdf
from bodyschema.judging.calibration import Calibration
from bodyschema.model.tree import Body
from bodyschema.model.urdf import parse_urdf

ROBOT = b"""<?xml version="1.0"?>
<!-- an arm on a rail with a gripper -->
<robot name="railarm">
  <link name="base"/> <link name="sled"/> <link name="upper"/> <link name="fore"/>
  <link name="mount"/> <link name="finger_l"/> <link name="finger_r"/> <link name="wheel"/>
  <joint name="rail" type="prismatic">
    <origin xyz="0 0 0.5" rpy="0 1.5707963267948966 0"/> <!-- gimbal lock -->
    <parent link="base"/> <child link="sled"/>
    <axis xyz="0 0 -1"/>
    <limit lower="0" upper="1.5" effort="9" velocity="1"/>
  </joint>
  <joint name="shoulder" type="revolute">
    <origin xyz="0.1 0.2 0.3" rpy="0.1 -0.2 3.1"/>
    <parent link="sled"/> <child link="upper"/>
    <limit lower="-1.5" upper="1.5" effort="9" velocity="1"/>
    <safety_controller k_velocity="10" soft_lower_limit="-1.4" soft_upper_limit="1.4"/>
  </joint>
  <joint name="elbow" type="continuous">
    <origin xyz="0.4 0 0"/>
    <parent link="upper"/> <child link="fore"/>
    <axis xyz="0 3 4"/>
    <limit lower="-3" upper="3" effort="9" velocity="1"/>
  </joint>
  <joint name="mount_joint" type="fixed">
    <parent link="fore"/> <child link="mount"/>
  </joint>
  <joint name="finger_l" type="prismatic">
    <parent link="mount"/> <child link="finger_l"/>
    <axis xyz="0 1 0"/>
    <limit lower="0" upper="0.04" effort="9" velocity="1"/>
  </joint>
  <joint name="finger_r" type="prismatic">
    <origin xyz="0 0.01 0" rpy="0 0 1"/>
    <parent link="mount"/> <child link="finger_r"/>
    <axis xyz="0 1 0"/>
    <limit upper="0.05" effort="9" velocity="1"/>
    <mimic joint="finger_l" multiplier="-2" offset="0.003"/>
  </joint>
  <joint name="wheel" type="revolute">
    <parent link="mount"/> <child link="wheel"/>
    <limit lower="-1" upper="2" effort="9" velocity="1"/>
    <mimic joint="finger_r" multiplier="7" offset="-0.2"/>
  </joint>
  <gazebo reference="fore"><joint name="elbow"/></gazebo>
</robot>
"""


@dataclass(frozen=True)
class Case:
    """A calibration of a robot whose offsets are known."""

    calibration: Calibration
    nominal: Body
    """Without the frames that were attached."""
    source: bytes
    """The URDF of the nominal body."""
    truth: Body


@pytest.fixture(scope="session")
def robot() -> bytes:
    """A URDF with a rail, negative rates, a chain of mimics and soft limits."""
    return ROBOT


@pytest.fixture(scope="session")
def case() -> Case:
    """A random arm of four joints, wrong in its offsets, seen by an unknown camera."""
    rng = np.random.default_rng(3)
    source = write_urdf(Body.random_chain(4, rng))
    nominal = parse_urdf(source, Path("arm.urdf"), {})
    body = nominal.attach("camera", "base").attach("marker", "tip")
    free = bodyschema.free_joints(body, ["offsets"])
    T_base_camera = lie.transform(lie.exp_so3([0.3, -2.0, 0.5]), [0.2, 1.0, 0.7])
    truth = body.with_variables(free, rng.uniform(-0.08, 0.08, 4))
    truth = truth.with_placement("camera", T_base_camera)
    truth = truth.with_placement("marker", lie.transform(np.eye(3), [0.03, 0.01, 0.06]))
    q = rng.uniform(-2, 2, (40, 4))
    seen = bodyschema.Points.make(q, np.zeros((40, 3)), "camera", "marker").imagined(truth, q)
    noisy = replace(seen, observed=seen.position + rng.normal(0, 1e-4, (40, 3)))
    calibration = bodyschema.calibrate(body, [noisy], {"camera": "no", "marker": "no"}, ["offsets"])
    return Case(calibration, nominal, source, truth)


@pytest.fixture(scope="session")
def worst_pose() -> Callable[[Body, Body], float]:
    """Largest difference of any number of any pose of the frames that the first body has."""
    from bodyschema.model.kinematics import frame_poses

    def difference(one: Body, other: Body, seed: int = 0) -> float:
        q = np.random.default_rng(seed).uniform(-3, 3, (20, len(one.joints)))
        columns = [one.joints.index(joint) for joint in other.joints]
        rows = [other.frame_index(frame) for frame in one.frames]
        apart = frame_poses(one, q) - frame_poses(other, q[:, columns])[:, rows]
        return float(np.abs(apart).max())

    return difference
