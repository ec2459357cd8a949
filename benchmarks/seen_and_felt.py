"""A four-joint arm in MuJoCo that a camera and a tracker watch and that holds something.

Its pictures, marker positions and wrenches come from MuJoCo's own reader of the URDF, kinematics,
renderer and inverse dynamics; what the learner imagines takes no part in them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

import bodyschema as bs
import bodyschema.simulation
from bodyschema import lie
from bodyschema.model import parts
from bodyschema.model.camera import Camera
from bodyschema.model.inertia import Inertia

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

ARM = """<robot name="arm4">
  <mujoco><compiler discardvisual="false" fusestatic="false"/></mujoco>
  <link name="base"><visual><origin xyz="0 0 0.1"/><geometry>
    <box size="0.16 0.12 0.2"/></geometry></visual></link>
  <joint name="j1" type="revolute"><parent link="base"/><child link="shoulder"/>
    <origin xyz="0 0 0.2"/><axis xyz="0 0 1"/><limit lower="-0.6" upper="0.6"/></joint>
  <link name="shoulder"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01"
    ixy="0" ixz="0" iyz="0"/></inertial><visual><origin xyz="0 0 0.05"/><geometry>
    <cylinder radius="0.05" length="0.1"/></geometry></visual></link>
  <joint name="j2" type="revolute"><parent link="shoulder"/><child link="upper"/>
    <origin xyz="0 0 0.1"/><axis xyz="0 1 0"/><limit lower="-0.8" upper="0.8"/></joint>
  <link name="upper"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01"
    ixy="0" ixz="0" iyz="0"/></inertial><visual><origin xyz="0 0 0.175"/><geometry>
    <box size="0.07 0.06 0.35"/></geometry></visual></link>
  <joint name="j3" type="revolute"><parent link="upper"/><child link="forearm"/>
    <origin xyz="0 0 0.35"/><axis xyz="0 1 0"/><limit lower="0.2" upper="1.7"/></joint>
  <link name="forearm"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01"
    ixy="0" ixz="0" iyz="0"/></inertial><visual><origin xyz="0 0 0.15"/><geometry>
    <cylinder radius="0.03" length="0.3"/></geometry></visual></link>
  <joint name="j4" type="revolute"><parent link="forearm"/><child link="hand"/>
    <origin xyz="0 0 0.3"/><axis xyz="0 0 1"/><limit lower="-2.6" upper="2.6"/></joint>
  <link name="hand"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01"
    ixy="0" ixz="0" iyz="0"/></inertial><visual><origin xyz="0 0 0.04"/><geometry>
    <box size="0.07 0.04 0.08"/></geometry></visual></link>
</robot>"""

JOINTS = ("j1", "j2", "j3", "j4")
BOX = Inertia(0.6, np.array([0.03, -0.02, 0.07]), np.diag([3e-3, 2.4e-3, 1.6e-3]))
SENSOR = lie.transform(np.eye(3), [0.0, 0.0, 0.08])
MARKER = lie.transform(np.eye(3), [0.03, 0.0, 0.06])
GRAVITY = 9.81


def looking(eye: Array, at: Array) -> Array:
    """T_base_camera of an optical frame at one point that looks at another, (4, 4)."""
    z = (at - eye) / np.linalg.norm(at - eye)
    x = np.cross(z, [0.0, 0.0, 1.0])
    x /= np.linalg.norm(x)
    return lie.transform(np.column_stack([x, np.cross(z, x), z]), eye)


EYE = looking(np.array([1.0, -1.2, 0.7]), np.array([0.2, 0.0, 0.5]))
TRACKER = looking(np.array([-1.5, -1.0, 1.2]), np.array([0.2, 0.0, 0.5]))


def camera(width: int = 640, height: int = 480) -> Camera:
    """The view at any size."""
    return Camera.from_fov("camera", "camera", width, height, 2 * np.arctan(320 / 600))


def nominal(folder: Any) -> bs.Body:
    """The arm as drawn: camera, tracker, marker and sensor attached, load unknown.

    Args:
        folder: where its description is written.
    """
    path = folder / "arm4.urdf"
    path.write_text(ARM)
    body = bs.Body.from_urdf(path).attach("camera", "base", EYE).attach("tracker", "base", TRACKER)
    body = body.attach("marker", "hand", MARKER).attach("sensor", "hand", SENSOR)
    return body.with_part("load", parts.load()).with_part("ft", parts.force_sensor())


@dataclass(frozen=True)
class RealArm:
    """The arm as it is built."""

    offsets: Array
    """(4,) rad, true angle minus reading."""
    T_base_camera: Array
    T_base_tracker: Array
    marker: Array
    """(3,) m in the hand."""
    bias: Array
    """(6,) N and Nm, what the sensor reads without a load."""

    @cached_property
    def _world(self) -> tuple[Any, Any]:
        import mujoco

        spec = mujoco.MjSpec.from_string(ARM)
        spec.option.gravity = [0.0, 0.0, -GRAVITY]
        spec.visual.map.znear, spec.visual.quality.offsamples = 0.01, 0
        spec.stat.extent = 1.0
        held = spec.body("hand").add_body(
            name="object",
            pos=SENSOR[:3, 3],
            mass=BOX.mass,
            ipos=BOX.com,
            explicitinertial=True,
            fullinertia=BOX.moments[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]],
        )
        held.add_site(name="sensor")
        for kind in (mujoco.mjtSensor.mjSENS_FORCE, mujoco.mjtSensor.mjSENS_TORQUE):
            spec.add_sensor(type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname="sensor")
        spec.body("hand").add_site(name="marker", pos=self.marker)
        R = self.T_base_camera[:3, :3] @ np.diag([1.0, -1.0, -1.0])
        eye = spec.worldbody.add_camera(name="eye", pos=self.T_base_camera[:3, 3])
        eye.quat = lie.quaternion_xyzw(R)[[3, 0, 1, 2]]
        lens = camera()
        eye.fovy = 2 * np.rad2deg(np.arctan(lens.height / 2 / lens.matrix[1, 1]))
        spec.visual.global_.offwidth, spec.visual.global_.offheight = lens.width, lens.height
        model = spec.compile()
        return model, mujoco.MjData(model)

    def masks(self, q: Array, lens: Camera) -> list[Flags]:
        """Which pixels are the arm, at readings (n, 4)."""
        import mujoco

        model, data = self._world
        out = []
        with mujoco.Renderer(model, lens.height, lens.width) as renderer:
            renderer.enable_segmentation_rendering()
            for row in q + self.offsets:
                data.qpos[:] = row
                mujoco.mj_forward(model, data)
                renderer.update_scene(data, camera="eye")
                out.append(renderer.render()[..., 0] >= 0)
        return out

    def markers(self, q: Array) -> Array:
        """Where the marker is in the tracker's frame, (n, 3) m."""
        import mujoco

        model, data = self._world
        seen = np.empty((len(q), 3))
        for i, row in enumerate(q + self.offsets):
            data.qpos[:] = row
            mujoco.mj_forward(model, data)
            seen[i] = data.site("marker").xpos
        T = lie.inverse(self.T_base_tracker)
        return np.asarray(seen @ T[:3, :3].T + T[:3, 3])

    def wrenches(self, q: Array) -> Array:
        """What the sensor reads at rest, (n, 6) N and Nm."""
        import mujoco

        model, data = self._world
        felt = np.empty((len(q), 6))
        for i, row in enumerate(q + self.offsets):
            data.qpos[:], data.qvel[:], data.qacc[:] = row, 0.0, 0.0
            mujoco.mj_inverse(model, data)
            felt[i] = data.sensordata
        return felt + self.bias
