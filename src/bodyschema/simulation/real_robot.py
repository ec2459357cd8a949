"""The real robot: MuJoCo's kinematics of a URDF, with joint offsets that its encoders do not see.

    true joint angle = encoder reading + offset

The poses come from MuJoCo's own reader and kinematics, not from `bodyschema.model`, so that a
calibration against them is a test of both. Meshes are left out: nothing is rendered or touched.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bodyschema import lie
from bodyschema.errors import InputError, MissingExtraError, did_you_mean

Array = NDArray[np.float64]


class RealRobot:
    """A robot that moves as it is built, not as it is modelled."""

    def __init__(
        self,
        urdf: bytes,
        frames: Mapping[str, tuple[str, Array]],
        joints: Sequence[str],
        offsets: Mapping[str, float],
    ) -> None:
        """Build the robot.

        Args:
            urdf: description of links, joints and inertias.
            frames: parent and true (4, 4) T_parent_frame of what is mounted on the links.
            joints: order of the columns of every reading.
            offsets: true angle minus encoder reading, by joint, rad; 0 where not named.

        Raises:
            InputError: an offset names no joint.
            MissingExtraError: MuJoCo is not installed.
        """
        try:
            import mujoco
        except ImportError:
            raise MissingExtraError("mujoco", "sim", "the simulated robot") from None
        for name in offsets:
            if name not in joints:
                raise InputError(f"no joint '{name}' to be off{did_you_mean(name, joints)}")
        self._kinematics = mujoco.mj_kinematics
        self._model: Any = mujoco.MjModel.from_xml_string(bare_description(urdf, frames))
        self._data: Any = mujoco.MjData(self._model)
        self._columns = np.array([self._model.joint(name).qposadr[0] for name in joints])
        self._offset = np.array([offsets.get(name, 0.0) for name in joints])

    def poses(self, readings: ArrayLike, a: str, frames: Sequence[str]) -> Array:
        """True T_a_b of each frame b: readings (n, n_joints) rad -> (n, n_frames, 4, 4)."""
        q = np.atleast_2d(np.asarray(readings, dtype=np.float64))
        bodies = [self._model.body(name).id for name in (a, *frames)]
        T_world = np.zeros((len(q), len(bodies), 4, 4))
        T_world[..., 3, 3] = 1.0
        for i, angles in enumerate(q + self._offset):
            self._data.qpos[self._columns] = angles
            self._kinematics(self._model, self._data)
            T_world[i, :, :3, 3] = self._data.xpos[bodies]
            T_world[i, :, :3, :3] = self._data.xmat[bodies].reshape(-1, 3, 3)
        return np.asarray(lie.inverse(T_world[:, :1]) @ T_world[:, 1:])


def bare_description(urdf: bytes, frames: Mapping[str, tuple[str, Array]]) -> str:
    """The URDF with links, joints and inertias only, and more fixed frames, for MuJoCo."""
    robot = ET.fromstring(urdf)
    for element in list(robot):
        if element.tag not in ("link", "joint"):
            robot.remove(element)
        for part in [part for part in element if part.tag in ("visual", "collision")]:
            element.remove(part)
    # Without fusestatic="false" MuJoCo merges every link behind a fixed joint into its parent.
    # It wants a mass for every link, also where only kinematics are asked for.
    compiler = {"fusestatic": "false", "boundmass": "0.001", "boundinertia": "0.000001"}
    ET.SubElement(ET.SubElement(robot, "mujoco"), "compiler", compiler)
    for name, (parent, placement) in frames.items():
        ET.SubElement(robot, "link", name=name)
        joint = ET.SubElement(robot, "joint", name=f"{name}_joint", type="fixed")
        xyz, rpy = placement[:3, 3], lie.rpy_from_rotation(placement[:3, :3])
        ET.SubElement(joint, "origin", xyz=_words(xyz), rpy=_words(rpy))
        ET.SubElement(joint, "parent", link=parent)
        ET.SubElement(joint, "child", link=name)
    return ET.tostring(robot, encoding="unicode")


def _words(values: Array) -> str:
    return " ".join(repr(float(value)) for value in values)
